// Representatives: per S1 light REPRESENTATIVES words, each a light of S0 drawn with a probability proportional
// to its share of the S1 light. A word holds a race key in its high bits and the light in its low `index_bits`,
// so that one 32-bit atomic minimum draws the winner whatever the order.

uint index_mask(uint index_bits) { return (1u << index_bits) - 1u; }

// Smaller keys win; of lights with shares s_i the minimum of -ln(u) / s_i falls on i with probability
// s_i / sum of s (exponential race). The logarithm keeps 80 octaves in few bits.
uint packed_race_key(float u, float share, uint index_bits) {
    float octave = clamp(log2(negative_log(u)) - log2(share) + 26.0, 0.0, 79.9);
    return uint(octave / 80.0 * float(1u << (32u - index_bits))) << index_bits;
}
