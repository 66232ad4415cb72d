// Takes the lights that have changed, as they were, out of the sums of S1, and adds them as they are now. One thread per change.
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
layout(set = 0, binding = 3, std430) readonly buffer KeptPositions { uvec4 kept_positions[]; };
layout(set = 0, binding = 4, std430) readonly buffer KeptFluxes { vec4 kept_fluxes[]; };
layout(set = 0, binding = 5, std430) readonly buffer ChangeCount { uint change_count; };
layout(set = 0, binding = 6, std430) readonly buffer Changes { uvec2 changes[]; };
layout(set = 0, binding = 7, std430) readonly buffer Grid { GridPlacement grid; };
layout(set = 0, binding = 8, std430) readonly buffer Occupancy { uint occupancy[]; };
layout(set = 0, binding = 9, std430) readonly buffer Ranks { uint ranks[]; };
layout(set = 0, binding = 10, std430) readonly buffer LevelTable { uint level_table[]; };
layout(set = 0, binding = 11, std430) buffer Moments { uint moments[]; };

#include "common/level_table.glsl"
#include "common/occupancy.glsl"
#include "grid_scatter/moments.glsl"
#include "grid_scatter/add_light.glsl"

void main() {
    uint index = linear_thread();
    if (index >= change_count) {
        return;
    }
    uvec2 lights = changes[index];
    if (lights.x != NO_LIGHT) {
        add_light(kept_positions[lights.x], kept_fluxes[lights.x], 1u, -1.0);
    }
    if (lights.y != NO_LIGHT) {
        add_light(light_positions[lights.y], light_fluxes[lights.y], 1u, 1.0);
    }
}
