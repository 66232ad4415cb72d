// Lists the sides of a set as discs, in ascending order, and writes the draw of them. One thread per word of bits.
#include "common/frame.glsl"
#include "common/octahedral.glsl"
#include "common/dispatch.glsl"
#include "common/random.glsl"
#include "shared/ShownPoint.glsl"
layout(local_size_x = WORKGROUP_SIZE) in;

layout(set = 0, binding = 1) uniform utexture2D point_nodes;
layout(set = 0, binding = 2, std430) readonly buffer ShownBits { uint shown_bits[]; };
layout(set = 0, binding = 3, std430) readonly buffer Ranks { uint ranks[]; };
layout(set = 0, binding = 4, std430) readonly buffer NeededBits { uint needed_bits[]; };
layout(set = 0, binding = 5, std430) readonly buffer UnderBits { uint under_bits[]; };
layout(set = 0, binding = 9, std430) readonly buffer BorrowedBits { uint borrowed_bits[]; };
layout(set = 0, binding = 6, std430) writeonly buffer ShownPoints { ShownPoint shown_points[]; };
// A VkDrawIndirectCommand.
layout(set = 0, binding = 7, std430) writeonly buffer Draw { uint draw[4]; };
// Of x, z, -x and -z the highest of any point, as whole numbers; 0 where there is none.
layout(set = 0, binding = 8, std430) buffer ShownBounds { uint shown_bounds[4]; };
layout(push_constant) uniform Push { uint word_count; };
// Whether it is the light of points that is told rather than their level.
layout(constant_id = 0) const uint TELLS_LIGHT = 0u;

#define WRITES_BOUNDS
#include "common/points.glsl"
#include "point_view/from_above.glsl"

bool has_bit(uint bits, uint key) { return (bits >> (key & 31u) & 1u) != 0u; }

// How many levels above the leaves a node is.
uint height_of(uint node) { return uint(findMSB(frame.point_leaf_count) - findMSB(node)); }

// Where the light of a side that is seen comes from.
uint light_of(uint key, uint word) {
    if (has_bit(needed_bits[word], key)) {
        return LIGHT_OF_ITS_OWN;
    }
    if (has_bit(under_bits[word], key)) {
        return LIGHT_OF_PRIMARY;
    }
    return has_bit(borrowed_bits[word], key) ? LIGHT_OF_PARENT : LIGHT_OF_CHILDREN;
}

ShownPoint shown_point(uint key, uint word) {
    PointNode node = point_node(key >> 1u);
    vec3 normal = (key & 1u) == 0u ? node.normal : -node.normal;
    uint number = TELLS_LIGHT != 0u ? light_of(key, word) : height_of(key >> 1u);
    return ShownPoint(point_position(node), sqrt(node.area / PI), normal, number << 24u | key);
}

void main() {
    uint word = linear_thread();
    if (word >= word_count) {
        return;
    }
    uint capacity = uint(shown_points.length());
    uint place = ranks[word];
    for (uint left = shown_bits[word]; left != 0u && place < capacity; left &= left - 1u) {
        ShownPoint point = shown_point(32u * word + uint(findLSB(left)), word);
        shown_points[place++] = point;
        vec4 sides = vec4(point.position_ws.xz, -point.position_ws.xz);
        for (uint side = 0u; side < 4u; ++side) {
            atomicMax(shown_bounds[side], ordered_from_float(sides[side]));
        }
    }
    if (word == 0u) {
        draw[0] = 6u;
        draw[1] = min(ranks[word_count], capacity);
        draw[2] = 0u;
        draw[3] = 0u;
    }
}
