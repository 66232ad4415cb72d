// Marks the occupied vertices of levels first..last from the lights S0. One thread per light.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/lights.glsl"
#include "common/dispatch.glsl"

layout(local_size_x = WORKGROUP_SIZE) in;
layout(set = 0, binding = 1, std430) readonly buffer LightPositions { uvec4 light_positions[]; };
layout(set = 0, binding = 2, std430) readonly buffer Grid { GridPlacement grid; };
layout(set = 0, binding = 3, std430) buffer Occupancy { uint occupancy[]; };
layout(push_constant) uniform Push { uint first_marked; uint last_marked; };

#include "compaction/mark_vertex.glsl"

void main() {
    uint light = linear_thread();
    if (light < grid.light_count) {
        for (uint level = first_marked; level <= last_marked; ++level) {
            mark_vertices(grid_position(uintBitsToFloat(light_positions[light].xyz), grid, level), level);
        }
    }
}
