// Marks the grid vertices that a light at `cells` shares itself with, in the occupancy bits.
// Needs frame.glsl and lights.glsl; the includer declares `occupancy`.

#include "common/vertex_share.glsl"

void mark_vertices(vec3 cells, uint level) {
    uvec3 cell = cell_of(cells, level);
    vec3 fraction = cells - vec3(cell);
    for (uint i = 0u; i < 8u; ++i) {
        uvec3 corner = uvec3(i & 1u, (i >> 1u) & 1u, i >> 2u);
        if (vertex_share(fraction, corner) > 0.0) {
            uvec3 vertex = cell + corner;
            atomicOr(occupancy[occupancy_word(vertex, level)], 1u << (vertex.x % 32u));
        }
    }
}
