// Micro-buffers of primary points from the points' tree, without a ray. Marks what is seen. A workgroup for each primary
// point.
#include "common/frame.glsl"
#include "common/dispatch.glsl"
#include "common/random.glsl"
#include "common/octahedral.glsl"
#include "common/micro_buffer.glsl"
#include "common/point_leaves.glsl"
#include "shared/PointCounts.glsl"

layout(local_size_x = POINT_LANES) in;
layout(set = 0, binding = 3, std430) readonly buffer Counts { PointCounts point_counts; };
layout(set = 0, binding = 4, std430) readonly buffer Primaries { uint point_primaries[]; };
layout(set = 0, binding = 5, std430) writeonly buffer MicroTexels { uint micro_texels[]; };
layout(set = 0, binding = 6, std430) buffer Seen { uint seen_bits[]; };
layout(set = 0, binding = 7, std430) readonly buffer PrimaryLeaves { uvec4 primary_leaves[]; };
layout(constant_id = 0) const uint BINARY_COVERAGE = 0u;

#define MICRO_EDGE PRIMARY_EDGE
#define MICRO_KEYS
#include "micro_buffers/splat.glsl"

#ifdef KEEPS_TEXELS
#include "common/kept_slots.glsl"
layout(set = 0, binding = 13, std430) readonly buffer KeptSlots { uint kept_slots[]; };
layout(set = 0, binding = 14, std430) readonly buffer PreviousTexels { uint previous_kept_texels[]; };
layout(set = 0, binding = 15, std430) writeonly buffer KeptTexels { uint kept_texels[]; };
#endif

// A texel of the micro-buffer as it is kept.
uint filled_texel(uint i) {
    float coverage = micro_coverage(i);
    return pack_micro_texel(coverage, coverage > 0.0 ? micro_key(i) : 0u);
}

void main() {
    uint slot = linear_group();
    uint lane = gl_LocalInvocationID.x;
    if (slot >= point_counts.primary_count) {
        return;
    }
    uint key = point_primaries[slot];
    PointPlace place = place_of_point(key, primary_leaves[slot]);
#ifdef KEEPS_TEXELS
    uint kept = kept_slots[slot];
    if (kept == NOT_KEPT) {
        fill_micro_buffer(MicroEye(place.position_ws, micro_frame(place.normal_ws, key)), lane);
    }
#else
    fill_micro_buffer(MicroEye(place.position_ws, micro_frame(place.normal_ws, key)), lane);
#endif
    for (uint i = lane; i < MICRO_TEXELS; i += POINT_LANES) {
#ifdef KEEPS_TEXELS
        uint word = kept != NOT_KEPT ? previous_kept_texels[MICRO_TEXELS * kept + i] : filled_texel(i);
        kept_texels[MICRO_TEXELS * slot + i] = word;
#else
        uint word = filled_texel(i);
#endif
        uint seen = key_of(word);
        if (seen != 0u) {
            atomicOr(seen_bits[seen >> 5u], 1u << (seen & 31u));
        }
        micro_texels[MICRO_TEXELS * slot + i] = word;
    }
}
