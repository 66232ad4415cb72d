// Leaves of primary points that the eye sees, up to POINT_LEAVES of those that are tried. A thread for each that is tried.
#include "common/frame.glsl"
#include "common/dispatch.glsl"
#include "common/random.glsl"
#include "common/octahedral.glsl"
#include "common/scene.glsl"
#include "common/eye_rays.glsl"
#include "common/micro_buffer.glsl"
#include "common/point_leaves.glsl"
#include "common/leaf_sight.glsl"
#include "shared/PointCounts.glsl"

layout(local_size_x = POINT_LANES) in;
layout(set = 0, binding = 3, std430) readonly buffer Counts { PointCounts point_counts; };
layout(set = 0, binding = 4, std430) readonly buffer Primaries { uint point_primaries[]; };
layout(set = 0, binding = 5, std430) writeonly buffer PrimaryLeaves { uvec4 primary_leaves[]; };

// The leaf that each thread has found in sight.
shared uint found[POINT_LANES];

void main() {
    uint lane = gl_LocalInvocationID.x;
    uint slot = 4u * linear_group() + lane / LEAF_CANDIDATES;
    uint i = lane % LEAF_CANDIDATES;
    bool exists = slot < point_counts.primary_count;
    uint leaf_key = exists ? leaf_candidate(point_primaries[slot], i) : 0u;
    bool sees = exists && is_in_sight(place_of_leaf_key(leaf_key));
    found[lane] = sees ? pack_leaf(float(i) / float(LEAF_CANDIDATES), leaf_key) : NO_LEAF;
    barrier();
    if (exists && i == 0u) {
        uvec4 leaves = uvec4(NO_LEAF);
        uint count = 0u;
        for (uint k = 0u; k < LEAF_CANDIDATES && count < POINT_LEAVES; ++k) {
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
