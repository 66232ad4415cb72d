// Every light adds its moments to its eight surrounding vertices of one level (section 3.1), by atomic additions. One
// thread per light.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/color.glsl"
#include "common/octahedral.glsl"
#include "common/lights.glsl"
#include "common/original_lights.glsl"
#include "common/dispatch.glsl"
#include "grid_scatter/fixed_point.glsl"

layout(local_size_x = WORKGROUP_SIZE) in;
layout(set = 0, binding = 1, std430) readonly buffer LightPositions { uvec4 light_positions[]; };
layout(set = 0, binding = 2, std430) readonly buffer LightFluxes { vec4 light_fluxes[]; };
layout(set = 0, binding = 3, std430) readonly buffer Grid { GridPlacement grid; };
layout(set = 0, binding = 4, std430) readonly buffer Occupancy { uint occupancy[]; };
layout(set = 0, binding = 5, std430) readonly buffer Ranks { uint ranks[]; };
layout(set = 0, binding = 6, std430) readonly buffer LevelTable { uint level_table[]; };
layout(set = 0, binding = 7, std430) buffer Moments { uint moments[]; };
layout(push_constant) uniform Push { uint level; };

#include "common/level_table.glsl"
#include "common/occupancy.glsl"
#include "grid_scatter/moments.glsl"
#include "grid_scatter/add_light.glsl"

void main() {
    uint index = linear_thread();
    if (index < grid.light_count) {
        add_light(light_positions[index], light_fluxes[index], level, 1.0);
    }
}
