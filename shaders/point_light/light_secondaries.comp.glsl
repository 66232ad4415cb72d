// Irradiance of the secondary points that need it: from the environment by a micro-buffer that is not kept, as only what is
// not covered counts, of rays or with MICRO_POINTS of points; from suns and lamps by rays. A workgroup for each.
#include "common/frame.glsl"
#include "common/dispatch.glsl"
#include "common/random.glsl"
#include "common/octahedral.glsl"
#include "common/scene.glsl"
#include "common/punctual.glsl"
#include "common/environment.glsl"
#include "common/environment_means.glsl"
#include "common/micro_buffer.glsl"
#include "common/point_leaves.glsl"
#include "common/point_light.glsl"
#include "common/point_sum.glsl"
#include "shared/PointCounts.glsl"

layout(local_size_x = POINT_LANES) in;
#ifdef ALL_LEAVES
layout(push_constant) uniform Push { uint round; uint part; };

// The key of this workgroup, 0 beyond the last: all sides of leaves, in parts.
uint key_of_group() {
    uint index = part * KEYS_PER_PART + gl_WorkGroupID.x;
    return index < 2u * frame.point_leaf_count ? 2u * frame.point_leaf_count + index : 0u;
}

uvec4 leaves_of(uint key) { return uvec4(NO_LEAF); }
#else
layout(set = 0, binding = 3, std430) readonly buffer Counts { PointCounts point_counts; };
layout(set = 0, binding = 4, std430) readonly buffer Needed { uint point_needed[]; };

layout(set = 0, binding = 6, std430) readonly buffer SeenLeaves { uvec4 seen_leaves[]; };

uvec4 leaves_of(uint key) { return seen_leaves[key]; }
uint key_of_group() { return linear_group() < point_counts.needed_count ? point_needed[linear_group()] : 0u; }
#endif
layout(set = 0, binding = 5, std430) buffer Irradiance { float point_irradiance[]; };
#include "common/point_irradiance.glsl"

#ifdef MICRO_POINTS
layout(constant_id = 0) const uint BINARY_COVERAGE = 0u;
#define MICRO_EDGE SECONDARY_EDGE
#include "micro_buffers/splat.glsl"

// Share of a texel that nothing covers, once the micro-buffer is filled.
float openness(PointPlace place, uint texel, vec3 direction) { return 1.0 - micro_coverage(texel); }
#else
// Whether nothing covers a texel.
float openness(PointPlace place, uint texel, vec3 direction) {
    return is_open(place.position_ws, direction) ? 1.0 : 0.0;
}
#endif

// Share of a lane of what comes from the environment.
vec3 sky_irradiance(PointPlace place, mat3 to_world, uint lane) {
    vec3 sum = vec3(0.0);
    for (uint i = lane; i < SECONDARY_TEXELS; i += POINT_LANES) {
        MicroTexel texel = micro_table[i];
        vec3 direction = to_world * texel.direction;
        vec3 radiance = environment_mean(direction, texel.environment_level);
        if (is_used(texel) && any(greaterThan(radiance, vec3(0.0)))) {
            sum += openness(place, i, direction) * texel.cosine_weight * radiance;
        }
    }
    return sum;
}

void main() {
    uint lane = gl_LocalInvocationID.x;
    uint key = key_of_group();
    if (key == 0u) {
        return;
    }
    uvec4 leaves = leaves_of(key);
    PointPlace place = place_of_point(key, leaves);
    mat3 to_world = micro_frame(place.normal_ws, key);
#ifdef MICRO_POINTS
    fill_micro_buffer(MicroEye(place.position_ws, to_world), lane);
#endif
    vec3 irradiance = sky_irradiance(place, to_world, lane) + lamp_irradiance(key, leaves, lane, POINT_LANES);
    irradiance = sum_over_lanes(lane, irradiance);
    if (lane == 0u) {
        set_irradiance(key, irradiance);
    }
}
