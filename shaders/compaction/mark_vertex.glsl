// Marks the grid vertices that a light at `cells` shares itself with, in the occupancy bits.
// Needs frame.glsl and lights.glsl; the includer declares `occupancy`.

// Corners with less than this weight are left out: they would hold nothing but rounding.
const float MIN_WEIGHT = 1e-6;

void mark_vertices(vec3 cells, uint level) {
    uvec3 cell = cell_of(cells, level);
    vec3 fraction = cells - vec3(cell);
    for (uint i = 0u; i < 8u; ++i) {
        uvec3 corner = uvec3(i & 1u, (i >> 1u) & 1u, i >> 2u);
        if (trilinear_weight(fraction, corner) > MIN_WEIGHT) {
            uvec3 vertex = cell + corner;
            atomicOr(occupancy[occupancy_word(vertex, level)], 1u << (vertex.x % 32u));
        }
    }
}
