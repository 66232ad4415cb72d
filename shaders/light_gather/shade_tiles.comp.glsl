// Lighting by gathering: a workgroup finds the lights within reach of its tile, and every pixel sums them and picks its
// shadow samples in registers. The same lights, weights and random numbers as light_volumes with exact reservoirs, but no
// fragments, no blending and no atomics in memory. One workgroup per tile of TILE_SIZE^2 pixels of a sub-image; in further rounds
// (ROUND) per tile of the picture with a pixel that takes part.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/color.glsl"
#include "common/octahedral.glsl"
#include "common/gbuffer.glsl"
#include "common/lights.glsl"
#include "common/light_texels.glsl"
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = TILE_SIZE, local_size_y = TILE_SIZE) in;
layout(set = 0, binding = 1) uniform texture2D light_texels;
layout(set = 0, binding = 2, std430) readonly buffer SubImages { uint sub_images[]; };
layout(set = 0, binding = 3, std430) readonly buffer Grid { GridPlacement grid; };
layout(set = 0, binding = 4) uniform texture2D depth_image;
layout(set = 0, binding = 5) uniform utexture2D normals_image;
layout(set = 0, binding = 6, std430) readonly buffer Occupancy { uint occupancy[]; };
layout(set = 0, binding = 7, std430) readonly buffer Ranks { uint ranks[]; };
layout(set = 0, binding = 8, std430) readonly buffer LevelTable { uint level_table[]; };
#ifdef ROUND
layout(push_constant) uniform Push {
    uint round_number;
    float enough_frames;
};
// a: frames in the history, this one's rounds so far included.
layout(set = 0, binding = 16) uniform texture2D history_shadowed;
#define ROUND_TILES_BINDING 17
#else
layout(set = 0, binding = 9, rgba32f) uniform writeonly image2D out_lighting;
// lights_tested[pixel]: candidates, counted in frames for statistics only.
layout(set = 0, binding = 10, std430) writeonly buffer LightsTested { uint lights_tested[]; };
layout(constant_id = 0) const uint COUNT_LIGHTS_TESTED = 0u;
#endif
#ifndef RESERVOIR_NONE
// (light, key) per sample: the halves of the word that light_volumes keeps with exact reservoirs.
layout(set = 0, binding = 11, std430) writeonly buffer Reservoirs { uvec2 reservoirs[]; };
#endif
#ifdef FIRST_LEVEL_0
layout(set = 0, binding = 12, std430) readonly buffer BucketStarts { uint bucket_starts[]; };
layout(set = 0, binding = 13, std430) readonly buffer BucketLights { uint bucket_lights[]; };
layout(set = 0, binding = 14, std430) readonly buffer CellBits { uint cell_bits[]; };
layout(set = 0, binding = 15, std430) readonly buffer CellRanks { uint cell_ranks[]; };
#endif
// Shadow samples of a pixel, known to the compiler so that reservoirs stay in registers; at least 1.
layout(constant_id = 2) const uint SAMPLES = 1u;

#include "common/level_table.glsl"
#include "merge/sub_images.glsl"
#ifdef FIRST_LEVEL_0
#include "common/cells.glsl"
#endif
#include "light_gather/tile_bounds.glsl"
#include "common/vertex_rows.glsl"
#include "light_gather/find_lights.glsl"
#include "common/rounds.glsl"
#include "common/samples_seed.glsl"

// Above every key.
#define INFINITY uintBitsToFloat(0x7f800000u)

struct Pixel {
    bool found;
    vec3 position_ws;
    vec3 normal;
    float distance;
    uint index;
};

// What a pixel gathers: radiance per unit albedo, in a the sum of weights f; per shadow sample the smallest key so far
// and its light.
struct Gathered {
    vec4 lighting;
    float keys[SAMPLES];
    uint lights[SAMPLES];
};

// Pixel `inside` of a sub-image.
Pixel pixel_at(uvec2 inside, uvec2 sub_image) {
    uvec2 xy = inside * interleave() + sub_image;
    bool in_image = all(lessThan(inside, sub_image_size())) && all(lessThan(xy, image_size()));
    float depth = in_image ? texelFetch(depth_image, ivec2(xy), 0).x : 0.0;
    uint index = reservoir_index(sub_image * sub_image_size() + inside);
#ifdef ROUND
    if (depth > 0.0 && !is_short(texelFetch(history_shadowed, ivec2(xy), 0).a)) {
        depth = 0.0;
    }
#endif
    if (depth <= 0.0) {
        return Pixel(false, vec3(0.0), vec3(0.0), 0.0, index);
    }
    vec3 normal = unpack_octahedral(texelFetch(normals_image, ivec2(xy), 0).x);
    return Pixel(true, position_from_depth(xy, depth), normal, frame.near / depth, index);
}

// Offers a light with weight f > 0 to every reservoir: the one with the smallest key stays, as in
// light_volumes/reservoir.glsl.
void pick(Pixel pixel, uint light, float f, inout Gathered gathered) {
    uint stream = hash(light, pixel.index, samples_seed());
    for (uint i = 0u; i < SAMPLES; ++i) {
        float key = race_key(stream, i, f);
        if (key < gathered.keys[i] || (key == gathered.keys[i] && light < gathered.lights[i])) {
            gathered.keys[i] = key;
            gathered.lights[i] = light;
        }
    }
}

void add_light(Pixel pixel, uint candidate, inout Gathered gathered) {
    uint level = candidate >> LEVEL_SHIFT;
    uint light = candidate & LIGHT_MASK;
    vec4 position_radius = texelFetch(light_texels, light_texel(light, 0u), 0);
    vec4 lobe_luminance = texelFetch(light_texels, light_texel(light, 1u), 0);
    vec4 flux_weight = texelFetch(light_texels, light_texel(light, 2u), 0);
    vec3 offset = position_radius.xyz - pixel.position_ws;
    float distance = length(offset);
    float weight = blend_weight(distance, position_radius.w, level, first_level(), top_level());
    float own_luminance = lobe_luminance.w / flux_weight.w;
    float response = weight * light_response(offset, distance, pixel.normal, lobe_luminance.xyz, level, own_luminance);
    vec3 radiance = response * flux_weight.xyz;
    float f = level >= first_shadow_level() ? luminance(radiance) : 0.0;
    gathered.lighting += vec4(radiance, f);
#ifndef RESERVOIR_NONE
    if (f > 0.0) {
        pick(pixel, light, f, gathered);
    }
#endif
}

// Which of up to 32 candidates from `first` on lie within reach and in front of the pixel's surface, as bits. A test of
// its own, because most candidates end here, and devices that run pixels in lockstep pay for all of `add_light` when one
// of them needs it.
uint lights_in_sight(Pixel pixel, uint first, uint count) {
    uint in_sight = 0u;
    for (uint i = 0u; i < count; ++i) {
        uint level = candidates[first + i] >> LEVEL_SHIFT;
        vec4 light = texelFetch(light_texels, light_texel(candidates[first + i] & LIGHT_MASK, 0u), 0);
        float radius_squared = light.w * light.w;
        vec3 offset = light.xyz - pixel.position_ws;
        float distance_squared = dot(offset, offset);
        bool near = level == top_level() || distance_squared < 4.0 * radius_squared;
        bool far = level == first_level() || distance_squared > 0.25 * radius_squared;
        in_sight |= uint(near && far && dot(pixel.normal, offset) > 0.0) << i;
    }
    return in_sight;
}

void add_candidates(Pixel pixel, uint count, inout Gathered gathered) {
    for (uint first = 0u; first < count; first += 32u) {
        uint bits = lights_in_sight(pixel, first, min(count - first, 32u));
        for (; bits != 0u; bits &= bits - 1u) {
            add_light(pixel, candidates[first + uint(findLSB(bits))], gathered);
        }
    }
}

void store(uvec2 fragment, Pixel pixel, uint tested, Gathered gathered) {
#ifndef ROUND
    imageStore(out_lighting, ivec2(fragment), gathered.lighting);
    if (COUNT_LIGHTS_TESTED != 0u) {
        lights_tested[pixel.index] = pixel.found ? tested : 0u;
    }
#endif
#ifndef RESERVOIR_NONE
    for (uint i = 0u; i < SAMPLES; ++i) {
        uint key = gathered.lights[i] == NO_LIGHT ? NO_LIGHT : floatBitsToUint(gathered.keys[i]);
        reservoirs[pixel.index * SAMPLES + i] = uvec2(gathered.lights[i], key);
    }
#endif
}

void main() {
#ifdef ROUND
    if (!has_tile()) {
        return;
    }
    uint sub_image = 0u;
    uvec2 inside = pixel_in_tile();
#else
    uint sub_image = gl_WorkGroupID.z;
    uvec2 inside = gl_GlobalInvocationID.xy;
#endif
    uvec2 column_row = uvec2(sub_image % interleave(), sub_image / interleave());
    Pixel pixel = pixel_at(inside, column_row);
    // Wider than this, two clusters let fewer lights pass than they cost.
    float split_distance = 3.0 * alpha() * cell_size(grid.h_top, 1u);
    bound_tile(pixel.found, pixel.position_ws - frame.eye_ws, pixel.normal, pixel.distance, split_distance);
    Gathered gathered;
    gathered.lighting = vec4(0.0);
    for (uint i = 0u; i < SAMPLES; ++i) {
        gathered.keys[i] = INFINITY;
        gathered.lights[i] = NO_LIGHT;
    }
    uint tested = 0u;
    uint most = 1u;
    for (uint first = 0u; first < most; first += FOUND_PER_LANE) {
        uint count = list_candidates(sub_image, first, most);
        add_candidates(pixel, count, gathered);
        tested += count;
        barrier();
    }
    if (all(lessThan(inside, sub_image_size()))) {
        store(column_row * sub_image_size() + inside, pixel, tested, gathered);
    }
}
