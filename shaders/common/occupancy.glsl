// From a grid vertex to its grid light. Needs lights.glsl and level_table.glsl; the includer declares `occupancy` and
// `ranks`.

// Index of the grid light at a vertex of a level, or NO_LIGHT where there is none or it did not fit.
uint grid_light_at(uvec3 vertex, uint level) {
    uint word = occupancy_word(vertex, level);
    uint bit = 1u << (vertex.x % 32u);
    uint bits = occupancy[word];
    uint rank = ranks[word] - ranks[first_word(level)] + uint(bitCount(bits & (bit - 1u)));
    return (bits & bit) != 0u && rank < level_count(level) ? level_first(level) + rank : NO_LIGHT;
}

// The same for a vertex that may lie outside the grid.
uint grid_light_or_none(ivec3 vertex, uint level) {
    int n = int(vertices_per_axis(level));
    bool outside = any(lessThan(vertex, ivec3(0))) || any(greaterThanEqual(vertex, ivec3(n)));
    return outside ? NO_LIGHT : grid_light_at(uvec3(vertex), level);
}
