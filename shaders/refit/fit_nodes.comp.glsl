// Gives nodes of the BVH, all of one height above the triangles that have moved, boxes around what is below them. One thread per
// node. CPU twin: scene::refit::refit, to the bit: planes are whole numbers of a power of two, so that no product is rounded.
#include "constants.glsl"
#include "common/dispatch.glsl"
#include "common/words.glsl"
#include "shared/BvhNode.glsl"
#include "shared/BvhTriangle.glsl"
#include "shared/NodeBox.glsl"
#include "shared/MovedTree.glsl"

layout(local_size_x = WORKGROUP_SIZE) in;
// Nodes with triangles below them that move, the lowest first.
layout(set = 0, binding = 0, std430) readonly buffer MovingNodes { uint moving_nodes[]; };
layout(set = 0, binding = 1) uniform utexture2D bvh_triangles;
layout(set = 0, binding = 2, rgba32ui) uniform uimage2D bvh_nodes;
// Of all nodes; those of this height are written.
layout(set = 0, binding = 3, std430) buffer NodeBoxes { NodeBox node_boxes[]; };
layout(set = 0, binding = 4, std430) writeonly buffer MovedTrees { MovedTree moved_tree; };
layout(push_constant) uniform Push {
    uint first;
    uint end;
};

// Places for the children of a node.
const uint SLOTS = 8u;
// What a triangle in a leaf costs, in visits of a node.
const float TRIANGLE_COST = 0.3;
// The least and the greatest unit of a node's planes, as powers of two.
const int LEAST_EXPONENT = -60;
const int MOST_EXPONENT = 126;
// Planes are whole numbers of units up to this. One less than fits, as rounding moves the last one outwards.
const float MOST_UNITS = 254.0;

struct Box {
    vec3 min;
    vec3 max;
};

const Box EMPTY = Box(vec3(3.402823466e38), vec3(-3.402823466e38));

Box with(Box box, vec3 point) { return Box(min(box.min, point), max(box.max, point)); }

// Half of a box's surface.
float area(Box box) {
    precise vec3 size = max(box.max - box.min, vec3(0.0));
    precise float sum = size.x * size.y;
    sum = sum + size.y * size.z;
    sum = sum + size.z * size.x;
    return sum;
}

BvhNode load_node(uint index) {
    uint texel = BVH_NODE_TEXELS * index;
    return bvh_node_from_texels(
        imageLoad(bvh_nodes, texel_place(texel)),
        imageLoad(bvh_nodes, texel_place(texel + 1u)),
        imageLoad(bvh_nodes, texel_place(texel + 2u)),
        imageLoad(bvh_nodes, texel_place(texel + 3u)),
        imageLoad(bvh_nodes, texel_place(texel + 4u)));
}

Box leaf_box(uint first, uint count) {
    Box box = EMPTY;
    for (uint i = 0u; i < count; ++i) {
        uint texel = BVH_TRIANGLE_TEXELS * (first + i);
        vec3 v0 = uintBitsToFloat(texelFetch(bvh_triangles, texel_place(texel), 0).xyz);
        vec3 edge1 = uintBitsToFloat(texelFetch(bvh_triangles, texel_place(texel + 1u), 0).xyz);
        vec3 edge2 = uintBitsToFloat(texelFetch(bvh_triangles, texel_place(texel + 2u), 0).xyz);
        box = with(with(with(box, v0), v0 + edge1), v0 + edge2);
    }
    return box;
}

// The box of a child, and what it adds to its parent's cost; nothing where there is no child.
Box child_box(BvhNode node, uint slot, inout float cost) {
    uint meta = (node.meta[slot / 4u] >> (8u * (slot % 4u))) & 0xffu;
    uint inner = node.exponents_and_inner >> 24u;
    if (meta == 0u) {
        return EMPTY;
    }
    if (((inner >> slot) & 1u) != 0u) {
        NodeBox child = node_boxes[node.first_child + uint(bitCount(inner & ((1u << slot) - 1u)))];
        Box box = Box(child.min, child.max);
        precise float sum = cost + child.cost;
        sum = sum + area(box);
        cost = sum;
        return box;
    }
    uint count = uint(bitCount(meta >> 5u));
    Box box = leaf_box(node.first_triangle + (meta & 31u), count);
    precise float per_area = TRIANGLE_COST * float(count);
    precise float added = per_area * area(box);
    precise float sum = cost + added;
    cost = sum;
    return box;
}

float power_of_two(int exponent) { return uintBitsToFloat(uint(exponent + 127) << 23u); }

// Exponent of the least unit of which the planes' numbers reach over an extent.
int unit_exponent(float extent) {
    // 254 units of an exponent that is lower by 8 than the extent's are less than it.
    int exponent = clamp(int(floatBitsToUint(extent) >> 23u) - 127 - 7, LEAST_EXPONENT, MOST_EXPONENT);
    while (exponent < MOST_EXPONENT && MOST_UNITS * power_of_two(exponent) < extent) {
        ++exponent;
    }
    return exponent;
}

// The highest plane that is not above a coordinate as rays see it.
uint lower_plane(float origin, int exponent, float coordinate) {
    precise float offset = coordinate - origin;
    float unit = power_of_two(exponent);
    float plane = clamp(floor(offset * power_of_two(-exponent)), 0.0, 255.0);
    while (plane > 0.0 && origin + unit * plane > coordinate) {
        plane -= 1.0;
    }
    return uint(plane);
}

// The lowest plane that is not below a coordinate as rays see it.
uint upper_plane(float origin, int exponent, float coordinate) {
    precise float offset = coordinate - origin;
    float unit = power_of_two(exponent);
    float plane = clamp(ceil(offset * power_of_two(-exponent)), 0.0, 255.0);
    while (plane < 255.0 && origin + unit * plane < coordinate) {
        plane += 1.0;
    }
    return uint(plane);
}

// The planes of all children along an axis: lower ones, then upper ones, four to a word.
uvec4 planes(uint axis, float origin, int exponent, Box children[SLOTS]) {
    uvec4 words = uvec4(0u);
    for (uint slot = 0u; slot < SLOTS; ++slot) {
        if (children[slot].min.x <= children[slot].max.x) {
            uint shift = 8u * (slot % 4u);
            words[slot / 4u] |= lower_plane(origin, exponent, children[slot].min[axis]) << shift;
            words[2u + slot / 4u] |= upper_plane(origin, exponent, children[slot].max[axis]) << shift;
        }
    }
    return words;
}

void main() {
    uint place = first + linear_thread();
    if (place >= end) {
        return;
    }
    uint index = moving_nodes[place];
    BvhNode node = load_node(index);
    Box children[SLOTS];
    Box bounds = EMPTY;
    float cost = 0.0;
    for (uint slot = 0u; slot < SLOTS; ++slot) {
        children[slot] = child_box(node, slot, cost);
        bounds = Box(min(bounds.min, children[slot].min), max(bounds.max, children[slot].max));
    }
    node_boxes[index] = NodeBox(bounds.min, cost, bounds.max, 0u);
    uint exponents = 0u;
    uint texel = BVH_NODE_TEXELS * index;
    for (uint axis = 0u; axis < 3u; ++axis) {
        int exponent = unit_exponent(bounds.max[axis] - bounds.min[axis]);
        exponents |= uint(exponent + 127) << (8u * axis);
        imageStore(bvh_nodes, texel_place(texel + 2u + axis), planes(axis, bounds.min[axis], exponent, children));
    }
    uint inner = node.exponents_and_inner & 0xff000000u;
    imageStore(bvh_nodes, texel_place(texel), uvec4(floatBitsToUint(bounds.min), inner | exponents));
    if (index == 0u) {
        float root = area(bounds);
        moved_tree.cost = root > 0.0 ? cost / root : cost;
    }
}
