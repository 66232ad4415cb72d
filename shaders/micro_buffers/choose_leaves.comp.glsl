// Leaves of primary points that the eye sees, as a node also holds what lies behind: a wall behind its bricks. The
// representative leaf comes first, then leaves spread over the node. Sixteen threads for each primary point.
#include "common/frame.glsl"
#include "common/dispatch.glsl"
#include "common/random.glsl"
#include "common/octahedral.glsl"
#include "common/scene.glsl"
#include "common/micro_buffer.glsl"
#include "common/point_leaves.glsl"
#include "shared/PointCounts.glsl"

layout(local_size_x = POINT_LANES) in;
layout(set = 0, binding = 3, std430) readonly buffer Counts { PointCounts point_counts; };
layout(set = 0, binding = 4, std430) readonly buffer Primaries { uint point_primaries[]; };
layout(set = 0, binding = 5, std430) writeonly buffer PrimaryLeaves { uvec4 primary_leaves[]; };

const uint CANDIDATES = POINT_LANES / 4u;

// The leaf that each thread has found in sight.
shared uint found[POINT_LANES];

// A leaf of a node as the side of it, number `i` of those that are tried.
uint candidate(uint key, uint i) {
    uint node = key >> 1u;
    uint depth = uint(findMSB(frame.point_leaf_count) - findMSB(node));
    // Spread over the node, in an order that has any few of them spread as well.
    uint place = (i * 7u) % CANDIDATES;
    uint leaf = (node << depth) + uint((float(place) + 0.5) / float(CANDIDATES) * float(1u << depth));
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
    return dot(direction, place.normal_ws) > 0.0 && !is_blocked(place.position_ws, direction, distance);
}

void main() {
    uint lane = gl_LocalInvocationID.x;
    uint slot = 4u * linear_group() + lane / CANDIDATES;
    uint i = lane % CANDIDATES;
    bool exists = slot < point_counts.primary_count;
    uint leaf_key = exists ? candidate(point_primaries[slot], i) : 0u;
    bool sees = exists && is_in_sight(place_of_leaf_key(leaf_key));
    found[lane] = sees ? pack_leaf(float(i) / float(CANDIDATES), leaf_key) : NO_LEAF;
    barrier();
    if (exists && i == 0u) {
        uvec4 leaves = uvec4(NO_LEAF);
        uint count = 0u;
        for (uint k = 0u; k < CANDIDATES && count < POINT_LEAVES; ++k) {
            uint leaf = found[lane + k];
            // Small nodes have fewer leaves than are tried.
            bool is_new = leaf != NO_LEAF;
            for (uint j = 0u; j < count; ++j) {
                is_new = is_new && unpack_leaf(leaves[j]) != unpack_leaf(leaf);
            }
            if (is_new) {
                leaves[count++] = leaf;
            }
        }
        primary_leaves[slot] = leaves;
    }
}
