// Light at pixels from the caches around them, weighted by how near and how parallel these are (Ward et al. 1988), clamped
// by angle. A workgroup for each tile sorts the caches that reach it, so that sums have one order. With SHOW_CACHES it shows
// which caches these are, and how they are weighted.
#include "common/frame.glsl"
#include "common/octahedral.glsl"
#include "common/gbuffer.glsl"
#include "common/random.glsl"
#include "common/cache.glsl"
#include "common/cache_weights.glsl"
#include "shared/CacheCounts.glsl"
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = CACHE_TILE, local_size_y = CACHE_TILE) in;
layout(set = 0, binding = 1) uniform texture2D depth_image;
layout(set = 0, binding = 2) uniform utexture2D normals_image;
layout(set = 0, binding = 3, std430) readonly buffer CachePlaces { CachePlace cache_places[]; };
layout(set = 0, binding = 5, std430) readonly buffer ReferenceStarts { uint reference_starts[]; };
layout(set = 0, binding = 6, std430) readonly buffer References { uint cache_references[]; };
layout(set = 0, binding = 7, std430) buffer CacheCount { CacheCounts cache_counts; };
#ifdef SHOW_CACHES
// Caches, the largest of their shares in the light, and one of CACHES_*; in alpha the one of these that is shown.
layout(set = 0, binding = 8, rgba32f) uniform writeonly image2D out_values;
// The caches' colours mixed by their shares.
layout(set = 0, binding = 9, rgba32f) uniform writeonly image2D out_mix;
layout(constant_id = 0) const uint SHOWN = 0u;
#else
layout(set = 0, binding = 4, std430) readonly buffer CacheLobes { float cache_lobes[]; };
layout(set = 0, binding = 8, rgba32f) uniform writeonly image2D out_lighting;
// Whether the environment's own light is part of it.
layout(constant_id = 0) const uint HAS_SKY = 1u;
#endif

const uint LANES = CACHE_TILE * CACHE_TILE;
shared uint sorted[MOST_TILE_CACHES];

// Loads a tile's caches in ascending order; gives how many there are.
uint sort_caches(uint tile, uint lane) {
    uint first = reference_starts[tile];
    uint end = min(reference_starts[tile + 1u], uint(cache_references.length()));
    uint listed = end - min(first, end);
    uint count = min(listed, MOST_TILE_CACHES);
    for (uint i = lane; i < count; i += LANES) {
        sorted[i] = cache_references[first + i];
    }
    barrier();
    uint own[MOST_TILE_CACHES / LANES];
    uint ranks[MOST_TILE_CACHES / LANES];
    for (uint k = 0u; k < MOST_TILE_CACHES / LANES; ++k) {
        uint i = lane + k * LANES;
        own[k] = i < count ? sorted[i] : 0u;
        ranks[k] = 0u;
        for (uint j = 0u; i < count && j < count; ++j) {
            ranks[k] += sorted[j] < own[k] ? 1u : 0u;
        }
    }
    barrier();
    for (uint k = 0u; k < MOST_TILE_CACHES / LANES; ++k) {
        if (lane + k * LANES < count) {
            sorted[ranks[k]] = own[k];
        }
    }
    barrier();
    if (lane == 0u && listed > count) {
        atomicAdd(cache_counts.lost_references, listed - count);
    }
    return count;
}

struct Light {
    vec3 sky;
    vec3 bounce;
};

#ifndef SHOW_CACHES
// Irradiance that a cache holds for a normal.
Light cached_light(uint slot, CachePlace place, vec3 normal) {
    vec3 bitangent = cross(place.normal_ws, place.tangent_ws);
    vec2 at = lobe_place(vec3(dot(normal, place.tangent_ws), dot(normal, bitangent), dot(normal, place.normal_ws)));
    uvec2 low = min(uvec2(at), uvec2(LOBE_EDGE - 2u));
    vec2 part = at - vec2(low);
    Light light = Light(vec3(0.0), vec3(0.0));
    for (uint corner = 0u; corner < 4u; ++corner) {
        uvec2 step = uvec2(corner & 1u, corner >> 1u);
        vec2 shares = mix(1.0 - part, part, vec2(step));
        float share = shares.x * shares.y;
        uint lobe = (low.y + step.y) * LOBE_EDGE + low.x + step.x;
        uint first = CACHE_CHANNELS * (LOBE_EDGE * LOBE_EDGE * slot + lobe);
        light.sky += share * vec3(cache_lobes[first], cache_lobes[first + 1u], cache_lobes[first + 2u]);
        light.bounce += share * vec3(cache_lobes[first + 3u], cache_lobes[first + 4u], cache_lobes[first + 5u]);
    }
    return light;
}

#endif

// What the caches of a tile say about a receiver.
struct Found {
#ifdef SHOW_CACHES
    vec3 mix;
    float largest;
    uint count;
#else
    Light sum;
#endif
    float weight;
    uint nearest;
    float nearest_distance;
};

#ifdef SHOW_CACHES
Found nothing() { return Found(vec3(0.0), 0.0, 0u, 0.0, 0u, 1e30); }

// A strong colour, another one for each cache.
vec3 color_of_cache(uint key) {
    uint state = hash(key);
    float hue = 6.0 * float(state >> 8u) / 16777216.0;
    vec3 color = clamp(abs(mod(hue + vec3(0.0, 4.0, 2.0), 6.0) - 3.0) - 1.0, 0.0, 1.0);
    return mix(vec3(1.0), color, 0.5 + 0.5 * float(state & 0xffu) / 255.0);
}

void add_cache(inout Found found, uint slot, CachePlace place, vec3 normal, float weight) {
    found.mix += weight * color_of_cache(place.key);
    found.largest = max(found.largest, weight);
    found.count += 1u;
    found.weight += weight;
}
#else
Found nothing() { return Found(Light(vec3(0.0), vec3(0.0)), 0.0, 0u, 1e30); }

void add_cache(inout Found found, uint slot, CachePlace place, vec3 normal, float weight) {
    Light light = cached_light(slot, place, normal);
    found.sum.sky += weight * light.sky;
    found.sum.bounce += weight * light.bounce;
    found.weight += weight;
}
#endif

Found gather(Receiver receiver, uint count, float stretch) {
    Found found = nothing();
    for (uint i = 0u; i < count; ++i) {
        CachePlace place = cache_places[sorted[i]];
        float distance = cache_distance(place, receiver);
        if (distance < found.nearest_distance) {
            found.nearest = i;
            found.nearest_distance = distance;
        }
        float weight = cache_weight(place, receiver, distance, stretch);
        if (weight > 0.0) {
            add_cache(found, sorted[i], place, receiver.normal, weight);
        }
    }
    return found;
}

// What lights a receiver: the caches within reach, else those within twice the reach, else the nearest; gives which, one of
// CACHES_*.
uint find_caches(Receiver receiver, uint count, out Found found) {
    found = gather(receiver, count, 1.0);
    if (found.weight > 0.0) {
        return CACHES_IN_REACH;
    }
    atomicAdd(cache_counts.stretched_pixels, 1u);
    found = gather(receiver, count, 2.0);
    if (found.weight > 0.0) {
        return CACHES_STRETCHED;
    }
    if (found.nearest_distance < 1e30) {
        atomicAdd(cache_counts.nearest_pixels, 1u);
        uint slot = sorted[found.nearest];
        add_cache(found, slot, cache_places[slot], receiver.normal, 1.0);
        return CACHES_NEAREST;
    }
    atomicAdd(cache_counts.black_pixels, 1u);
    return CACHES_NONE;
}

#ifdef SHOW_CACHES
void write_pixel(uvec2 pixel, Receiver receiver, uint count) {
    Found found;
    uint way = find_caches(receiver, count, found);
    float unit = found.weight > 0.0 ? 1.0 / found.weight : 0.0;
    float shown = SHOWN == 0u ? float(found.count) : float(way);
    imageStore(out_values, ivec2(pixel), vec4(found.count, unit * found.largest, way, shown));
    imageStore(out_mix, ivec2(pixel), vec4(unit * found.mix, 1.0));
}

void write_nothing(uvec2 pixel) {
    imageStore(out_values, ivec2(pixel), vec4(0.0, 0.0, 0.0, -1.0));
    imageStore(out_mix, ivec2(pixel), vec4(0.0, 0.0, 0.0, -1.0));
}
#else
void write_pixel(uvec2 pixel, Receiver receiver, uint count) {
    Found found;
    vec3 lighting = vec3(0.0);
    if (find_caches(receiver, count, found) != CACHES_NONE) {
        Light light = Light(found.sum.sky / found.weight, found.sum.bounce / found.weight);
        lighting = (light.bounce + (HAS_SKY != 0u ? light.sky : vec3(0.0))) / PI;
    }
    imageStore(out_lighting, ivec2(pixel), vec4(lighting, 1.0));
}

void write_nothing(uvec2 pixel) { imageStore(out_lighting, ivec2(pixel), vec4(vec3(0.0), 1.0)); }
#endif

void main() {
    uint tile = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint count = sort_caches(tile, gl_LocalInvocationIndex);
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, image_size()))) {
        return;
    }
    float depth = texelFetch(depth_image, ivec2(pixel), 0).x;
    if (depth <= 0.0) {
        write_nothing(pixel);
        return;
    }
    uvec2 normals = texelFetch(normals_image, ivec2(pixel), 0).xy;
    write_pixel(pixel, Receiver(position_from_depth(pixel, depth), unpack_octahedral(normals.y), unpack_octahedral(normals.x)), count);
}
