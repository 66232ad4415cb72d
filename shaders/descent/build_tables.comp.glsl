// Lists what every grid light above S1 is made of in the level below. A trilinear weight on one grid is the sum
// of the weights on the grid of half its cell size, scaled by 1, 1/2, 1/4, 1/8 with the distance of the finer
// vertex: so vertex v of level l holds the lights of the 27 vertices 2v + {-1, 0, 1}^3 of level l - 1 in these
// shares. One thread per grid light.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/lights.glsl"
#include "common/dispatch.glsl"
#include "descent/tables.glsl"

layout(local_size_x = WORKGROUP_SIZE) in;
layout(set = 0, binding = 1, std430) readonly buffer GridLights { GridLight grid_lights[]; };
layout(set = 0, binding = 2, std430) readonly buffer Occupancy { uint occupancy[]; };
layout(set = 0, binding = 3, std430) readonly buffer Ranks { uint ranks[]; };
layout(set = 0, binding = 4, std430) readonly buffer LevelTable { uint level_table[]; };
layout(set = 0, binding = 5, std430) writeonly buffer Descent { uint descent[]; };

#include "common/level_table.glsl"
#include "common/occupancy.glsl"

void main() {
    uint first = level_first(2u);
    uint index = linear_thread() + first;
    if (index >= level_first(top_level()) + level_count(top_level())) {
        return;
    }
    uint table = descent_table(index, first);
    if (table + DESCENT_STRIDE > uint(descent.length())) {
        return;
    }
    uint level = grid_lights[index].level;
    ivec3 middle = 2 * ivec3(vertex_from_index(grid_lights[index].vertex, level));
    uint parts = 0u;
    float cumulative = 0.0;
    for (int i = 0; i < int(DESCENT_PARTS); ++i) {
        ivec3 step = ivec3(i % 3, (i / 3) % 3, i / 9) - 1;
        uint part = grid_light_or_none(middle + step, level - 1u);
        if (part != NO_LIGHT) {
            float share = ldexp(1.0, -(abs(step.x) + abs(step.y) + abs(step.z)));
            cumulative += share * grid_lights[part].luminance;
            descent[table + 2u + 2u * parts] = floatBitsToUint(cumulative);
            descent[table + 3u + 2u * parts] = part;
            ++parts;
        }
    }
    descent[table] = parts;
}
