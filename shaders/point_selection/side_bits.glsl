// Sets of sides as words of bits, a bit for each key, and the way between a word and those of the nodes below: word w has
// nodes 16 w and on, whose children are in words 2w and 2w + 1. Word 0 has four levels in it, the others a part of one.
// Needs the buffer `turned_bits`, a bit for each node.

// A bit for each of the 16 nodes of a word.
uint turned_of_word(uint word) { return turned_bits[word >> 1u] >> (16u * (word & 1u)) & 0xffffu; }

// Swaps the two sides of the nodes that are turned: the sides as their parents name them, or back.
uint swap_turned(uint sides, uint turned) {
    uint nodes = (turned | turned << 8u) & 0x00ff00ffu;
    nodes = (nodes | nodes << 4u) & 0x0f0f0f0fu;
    nodes = (nodes | nodes << 2u) & 0x33333333u;
    nodes = ((nodes | nodes << 1u) & 0x55555555u) * 3u;
    uint swapped = (sides >> 1u & 0x55555555u) | (sides & 0x55555555u) << 1u;
    return (sides & ~nodes) | (swapped & nodes);
}

// Sides of the 16 nodes of a word that their parents' sides, 16 bits, lead to.
uint sides_of_children(uint parents, uint turned) {
    uint sides = (parents | parents << 8u) & 0x00ff00ffu;
    sides = (sides | sides << 4u) & 0x0f0f0f0fu;
    sides = (sides | sides << 2u) & 0x33333333u;
    return swap_turned(sides | sides << 2u, turned);
}

// Every other pair of bits, close together.
uint close_pairs(uint sides) {
    sides &= 0x33333333u;
    sides = (sides | sides >> 2u) & 0x0f0f0f0fu;
    sides = (sides | sides >> 4u) & 0x00ff00ffu;
    return (sides | sides >> 8u) & 0xffffu;
}

// Sides, 16 bits, of the 8 parents of the nodes of a word both of whose children are in the set.
uint sides_of_both(uint children, uint turned) {
    uint sides = swap_turned(children, turned);
    return close_pairs(sides & sides >> 2u);
}

// The same of which either child is.
uint sides_of_either(uint children, uint turned) {
    uint sides = swap_turned(children, turned);
    return close_pairs(sides | sides >> 2u);
}
