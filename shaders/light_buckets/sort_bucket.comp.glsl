// Puts the lights of each cell into the order of their numbers, so that sums over them are the same in every run. One
// thread per cell; cells too crowded for that are sorted by the whole workgroup, one after the other.
#include "common/frame.glsl"
#include "common/dispatch.glsl"

layout(local_size_x = WORKGROUP_SIZE) in;
layout(set = 0, binding = 1, std430) readonly buffer CellRanks { uint cell_ranks[]; };
layout(set = 0, binding = 2, std430) readonly buffer BucketStarts { uint bucket_starts[]; };
layout(set = 0, binding = 3, std430) coherent buffer BucketLights { uint bucket_lights[]; };

// Most lights that one thread sorts.
const uint SORTED_ALONE = 256u;

shared uint crowded_count;
shared uint crowded[WORKGROUP_SIZE];

void sort_alone(uint first, uint end) {
    for (uint i = first + 1u; i < end; ++i) {
        uint light = bucket_lights[i];
        uint slot = i;
        for (; slot > first && bucket_lights[slot - 1u] > light; --slot) {
            bucket_lights[slot] = bucket_lights[slot - 1u];
        }
        bucket_lights[slot] = light;
    }
}

// Batcher's bitonic sort in the form that compares upwards only: what would lie beyond the end stays there. All threads
// must call.
void sort_together(uint first, uint count) {
    for (uint block = 2u; block < 2u * count; block *= 2u) {
        for (uint apart = block - 1u; apart > 0u; apart = apart == block - 1u ? block / 4u : apart / 2u) {
            for (uint i = gl_LocalInvocationIndex; i < count; i += WORKGROUP_SIZE) {
                uint other = i ^ apart;
                if (other > i && other < count) {
                    uint low = bucket_lights[first + i];
                    uint high = bucket_lights[first + other];
                    bucket_lights[first + i] = min(low, high);
                    bucket_lights[first + other] = max(low, high);
                }
            }
            memoryBarrierBuffer();
            barrier();
        }
    }
}

void main() {
    crowded_count = 0u;
    barrier();
    uint bucket = linear_thread();
    if (bucket < cell_ranks[cell_ranks.length() - 1]) {
        uint first = bucket_starts[bucket];
        uint end = bucket_starts[bucket + 1u];
        if (end - first <= SORTED_ALONE) {
            sort_alone(first, end);
        } else {
            crowded[atomicAdd(crowded_count, 1u)] = bucket;
        }
    }
    barrier();
    uint count = crowded_count;
    for (uint i = 0u; i < count; ++i) {
        uint first = bucket_starts[crowded[i]];
        sort_together(first, bucket_starts[crowded[i] + 1u] - first);
    }
}
