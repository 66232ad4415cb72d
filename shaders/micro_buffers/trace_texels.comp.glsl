// Micro-buffers of primary points by rays: one closest hit for each texel, kept as the node of the points' tree that it
// lies in and that is as large as the texel. Marks what is seen. A workgroup for each primary point.
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
layout(set = 0, binding = 5, std430) writeonly buffer MicroTexels { uint micro_texels[]; };
layout(set = 0, binding = 6, std430) buffer Seen { uint seen_bits[]; };
layout(set = 0, binding = 7, std430) readonly buffer PrimaryLeaves { uvec4 primary_leaves[]; };
layout(set = 0, binding = 8, std430) buffer SeenLeaves { uint seen_leaves[]; };
layout(set = 0, binding = 11, std430) readonly buffer TriangleCells { uvec2 triangle_cells[]; };
layout(set = 0, binding = 12, std430) readonly buffer LeafCells { uint leaf_cells[]; };
#include "common/point_hits.glsl"
#include "common/hit_key.glsl"

// The key that one side of a leaf is kept as: of the largest node above it that subtends no more than a texel of this solid
// angle, or is no larger than the receiver.
uint seen_key(uint key, vec3 position, float solid_angle, float receiver_radius) {
    while (key >= 4u) {
        PointNode parent = point_node(key >> 2u);
        vec3 offset = parent.centroid_ws - position;
        float subtended = PI * parent.radius * parent.radius;
        bool is_small = subtended <= frame.hit_texels * solid_angle * dot(offset, offset);
        if (!(is_small || parent.radius <= receiver_radius) || parent.cone_cos < frame.hit_cone_cos) {
            break;
        }
        key = parent_key(key);
    }
    return key;
}

// Marks a side as seen, and keeps a few of the leaves in sight for it, those near its centre.
void note_seen(uint key, uint leaf_key) {
    atomicOr(seen_bits[key >> 5u], 1u << (key & 31u));
    PointNode node = point_node(key >> 1u);
    float order = distance(point_node(leaf_key >> 1u).centroid_ws, node.centroid_ws) / max(node.radius, 1e-20);
    atomicMin(seen_leaves[POINT_LEAVES * key + hash(leaf_key) % POINT_LEAVES], pack_leaf(order, leaf_key));
}

// What is seen in a direction, as a texel.
uint trace_texel(PointPlace place, vec3 direction, float solid_angle, float receiver_radius) {
    Hit hit;
    if (!traverse(place.position_ws, direction, 3e38, false, hit)) {
        return 0u;
    }
    uint leaf_key = hit_key(hit, direction);
    uint key = seen_key(leaf_key, place.position_ws, solid_angle, receiver_radius);
    note_seen(key, leaf_key);
    return pack_micro_texel(1.0, key);
}

void main() {
    uint slot = linear_group();
    if (slot >= point_counts.primary_count) {
        return;
    }
    uint key = point_primaries[slot];
    PointPlace place = place_of_point(key, primary_leaves[slot]);
    mat3 to_world = micro_frame(place.normal_ws, key);
    float receiver_radius = point_node(key >> 1u).radius;
    for (uint i = gl_LocalInvocationID.x; i < PRIMARY_TEXELS; i += POINT_LANES) {
        MicroTexel texel = micro_table[i];
        bool used = is_used(texel);
        micro_texels[PRIMARY_TEXELS * slot + i] =
            used ? trace_texel(place, to_world * texel.direction, texel.solid_angle, receiver_radius) : 0u;
    }
}
