// Brings the sums of S1's vertices from where they stood in the last build to where they stand in this one; new vertices begin with 0.
// One thread per vertex.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/lights.glsl"
#include "common/dispatch.glsl"

layout(local_size_x = WORKGROUP_SIZE) in;
layout(set = 0, binding = 1, std430) readonly buffer GridLights { GridLight grid_lights[]; };
layout(set = 0, binding = 2, std430) readonly buffer LevelTable { uint level_table[]; };
layout(set = 0, binding = 3, std430) readonly buffer KeptOccupancy { uint kept_occupancy[]; };
layout(set = 0, binding = 4, std430) readonly buffer KeptRanks { uint kept_ranks[]; };
layout(set = 0, binding = 5, std430) readonly buffer KeptMoments { uvec4 kept_moments[]; };
layout(set = 0, binding = 6, std430) writeonly buffer Moments { uvec4 moments[]; };

#include "common/level_table.glsl"

const uint VECTORS = MOMENT_WORDS / 4u;

// Record of a vertex in the last build, in which all had room, or NO_LIGHT.
uint kept_record(uvec3 vertex) {
    uint word = occupancy_word(vertex, 1u);
    uint bit = 1u << (vertex.x % 32u);
    uint bits = kept_occupancy[word];
    return (bits & bit) != 0u ? kept_ranks[word] + uint(bitCount(bits & (bit - 1u))) : NO_LIGHT;
}

void main() {
    uint record = linear_thread();
    if (record >= level_count(1u)) {
        return;
    }
    uint kept = kept_record(vertex_from_index(grid_lights[record].vertex, 1u));
    for (uint i = 0u; i < VECTORS; ++i) {
        moments[record * VECTORS + i] = kept != NO_LIGHT ? kept_moments[kept * VECTORS + i] : uvec4(0u);
    }
}
