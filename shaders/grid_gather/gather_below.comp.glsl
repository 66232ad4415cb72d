// One vertex of a level above S1 gathers the lights of the level below it (--build cascade). A trilinear weight on one grid
// is the sum of the weights on the grid of half its cell size, scaled by 1, 1/2, 1/4, 1/8 with the distance of the finer
// vertex: so vertex v holds its 27 finer vertices 2v + {-1, 0, 1}^3 in these shares, and all moments are what gathering
// from S1 gives. One thread per vertex.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/lights.glsl"
#include "common/dispatch.glsl"

layout(local_size_x = WORKGROUP_SIZE) in;

#include "grid_gather/moments.glsl"
#include "common/occupancy.glsl"

void main() {
    uint index = linear_thread();
    if (index >= level_count(level)) {
        return;
    }
    uint record = level_first(level) + index;
    uvec3 vertex = vertex_from_index(grid_lights[record].vertex, level);
    float h = cell_size(grid.h_top, level);
    Moments sums = no_moments();
    for (int i = 0; i < int(DESCENT_PARTS); ++i) {
        ivec3 step = ivec3(i % 3, (i / 3) % 3, i / 9) - 1;
        uint below = grid_light_or_none(2 * ivec3(vertex) + step, level - 1u);
        if (below != NO_LIGHT) {
            float share = ldexp(1.0, -(abs(step.x) + abs(step.y) + abs(step.z)));
            add_light(sums, grid_lights[below], share, vec3(vertex), h);
        }
    }
    store_light(record, sums, vec3(vertex), h);
}
