// Stream compaction: gives every occupied vertex its place in the grid lights and notes vertex and level there.
// One thread per word of occupancy bits.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/lights.glsl"
#include "common/dispatch.glsl"

layout(local_size_x = WORKGROUP_SIZE) in;
layout(set = 0, binding = 1, std430) readonly buffer Occupancy { uint occupancy[]; };
layout(set = 0, binding = 2, std430) readonly buffer Ranks { uint ranks[]; };
layout(set = 0, binding = 3, std430) readonly buffer LevelTable { uint level_table[]; };
layout(set = 0, binding = 4, std430) writeonly buffer GridLights { GridLight grid_lights[]; };
layout(push_constant) uniform Push { uint first_marked; uint last_marked; };

#include "common/level_table.glsl"

void main() {
    uint word = first_word(first_marked) + linear_thread();
    if (word >= end_word(last_marked)) {
        return;
    }
    uint level = first_marked;
    while (word >= end_word(level)) {
        ++level;
    }
    uint row = (word - first_word(level)) / words_per_row(level);
    uint column = (word - first_word(level)) % words_per_row(level);
    uint target = level_first(level) + ranks[word] - ranks[first_word(level)];
    for (uint bits = occupancy[word]; bits != 0u; bits &= bits - 1u) {
        uint x = column * 32u + uint(findLSB(bits));
        if (target < uint(grid_lights.length())) {
            grid_lights[target].vertex = row * vertices_per_axis(level) + x;
            grid_lights[target].level = level;
        }
        ++target;
    }
}
