// Leaves that stand for a side of a node: a few that are known to be in sight, as others may lie on surfaces behind. Needs
// micro_buffer.glsl.

// A leaf with a number from 0 to 1 by which smaller ones are preferred; NO_LEAF for none.
const uint NO_LEAF = 0xffffffffu;
const uint LEAF_KEY_BITS = 22u;

uint pack_leaf(float order, uint leaf_key) {
    return uint(clamp(order, 0.0, 1.0) * 1022.0) << LEAF_KEY_BITS | (leaf_key - 2u * frame.point_leaf_count);
}

uint unpack_leaf(uint leaf) { return (leaf & ((1u << LEAF_KEY_BITS) - 1u)) + 2u * frame.point_leaf_count; }

// The side of a leaf, or of a point without one that of its representative.
uint leaf_key_of(uint leaf, uint key) {
    if (leaf != NO_LEAF) {
        return unpack_leaf(leaf);
    }
    return 2u * (frame.point_leaf_count + point_node(key >> 1u).leaf) + (key & 1u);
}

PointPlace place_of_leaf_key(uint leaf_key) { return leaf_place(leaf_key >> 1u, leaf_key & 1u); }

// Where a point is that has these leaves.
PointPlace place_of_point(uint key, uvec4 leaves) {
    return place_of_leaf_key(leaf_key_of(min(min(leaves.x, leaves.y), min(leaves.z, leaves.w)), key));
}
