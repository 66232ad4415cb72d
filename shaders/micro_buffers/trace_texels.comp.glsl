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
#include "common/seen_key.glsl"
#include "common/seen_places.glsl"

// What a texel sees: the side in the lower 24 bits, above it how near its centre, as texels are ordered; 0 for nothing.
uint seen_word(uint key, vec3 position) {
    PointNode node = point_node(key >> 1u);
    float order = distance(position, node.centroid_ws) / max(node.radius, 1e-20);
    return texel_order(order) << 24u | key;
}

// Marks a side as seen, and keeps a few of the texels that see it, those that see it near its centre. Which of them may
// take each other's place depends on the point and on the texel, not on the point's number, which is another in each frame.
void note_seen(uint word, uint point, uint texel) {
    uint key = key_of(word);
    atomicOr(seen_bits[key >> 5u], 1u << (key & 31u));
    uint choice = hash(point, texel % PRIMARY_TEXELS) % POINT_LEAVES;
    atomicMin(seen_texels[POINT_LEAVES * key + choice], pack_texel(word >> 24u, texel));
}

// What is seen in a direction.
uint trace_texel(PointPlace place, vec3 direction, float solid_angle, float receiver_radius) {
    Hit hit;
    if (!traverse(place.position_ws, direction, 3e38, false, hit)) {
        return 0u;
    }
    uint key = seen_key(hit_key(hit, direction), place.position_ws, solid_angle, receiver_radius);
    return seen_word(key, place.position_ws + hit.t * direction);
}

#ifdef KEEPS_TEXELS
#include "common/kept_slots.glsl"
layout(set = 0, binding = 13, std430) readonly buffer KeptSlots { uint kept_slots[]; };
layout(set = 0, binding = 14, std430) readonly buffer PreviousTexels { uint previous_kept_texels[]; };
layout(set = 0, binding = 15, std430) writeonly buffer KeptTexels { uint kept_texels[]; };
#endif

void main() {
    uint slot = linear_group();
    if (slot >= point_counts.primary_count) {
        return;
    }
    uint key = point_primaries[slot];
    PointPlace place = place_of_point(key, primary_leaves[slot]);
    mat3 to_world = micro_frame(place.normal_ws, key);
    float receiver_radius = point_node(key >> 1u).radius;
#ifdef KEEPS_TEXELS
    uint kept = kept_slots[slot];
#endif
    for (uint i = gl_LocalInvocationID.x; i < PRIMARY_TEXELS; i += POINT_LANES) {
        MicroTexel texel = micro_table[i];
        uint index = PRIMARY_TEXELS * slot + i;
        vec3 direction = to_world * texel.direction;
        uint word = 0u;
#ifdef KEEPS_TEXELS
        if (kept != NOT_KEPT) {
            word = previous_kept_texels[PRIMARY_TEXELS * kept + i];
        } else
#endif
        if (is_used(texel)) {
            word = trace_texel(place, direction, texel.solid_angle, receiver_radius);
        }
#ifdef KEEPS_TEXELS
        kept_texels[index] = word;
#endif
        if (word != 0u) {
            note_seen(word, key, index);
        }
        micro_texels[index] = word != 0u ? pack_micro_texel(1.0, key_of(word)) : 0u;
    }
}
