// Boxes of grid vertices row by row: along a row the lights of vertices follow each other. Needs lights.glsl and
// level_table.glsl; the includer declares `occupancy` and `ranks`.

struct VertexRows {
    uint level;
    // The lowest vertex, and how many there are along each axis.
    uvec3 low;
    uvec3 extent;
    // Of the level: rank of its first vertex, and number of its lights.
    uint first_rank;
    uint count;
};

VertexRows vertex_rows(uint level, uvec3 low, uvec3 extent) {
    return VertexRows(level, low, extent, ranks[first_word(level)], level_count(level));
}

uint row_count(VertexRows rows) { return rows.extent.x == 0u ? 0u : rows.extent.y * rows.extent.z; }

// Lights of the level before a word's bits `before`.
uint rank_of(uint word, uint before, VertexRows rows) {
    return min(ranks[word] - rows.first_rank + uint(bitCount(occupancy[word] & before)), rows.count);
}

// Ranks of the lights of one row of vertices: the first and the end.
uvec2 ranks_of_row(VertexRows rows, uint row) {
    uvec3 vertex = rows.low + uvec3(0u, row % rows.extent.y, row / rows.extent.y);
    uint first = rank_of(occupancy_word(vertex, rows.level), (1u << (vertex.x % 32u)) - 1u, rows);
    vertex.x += rows.extent.x - 1u;
    uint end = rank_of(occupancy_word(vertex, rows.level), ~0u >> (31u - vertex.x % 32u), rows);
    return uvec2(first, end);
}
