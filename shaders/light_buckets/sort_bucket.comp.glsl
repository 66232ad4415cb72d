// Puts the lights of each cell into the order of their numbers, so that sums over them are the same in every run.
// Cells of more than SORTED_LIGHTS stay as they are: sorting them would take one thread too long. One thread
// per cell.
#include "common/frame.glsl"
#include "common/dispatch.glsl"

layout(local_size_x = WORKGROUP_SIZE) in;
layout(set = 0, binding = 1, std430) readonly buffer CellRanks { uint cell_ranks[]; };
layout(set = 0, binding = 2, std430) readonly buffer BucketStarts { uint bucket_starts[]; };
layout(set = 0, binding = 3, std430) buffer BucketLights { uint bucket_lights[]; };

const uint SORTED_LIGHTS = 256u;

void main() {
    uint bucket = linear_thread();
    if (bucket >= cell_ranks[cell_ranks.length() - 1]) {
        return;
    }
    uint first = bucket_starts[bucket];
    uint end = bucket_starts[bucket + 1u];
    for (uint i = first + 1u; i < end && end - first <= SORTED_LIGHTS; ++i) {
        uint light = bucket_lights[i];
        uint slot = i;
        for (; slot > first && bucket_lights[slot - 1u] > light; --slot) {
            bucket_lights[slot] = bucket_lights[slot - 1u];
        }
        bucket_lights[slot] = light;
    }
}
