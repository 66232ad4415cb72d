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

void main() {
    uint slot = linear_group();
    uint lane = gl_LocalInvocationID.x;
    if (slot >= point_counts.primary_count) {
        return;
    }
    uint key = point_primaries[slot];
    PointPlace place = place_of_point(key, primary_leaves[slot]);
    fill_micro_buffer(MicroEye(place.position_ws, micro_frame(place.normal_ws, key)), lane);
    for (uint i = lane; i < MICRO_TEXELS; i += POINT_LANES) {
        float coverage = micro_coverage(i);
        uint seen = coverage > 0.0 ? micro_key(i) : 0u;
        if (seen != 0u) {
            atomicOr(seen_bits[seen >> 5u], 1u << (seen & 31u));
        }
        micro_texels[MICRO_TEXELS * slot + i] = pack_micro_texel(coverage, seen);
    }
}
