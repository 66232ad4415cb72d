// The cells of S1 that hold lights of S0: one bit each where its lowest vertex has its bit in the occupancy of S1, and
// their ranks. The lights of the cell of rank r are bucket_lights[bucket_starts[r]] up to bucket_starts[r + 1]. Needs
// lights.glsl; the includer declares `cell_bits` and `cell_ranks`.

// Cells before a word's bits `before`.
uint cell_rank(uint word, uint before) { return cell_ranks[word] + uint(bitCount(cell_bits[word] & before)); }

// Ranks of the cells of a row from x = `low` to `high`, of which some may hold no light: the first and the end.
uvec2 cells_of_row(uvec2 yz, uint low, uint high) {
    uint first = cell_rank(occupancy_word(uvec3(low, yz), 1u), (1u << (low % 32u)) - 1u);
    uint end = cell_rank(occupancy_word(uvec3(high, yz), 1u), ~0u >> (31u - high % 32u));
    return uvec2(first, end);
}
