// Light at pixels from the caches around them, weighted by how near and how parallel these are (Ward et al. 1988), clamped
// by angle. A workgroup for each tile sorts the caches that reach it, so that sums have one order.
#include "common/frame.glsl"
#include "common/octahedral.glsl"
#include "common/gbuffer.glsl"
#include "common/random.glsl"
#include "common/cache.glsl"
#include "shared/CacheCounts.glsl"
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = CACHE_TILE, local_size_y = CACHE_TILE) in;
layout(set = 0, binding = 1) uniform texture2D depth_image;
layout(set = 0, binding = 2) uniform utexture2D normals_image;
layout(set = 0, binding = 3, std430) readonly buffer CachePlaces { CachePlace cache_places[]; };
layout(set = 0, binding = 4, std430) readonly buffer CacheLobes { float cache_lobes[]; };
layout(set = 0, binding = 5, std430) readonly buffer ReferenceStarts { uint reference_starts[]; };
layout(set = 0, binding = 6, std430) readonly buffer References { uint cache_references[]; };
layout(set = 0, binding = 7, std430) buffer CacheCount { CacheCounts cache_counts; };
layout(set = 0, binding = 8, rgba32f) uniform writeonly image2D out_lighting;
// Whether the environment's own light is part of it.
layout(constant_id = 0) const uint HAS_SKY = 1u;

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

struct Receiver {
    vec3 position;
    vec3 geometric;
    vec3 normal;
};

// How far before or behind its plane a cache still lights.
const float WIDEST_STEP = 0.25;

// How far from a cache a receiver is, by place and by angle; 1 is too far.
float cache_distance(CachePlace place, Receiver receiver) {
    vec3 offset = receiver.position - place.position_ws;
    float turned = max(1.0 - dot(receiver.geometric, place.normal_ws), 0.0);
    return length(offset) / place.reach + sqrt(turned / max(1.0 - frame.cache_cone_cos, 1e-6));
}

// How far a receiver lies before or behind the plane of a cache, over its reach.
float plane_distance(CachePlace place, Receiver receiver) {
    vec3 offset = receiver.position - place.position_ws;
    return 0.5 * abs(dot(offset, receiver.geometric + place.normal_ws)) / place.reach;
}

// Of how far a cache reaches, how near counts as being there: less would show single caches as dots.
const float NEAREST = 0.25;

struct Light {
    vec3 sky;
    vec3 bounce;
};

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

// What the caches of a tile say about a receiver.
struct Found {
    Light sum;
    float weight;
    uint nearest;
    float nearest_distance;
};

Found gather(Receiver receiver, uint count, float stretch) {
    Found found = Found(Light(vec3(0.0), vec3(0.0)), 0.0, 0u, 1e30);
    for (uint i = 0u; i < count; ++i) {
        CachePlace place = cache_places[sorted[i]];
        float distance = cache_distance(place, receiver);
        if (distance < found.nearest_distance) {
            found.nearest = i;
            found.nearest_distance = distance;
        }
        if (distance < stretch && plane_distance(place, receiver) <= WIDEST_STEP * stretch) {
            float weight = 1.0 / max(distance / stretch, NEAREST) - 1.0;
            Light light = cached_light(sorted[i], place, receiver.normal);
            found.sum.sky += weight * light.sky;
            found.sum.bounce += weight * light.bounce;
            found.weight += weight;
        }
    }
    return found;
}

// Light at a receiver: of the caches within reach, else of those within twice the reach, else of the nearest.
Light light_at(Receiver receiver, uint count) {
    Found found = gather(receiver, count, 1.0);
    if (found.weight <= 0.0) {
        atomicAdd(cache_counts.stretched_pixels, 1u);
        found = gather(receiver, count, 2.0);
    }
    if (found.weight > 0.0) {
        return Light(found.sum.sky / found.weight, found.sum.bounce / found.weight);
    }
    if (found.nearest_distance >= 1e30) {
        atomicAdd(cache_counts.black_pixels, 1u);
        return Light(vec3(0.0), vec3(0.0));
    }
    atomicAdd(cache_counts.nearest_pixels, 1u);
    uint slot = sorted[found.nearest];
    return cached_light(slot, cache_places[slot], receiver.normal);
}

void main() {
    uint tile = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint count = sort_caches(tile, gl_LocalInvocationIndex);
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, image_size()))) {
        return;
    }
    float depth = texelFetch(depth_image, ivec2(pixel), 0).x;
    vec3 lighting = vec3(0.0);
    if (depth > 0.0) {
        uvec2 normals = texelFetch(normals_image, ivec2(pixel), 0).xy;
        Receiver receiver =
            Receiver(position_from_depth(pixel, depth), unpack_octahedral(normals.y), unpack_octahedral(normals.x));
        Light light = light_at(receiver, count);
        lighting = (light.bounce + (HAS_SKY != 0u ? light.sky : vec3(0.0))) / PI;
    }
    imageStore(out_lighting, ivec2(pixel), vec4(lighting, 1.0));
}
