// The points' tree: node 1 is the root, the children of node i are 2i and 2i + 1, leaf j is node leaf_count + j. What is
// seen and lit are sides: key 2 node + 0 faces the node's normal, 2 node + 1 the other way. Rust: points::Node.
// Needs frame.glsl, octahedral.glsl and the image `point_nodes`.
#include "common/words.glsl"

#include "shared/PackedNode.glsl"

struct PointNode {
    vec3 centroid_ws;
    // Encloses the discs of all leaves, about the centroid.
    float radius;
    vec3 normal;
    float area;
    // Of the mean of the leaves' normals.
    float normal_length;
    // Of the widest angle between the mean normal and a leaf's.
    float cone_cos;
    // How far the discs reach from the plane through the centroid along the normal.
    float half_thickness;
    // The leaf that represents the node, counted from the first.
    uint leaf;
    bool is_solid;
    // Its normal opposes its parent's, so that a side of it is the other one of its parent.
    bool is_turned;
};

PointNode unpack_node(PackedNode node) {
    return PointNode(
        node.centroid_ws,
        node.radius,
        unpack_octahedral(node.normal_oct),
        node.area,
        float(node.spread & 0xffu) / 255.0,
        float(node.spread >> 8u & 0xffu) / 127.5 - 1.0,
        node.radius * (float(node.spread >> 16u) / 65535.0),
        node.leaf_and_flags & POINT_LEAF_MASK,
        (node.leaf_and_flags & POINT_IS_SOLID) != 0u,
        (node.leaf_and_flags & POINT_IS_TURNED) != 0u);
}

PointNode point_node(uint node) {
    uint first = PACKED_NODE_TEXELS * node;
    return unpack_node(packed_node_from_texels(
        texelFetch(point_nodes, texel_place(first), 0), texelFetch(point_nodes, texel_place(first + 1u), 0)));
}

// Where a node is, on a surface: the position of the leaf that represents it.
vec3 point_position(PointNode node) {
    uint first = PACKED_NODE_TEXELS * (frame.point_leaf_count + node.leaf);
    return uintBitsToFloat(texelFetch(point_nodes, texel_place(first), 0).xyz);
}

bool is_turned(uint node) {
    uint last = PACKED_NODE_TEXELS * node + PACKED_NODE_TEXELS - 1u;
    return (texelFetch(point_nodes, texel_place(last), 0).w & POINT_IS_TURNED) != 0u;
}

bool is_leaf(uint node) { return node >= frame.point_leaf_count; }

// The side of the parent that faces as this one does.
uint parent_key(uint key) {
    uint node = key >> 1u;
    return (node >> 1u) << 1u | ((key & 1u) ^ uint(is_turned(node)));
}

// The side of a child that faces as this one does.
uint child_key(uint key, uint child) {
    uint node = (key >> 1u) << 1u | child;
    return node << 1u | ((key & 1u) ^ uint(is_turned(node)));
}

// The side whose outside a direction comes from.
uint side_towards(vec3 normal, vec3 direction) { return dot(normal, direction) < 0.0 ? 1u : 0u; }

// The node after the subtree of a node, where parents come before their children; 1 after the last.
uint after_subtree(uint node) { return (node + 1u) >> uint(findLSB(node + 1u)); }

// Level of a node: 0 is the root.
uint node_level(uint node) { return uint(findMSB(node)); }
