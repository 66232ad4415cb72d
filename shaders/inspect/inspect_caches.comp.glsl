// What a pixel's caches are, and what the one that counts most sees: the texels of its micro-buffer. One workgroup.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/octahedral.glsl"
#include "common/gbuffer.glsl"
#include "common/scene.glsl"
#include "common/environment.glsl"
#include "common/environment_means.glsl"
#include "common/micro_buffer.glsl"
#include "common/cache.glsl"
#include "common/cache_weights.glsl"
#include "shared/InspectedLevel.glsl"
#include "shared/InspectedSample.glsl"
#include "shared/InspectedTexel.glsl"
#include "shared/InspectedPixel.glsl"
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = POINT_LANES) in;
layout(set = 0, binding = 3) uniform texture2D depth_image;
layout(set = 0, binding = 4) uniform utexture2D normals_image;
layout(set = 0, binding = 5, std430) readonly buffer MicroTexels { uint micro_texels[]; };
layout(set = 0, binding = 6, std430) buffer Irradiance { float point_irradiance[]; };
#include "common/point_irradiance.glsl"
layout(set = 0, binding = 7, std430) readonly buffer CachePlaces { CachePlace cache_places[]; };
layout(set = 0, binding = 8, std430) readonly buffer ReferenceStarts { uint reference_starts[]; };
layout(set = 0, binding = 9, std430) readonly buffer References { uint cache_references[]; };
layout(set = 0, binding = 13, std430) readonly buffer PointAlbedos { uint point_albedos[]; };
#include "common/point_albedos.glsl"
layout(set = 0, binding = 14, std430) buffer Inspected { InspectedPixel inspected; };

struct Choice {
    uint slot;
    float weight;
    uint count;
    float weights;
};

// The cache of the pixel's tile with the largest weight; of equal ones the first by its slot, as lists have no order.
Choice choose_cache(uvec2 pixel, Receiver receiver, float stretch) {
    uint columns = (image_size().x + CACHE_TILE - 1u) / CACHE_TILE;
    uint tile = pixel.y / CACHE_TILE * columns + pixel.x / CACHE_TILE;
    uint end = min(reference_starts[tile + 1u], uint(cache_references.length()));
    Choice choice = Choice(0xffffffffu, 0.0, 0u, 0.0);
    for (uint i = reference_starts[tile]; i < end; ++i) {
        uint slot = cache_references[i];
        CachePlace place = cache_places[slot];
        float weight = cache_weight(place, receiver, cache_distance(place, receiver), stretch);
        if (weight > choice.weight || (weight > 0.0 && weight == choice.weight && slot < choice.slot)) {
            choice.slot = slot;
            choice.weight = weight;
        }
        choice.count += weight > 0.0 ? 1u : 0u;
        choice.weights += weight;
    }
    return choice;
}

// A texel's radiance, and how much of it surfaces cover; -1 where no direction lies in it.
InspectedTexel shown_texel(uint slot, uint i, mat3 to_world) {
    MicroTexel texel = micro_table[i];
    if (!is_used(texel)) {
        return InspectedTexel(vec3(0.0), -1.0);
    }
    uint seen = micro_texels[PRIMARY_TEXELS * slot + i];
    float coverage = coverage_of(seen);
    vec3 radiance = (1.0 - coverage) * environment_mean(to_world * texel.direction, texel.environment_level);
    uint key = key_of(seen);
    if (key != 0u) {
        radiance += coverage * point_albedo(key >> 1u) * irradiance_of(key) / PI;
    }
    return InspectedTexel(radiance, coverage);
}

void main() {
    uvec2 pixel = min(frame.inspected_pixel, image_size() - 1u);
    float depth = texelFetch(depth_image, ivec2(pixel), 0).x;
    Choice choice = Choice(0xffffffffu, 0.0, 0u, 0.0);
    if (depth > 0.0) {
        uvec2 normals = texelFetch(normals_image, ivec2(pixel), 0).xy;
        Receiver receiver =
            Receiver(position_from_depth(pixel, depth), unpack_octahedral(normals.y), unpack_octahedral(normals.x));
        choice = choose_cache(pixel, receiver, 1.0);
        if (choice.count == 0u) {
            choice = choose_cache(pixel, receiver, 2.0);
        }
    }
    bool found = choice.count > 0u;
    uint slot = found ? choice.slot : 0u;
    CachePlace place = cache_places[slot];
    if (gl_LocalInvocationIndex == 0u) {
        inspected.cache_count = choice.count;
        inspected.cache_slot = choice.slot;
        inspected.cache_key = found ? place.key : 0u;
        inspected.cache_share = found ? choice.weight / choice.weights : 0.0;
    }
    mat3 to_world = mat3(place.tangent_ws, cross(place.normal_ws, place.tangent_ws), place.normal_ws);
    for (uint i = gl_LocalInvocationIndex; i < PRIMARY_TEXELS; i += POINT_LANES) {
        inspected.cache_texels[i] = found ? shown_texel(slot, i, to_world) : InspectedTexel(vec3(0.0), -1.0);
    }
}
