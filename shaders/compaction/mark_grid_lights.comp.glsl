// Marks the occupied vertices of levels 2..Lmax from the centres of the S1 lights. One thread per S1 light.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/lights.glsl"
#include "common/dispatch.glsl"

layout(local_size_x = WORKGROUP_SIZE) in;
layout(set = 0, binding = 1, std430) readonly buffer GridLights { GridLight grid_lights[]; };
layout(set = 0, binding = 2, std430) readonly buffer Grid { GridPlacement grid; };
layout(set = 0, binding = 3, std430) buffer Occupancy { uint occupancy[]; };
layout(set = 0, binding = 4, std430) readonly buffer LevelTable { uint level_table[]; };

#include "common/level_table.glsl"
#include "compaction/mark_vertex.glsl"

void main() {
    uint light = linear_thread();
    if (light < level_count(1u)) {
        for (uint level = 2u; level <= top_level(); ++level) {
            mark_vertices(grid_position(grid_lights[light].position_ws, grid, level), level);
        }
    }
}
