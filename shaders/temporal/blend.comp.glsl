// Blends the estimates of this frame into what was reprojected of the frames before: a mean that forgets slowly. Shadowed
// and unshadowed estimate have the same weights, so that their ratio is that of their means. In further rounds of samples
// (ROUND) it goes on with its own result, where that is still short, and where one may follow (LISTS_TILES) it lists the tiles
// that take part. One thread per pixel.
#include "common/frame.glsl"
#include "common/color.glsl"
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = TILE_SIZE, local_size_y = TILE_SIZE) in;
// Whether histories are of light itself rather than per unit of the frame's own unshadowed light.
layout(constant_id = 0) const uint KEEPS_LIGHT = 0u;
// Whether samples that stand out from all around them are cut.
layout(constant_id = 1) const uint CUTS = 0u;
// Whether the estimates are light by themselves rather than per unit of light that is known.
layout(constant_id = 3) const uint IS_RADIANCE = 0u;
layout(push_constant) uniform Push {
    int step_px;
    // A frame weighs at least this much.
    float least_weight;
#if defined(ROUND) || defined(LISTS_TILES)
    float enough_frames;
#endif
};
#define ROUND_TILES_BINDING 12
// Both estimates per unit of the latter's a.
layout(set = 0, binding = 1) uniform texture2D shadowed_image;
layout(set = 0, binding = 2) uniform texture2D unshadowed_image;
// The means with this frame: a is the number of frames, and of the other the variance of a frame's shadowed luminance.
#ifdef ROUND
layout(set = 0, binding = 6, rgba32f) uniform image2D history_shadowed;
layout(set = 0, binding = 7, rgba32f) uniform image2D history_unshadowed;
#else
layout(set = 0, binding = 6, rgba32f) uniform writeonly image2D history_shadowed;
layout(set = 0, binding = 7, rgba32f) uniform writeonly image2D history_unshadowed;
// The same of the frames before.
layout(set = 0, binding = 3) uniform texture2D reprojected_shadowed;
layout(set = 0, binding = 4) uniform texture2D reprojected_unshadowed;
// With KEEPS_LIGHT: a is the mean unit.
layout(set = 0, binding = 5) uniform texture2D reprojected_lighting;
// r: how much of the history tiles of pixels give up (temporal/compare_tiles).
layout(set = 0, binding = 11) uniform texture2D given_up_image;
layout(constant_id = 2) const uint HAS_TILES = 0u;
#endif
// The same for the filter: per unit, with a standard deviation (below 0 where it is not known), and the unit.
layout(set = 0, binding = 8, rgba32f) uniform writeonly image2D out_shadowed;
layout(set = 0, binding = 9, rgba32f) uniform writeonly image2D out_unshadowed;
layout(set = 0, binding = 10) uniform texture2D depth_image;

// A frame's deviation weighs at least this much in the variance.
const float LEAST_VARIANCE_WEIGHT = 0.1;
// From so many frames on their variance tells the noise of their mean.
const float KNOWN_FRAMES = 4.0;
const float UNKNOWN = -1.0;
// Of a deviation that is known, what the filter is told: it is made for those that are guessed from the pixels around, and
// passes differences of several. Of a mean, most of those are light.
const float TOLD_DEVIATION = 0.5;
// The filter is never stricter than for a luminance that is known to this, per unit: it passes differences of 0.02. The unit
// of light by itself is what arrives without shadow.
const float LEAST_DEVIATION = 0.02 / 6.0;

bool is_inside(ivec2 p) { return all(greaterThanEqual(p, ivec2(0))) && all(lessThan(p, ivec2(image_size()))); }

#include "atrous/outliers.glsl"
#include "common/rounds.glsl"

// What a pixel's estimates are multiplied by so that they do not stand out.
float kept_share(ivec2 pixel, vec3 unshadowed) {
    return CUTS != 0u ? min(1.0, greatest_plausible(pixel) / max(luminance(unshadowed), 1e-30)) : 1.0;
}

#ifndef ROUND
// How much of a pixel's history to give up, 0 to 1: bilinear between the middles of tiles.
float given_up(ivec2 pixel) {
    if (HAS_TILES == 0u) {
        return 0.0;
    }
    ivec2 last = (ivec2(image_size()) - 1) / int(TILE_SIZE);
    vec2 at = (vec2(pixel) + 0.5) / float(TILE_SIZE) - 0.5;
    ivec2 first = ivec2(floor(at));
    vec2 share = at - floor(at);
    float sum = 0.0;
    for (int i = 0; i < 4; ++i) {
        ivec2 corner = ivec2(i & 1, i >> 1);
        vec2 along = mix(1.0 - share, share, vec2(corner));
        sum += along.x * along.y * texelFetch(given_up_image, clamp(first + corner, ivec2(0), last), 0).r;
    }
    return sum;
}
#endif

void store(ivec2 pixel, vec4 shadowed, vec4 unshadowed, float unit, float deviation) {
    imageStore(history_shadowed, pixel, shadowed);
    imageStore(history_unshadowed, pixel, unshadowed);
    float scale = KEEPS_LIGHT != 0u ? 1.0 / max(unit, 1e-30) : 1.0;
    float least = LEAST_DEVIATION * (IS_RADIANCE != 0u ? luminance(unshadowed.rgb) : 1.0);
    imageStore(out_shadowed, pixel, vec4(shadowed.rgb * scale, deviation >= 0.0 ? max(deviation * scale, least) : UNKNOWN));
    imageStore(out_unshadowed, pixel, vec4(unshadowed.rgb * scale, unit));
}

// Gives the number of frames then.
float blend(ivec2 pixel) {
#ifdef ROUND
    vec4 before_shadowed = imageLoad(history_shadowed, pixel);
    vec4 before_unshadowed = imageLoad(history_unshadowed, pixel);
    if (!is_short(before_shadowed.a)) {
        return before_shadowed.a;
    }
#else
    vec4 before_shadowed = texelFetch(reprojected_shadowed, pixel, 0);
    vec4 before_unshadowed = texelFetch(reprojected_unshadowed, pixel, 0);
#endif
    vec3 shadowed = texelFetch(shadowed_image, pixel, 0).rgb;
    vec4 unshadowed = texelFetch(unshadowed_image, pixel, 0);
    bool has_surface = texelFetch(depth_image, pixel, 0).x > 0.0;
    float scale = KEEPS_LIGHT != 0u ? unshadowed.a : 1.0;
    float kept = scale * (has_surface ? kept_share(pixel, unshadowed.rgb) : 1.0);
    float frames = before_shadowed.a + 1.0;
    if (frames <= 1.0) {
        // The frame's own estimates as they are: what the filter gets is what it gets without history.
        imageStore(history_shadowed, pixel, vec4(shadowed * kept, has_surface ? 1.0 : 0.0));
        imageStore(history_unshadowed, pixel, vec4(unshadowed.rgb * kept, 0.0));
        imageStore(out_shadowed, pixel, vec4(shadowed, UNKNOWN));
        imageStore(out_unshadowed, pixel, unshadowed);
        return has_surface ? 1.0 : 0.0;
    }
    float weight = max(1.0 / frames, least_weight);
    float unit = unshadowed.a;
#ifndef ROUND
    weight = max(weight, given_up(pixel));
    if (KEEPS_LIGHT != 0u) {
        unit = mix(texelFetch(reprojected_lighting, pixel, 0).a, unit, weight);
    }
#endif
    float residual = luminance(shadowed) * kept - luminance(before_shadowed.rgb);
    // The first residual is that of the second frame.
    float variance_weight = max(1.0 / (frames - 1.0), LEAST_VARIANCE_WEIGHT);
    float variance = mix(before_unshadowed.a, residual * residual, min(variance_weight, 1.0));
    // Of the mean: that of a frame over their number, and once their weights fall off that of such a mean.
    frames = min(frames, 1.0 / weight);
    float of_mean = max(1.0 / frames, least_weight / (2.0 - least_weight));
    float deviation = frames >= KNOWN_FRAMES ? TOLD_DEVIATION * sqrt(variance * of_mean) : UNKNOWN;
    store(pixel, vec4(mix(before_shadowed.rgb, shadowed * kept, weight), frames),
          vec4(mix(before_unshadowed.rgb, unshadowed.rgb * kept, weight), variance), unit, deviation);
    return frames;
}

void main() {
#ifdef ROUND
    if (!has_tile()) {
        return;
    }
    uvec2 pixel = pixel_in_tile();
#else
    uvec2 pixel = gl_GlobalInvocationID.xy;
#endif
    float frames = is_inside(ivec2(pixel)) ? blend(ivec2(pixel)) : 0.0;
#ifdef LISTS_TILES
    list_tile(pixel / TILE_SIZE, is_short(frames));
#endif
}
