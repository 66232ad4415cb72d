// Turns the micro-buffer of each primary point into a cache: the light that surfaces of several directions get of it, from
// the environment and from other surfaces, in cosine lobes. Also says where caches stand. A workgroup for each.
#include "common/frame.glsl"
#include "common/dispatch.glsl"
#include "common/random.glsl"
#include "common/octahedral.glsl"
#include "common/scene.glsl"
#include "common/environment.glsl"
#include "common/environment_means.glsl"
#include "common/micro_buffer.glsl"
#include "common/point_leaves.glsl"
#include "common/cache.glsl"
#include "shared/PointCounts.glsl"

layout(local_size_x = POINT_LANES) in;
layout(set = 0, binding = 3, std430) readonly buffer Counts { PointCounts point_counts; };
layout(set = 0, binding = 4, std430) readonly buffer Primaries { uint point_primaries[]; };
layout(set = 0, binding = 5, std430) readonly buffer MicroTexels { uint micro_texels[]; };
layout(set = 0, binding = 6, std430) buffer Irradiance { float point_irradiance[]; };
#include "common/point_irradiance.glsl"
layout(set = 0, binding = 7, std430) writeonly buffer CacheLobes { float cache_lobes[]; };
layout(set = 0, binding = 8, std430) writeonly buffer CachePlaces { CachePlace cache_places[]; };
layout(set = 0, binding = 9, std430) readonly buffer PrimaryLeaves { uvec4 primary_leaves[]; };
layout(set = 0, binding = 13, std430) readonly buffer PointAlbedos { uint point_albedos[]; };
#include "common/point_albedos.glsl"

// Radiance of each texel times its solid angle: three numbers from the sky, then three from surfaces.
shared float texel_light[CACHE_CHANNELS * PRIMARY_TEXELS];

void light_texels(uint slot, mat3 to_world, uint lane) {
    for (uint i = lane; i < PRIMARY_TEXELS; i += POINT_LANES) {
        MicroTexel texel = micro_table[i];
        uint seen = micro_texels[PRIMARY_TEXELS * slot + i];
        float coverage = coverage_of(seen);
        vec3 sky = vec3(0.0);
        vec3 bounce = vec3(0.0);
        if (is_used(texel) && coverage < 1.0) {
            sky = (1.0 - coverage) * environment_mean(to_world * texel.direction, texel.environment_level);
        }
        if (key_of(seen) != 0u) {
            uint key = key_of(seen);
            bounce = coverage * point_albedo(key >> 1u) * irradiance_of(key) / PI;
        }
        for (uint c = 0u; c < 3u; ++c) {
            texel_light[CACHE_CHANNELS * i + c] = texel.solid_angle * sky[c];
            texel_light[CACHE_CHANNELS * i + 3u + c] = texel.solid_angle * bounce[c];
        }
    }
}

// The light of one lobe, of which some may lie below the horizon: over what of it lies above.
void store_lobe(uint slot, uint lobe) {
    vec3 axis = lobe_direction(lobe);
    vec3 sky = vec3(0.0);
    vec3 bounce = vec3(0.0);
    float weights = 0.0;
    for (uint i = 0u; i < PRIMARY_TEXELS; ++i) {
        MicroTexel texel = micro_table[i];
        float cosine = max(dot(texel.direction, axis), 0.0);
        uint first = CACHE_CHANNELS * i;
        sky += cosine * vec3(texel_light[first], texel_light[first + 1u], texel_light[first + 2u]);
        bounce += cosine * vec3(texel_light[first + 3u], texel_light[first + 4u], texel_light[first + 5u]);
        weights += cosine * texel.solid_angle;
    }
    float scale = PI / max(weights, 1e-20);
    uint first = CACHE_CHANNELS * (LOBES * slot + lobe);
    for (uint c = 0u; c < 3u; ++c) {
        cache_lobes[first + c] = scale * sky[c];
        cache_lobes[first + 3u + c] = scale * bounce[c];
    }
}

void main() {
    uint slot = linear_group();
    uint lane = gl_LocalInvocationID.x;
    if (slot >= point_counts.primary_count) {
        return;
    }
    uint key = point_primaries[slot];
    PointPlace place = place_of_point(key, primary_leaves[slot]);
    mat3 to_world = micro_frame(place.normal_ws, key);
    light_texels(slot, to_world, lane);
    barrier();
    if (lane < LOBES) {
        store_lobe(slot, lane);
    }
    if (lane == 0u) {
        float reach = frame.cache_reach * point_node(key >> 1u).radius + CACHE_REACH_LEAVES * frame.point_leaf_radius;
        cache_places[slot] = CachePlace(place.position_ws, reach, place.normal_ws, key, to_world[0], 0u);
    }
}
