// Counts the words by which the sums of S1 differ when they are updated and when they are built anew. One thread per vertex.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/lights.glsl"
#include "common/dispatch.glsl"

layout(local_size_x = WORKGROUP_SIZE) in;
layout(set = 0, binding = 1, std430) readonly buffer LevelTable { uint level_table[]; };
layout(set = 0, binding = 2, std430) readonly buffer Moments { uint moments[]; };
layout(set = 0, binding = 3, std430) readonly buffer UpdatedMoments { uint updated_moments[]; };
layout(set = 0, binding = 4, std430) buffer UpdateCounts { uint update_counts[]; };

#include "common/level_table.glsl"

void main() {
    uint record = linear_thread();
    if (record >= level_count(1u)) {
        return;
    }
    uint differing = 0u;
    for (uint word = record * MOMENT_WORDS; word < (record + 1u) * MOMENT_WORDS; ++word) {
        differing += moments[word] != updated_moments[word] ? 1u : 0u;
    }
    if (differing > 0u) {
        atomicAdd(update_counts[2], differing);
    }
}
