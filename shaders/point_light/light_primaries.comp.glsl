// Irradiance of primary points: from the environment where nothing covers the texels of their micro-buffers, and from suns
// and lamps by rays; with GATHERS_LIGHTS of the lighting grid hierarchy too. A workgroup for each.
#include "common/frame.glsl"
#include "common/dispatch.glsl"
#include "common/random.glsl"
#ifdef GATHERS_LIGHTS
#include "common/color.glsl"
#endif
#include "common/octahedral.glsl"
#include "common/scene.glsl"
#include "common/punctual.glsl"
#include "common/environment.glsl"
#include "common/emitters.glsl"
#include "common/environment_means.glsl"
#include "common/micro_buffer.glsl"
#include "common/point_leaves.glsl"
PointPlace place_of_word(uint leaf) { return place_of_leaf_key(unpack_leaf(leaf)); }
#include "common/point_light.glsl"
#ifdef GATHERS_LIGHTS
#include "point_light/hierarchy_light.glsl"
#else
// The first bounce is all.
vec3 hierarchy_irradiance(uint key, uint place_count, uint lane) { return vec3(0.0); }
#endif
#include "common/point_sum.glsl"
#include "shared/PointCounts.glsl"

layout(local_size_x = POINT_LANES) in;
layout(set = 0, binding = 3, std430) readonly buffer Counts { PointCounts point_counts; };
layout(set = 0, binding = 4, std430) readonly buffer Primaries { uint point_primaries[]; };
layout(set = 0, binding = 5, std430) readonly buffer MicroTexels { uint micro_texels[]; };
layout(set = 0, binding = 7, std430) readonly buffer PrimaryLeaves { uvec4 primary_leaves[]; };
layout(set = 0, binding = 6, std430) buffer Irradiance { float point_irradiance[]; };
#include "common/point_irradiance.glsl"

vec3 sky_irradiance(uint slot, mat3 to_world, uint lane) {
    vec3 sum = vec3(0.0);
    for (uint i = lane; i < PRIMARY_TEXELS; i += POINT_LANES) {
        MicroTexel texel = micro_table[i];
        float open = 1.0 - coverage_of(micro_texels[PRIMARY_TEXELS * slot + i]);
        if (is_used(texel) && open > 0.0) {
            vec3 radiance = environment_mean(to_world * texel.direction, texel.environment_level);
            sum += open * texel.cosine_weight * radiance;
        }
    }
    return sum;
}

void main() {
    uint slot = linear_group();
    uint lane = gl_LocalInvocationID.x;
    if (slot >= point_counts.primary_count) {
        return;
    }
    uint key = point_primaries[slot];
    uint places = find_lit_places(primary_leaves[slot], key, lane);
    mat3 to_world = micro_frame(lit_places[0].normal_ws, key);
    vec3 irradiance = sky_irradiance(slot, to_world, lane) + lamp_irradiance(places, lane, POINT_LANES) +
                      emitter_light_at_places(key, places, lane, POINT_LANES) +
                      hierarchy_irradiance(key, places, lane);
    irradiance = sum_over_lanes(lane, irradiance);
    if (lane == 0u) {
        set_irradiance(key, irradiance);
    }
}
