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
layout(set = 0, binding = 8, std430) buffer SeenTexels { uint seen_texels[]; };
layout(set = 0, binding = 11, std430) readonly buffer TriangleCells { uvec2 triangle_cells[]; };
layout(set = 0, binding = 12, std430) readonly buffer LeafCells { uint leaf_cells[]; };
#include "common/point_hits.glsl"
#include "common/hit_key.glsl"
#include "common/seen_places.glsl"

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

// Marks a side as seen, and keeps a few of the texels that see it, those that see it near its centre.
void note_seen(uint key, vec3 position, uint texel) {
    atomicOr(seen_bits[key >> 5u], 1u << (key & 31u));
    PointNode node = point_node(key >> 1u);
    float order = distance(position, node.centroid_ws) / max(node.radius, 1e-20);
    atomicMin(seen_texels[POINT_LEAVES * key + hash(texel) % POINT_LEAVES], pack_texel(order, texel));
}

// What is seen in the direction of a texel, as it is kept.
uint trace_texel(PointPlace place, vec3 direction, float solid_angle, float receiver_radius, uint texel) {
    Hit hit;
    if (!traverse(place.position_ws, direction, 3e38, false, hit)) {
        return 0u;
    }
    uint key = seen_key(hit_key(hit, direction), place.position_ws, solid_angle, receiver_radius);
    note_seen(key, place.position_ws + hit.t * direction, texel);
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
        uint index = PRIMARY_TEXELS * slot + i;
        vec3 direction = to_world * texel.direction;
        micro_texels[index] = used ? trace_texel(place, direction, texel.solid_angle, receiver_radius, index) : 0u;
    }
}
