// Which leaves of a point the eye sees, as a node also holds what lies behind: a wall behind its bricks. A few are tried: the
// representative leaf, then leaves spread over the node. Needs point_leaves.glsl and eye_rays.glsl.
const uint LEAF_CANDIDATES = 16u;

// A leaf of a node as the side of it, number `i` of those that are tried.
uint leaf_candidate(uint key, uint i) {
    uint node = key >> 1u;
    uint depth = uint(findMSB(frame.point_leaf_count) - findMSB(node));
    // Spread over the node, in an order that has any few of them spread as well.
    uint place = (i * 7u) % LEAF_CANDIDATES;
    uint leaf = (node << depth) + uint((float(place) + 0.5) / float(LEAF_CANDIDATES) * float(1u << depth));
    leaf = i == 0u ? frame.point_leaf_count + point_node(node).leaf : leaf;
    // Which side of the node the leaf's side 0 is.
    uint above = 2u * leaf;
    while (above >> 1u > node) {
        above = parent_key(above);
    }
    return 2u * leaf + ((above ^ key) & 1u);
}

bool is_in_sight(PointPlace place) {
    vec3 offset = frame.eye_ws - place.position_ws;
    float distance = max(length(offset), 1e-20);
    vec3 direction = offset / distance;
    return dot(direction, place.normal_ws) > 0.0 && !is_hidden_from_eye(place.position_ws, direction, distance);
}
