// Marks the vertices of levels 2..Lmax that the S1 lights share themselves with, by the S1 vertices they stand at. One thread per S1 light.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/lights.glsl"
#include "common/dispatch.glsl"

layout(local_size_x = WORKGROUP_SIZE) in;
layout(set = 0, binding = 1, std430) readonly buffer GridLights { GridLight grid_lights[]; };
layout(set = 0, binding = 2, std430) buffer Occupancy { uint occupancy[]; };
layout(set = 0, binding = 3, std430) readonly buffer LevelTable { uint level_table[]; };

#include "common/level_table.glsl"
#include "compaction/mark_vertex.glsl"

void main() {
    uint light = linear_thread();
    if (light < level_count(1u)) {
        for (uint level = 2u; level <= top_level(); ++level) {
            uvec3 vertex = vertex_from_index(grid_lights[light].vertex, 1u);
            mark_vertices(s1_vertex_in_cells(vertex, level), level);
        }
    }
}
