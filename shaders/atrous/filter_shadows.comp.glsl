// One iteration of the edge-avoiding a-trous wavelet (Dammertz et al. 2010) over the shadowed estimate, and with
// FILTERS_UNSHADOWED over the unshadowed one by the same weights; both are per unit of what is in the latter's a. Weights
// stop at normals and positions, and where two pixels differ by more than their noise explains (Schied et al. 2017): each
// has a standard deviation, which the first iteration takes from the pixels around and the later ones carry along. It is
// that of both pixels together, so that a dark pixel counts for a bright one as much as the other way round: with the
// deviation of one of them, light would be lost. One thread per pixel.
#include "common/frame.glsl"
#include "common/octahedral.glsl"
#include "common/color.glsl"
#include "common/gbuffer.glsl"
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = TILE_SIZE, local_size_y = TILE_SIZE) in;
layout(set = 0, binding = 1) uniform texture2D depth_image;
layout(set = 0, binding = 2) uniform utexture2D normals_image;
// After the first iteration its a is the standard deviation of its luminance.
layout(set = 0, binding = 3) uniform texture2D shadowed_image;
layout(set = 0, binding = 4) uniform texture2D unshadowed_image;
layout(set = 0, binding = 5, rgba32f) uniform writeonly image2D out_shadowed;
#ifdef FILTERS_UNSHADOWED
layout(set = 0, binding = 6, rgba32f) uniform writeonly image2D out_unshadowed;
const bool FILTERS_BOTH = true;
#else
const bool FILTERS_BOTH = false;
#endif
layout(constant_id = 0) const uint IS_FIRST = 0u;
// Whether samples that stand out from all around them are cut in the first iteration.
layout(constant_id = 1) const uint CUTS = 0u;
// Whether the first iteration is given standard deviations, below 0 where they are not known.
layout(constant_id = 2) const uint HAS_DEVIATIONS = 0u;
layout(push_constant) uniform Push { int step_px; };

const float KERNEL[3] = float[](3.0 / 8.0, 1.0 / 4.0, 1.0 / 16.0);
// Distance from the tangent plane, in units of the pixel's footprint, at which a weight falls to 1/e.
const float PLANE_SIGMA = 4.0;
// Difference of two estimates, in standard deviations of both, at which a weight falls to 1/e.
const float NOISE_SIGMA = 3.0;
// Weight of neighbours on the same surface (all of them weigh 0.86) below which others count too, and the distance,
// in pixels' footprints per step, within which they do.
const float MIN_SUPPORT = 0.4;
const float NEARNESS_SIGMA = 4.0;
// The widest step would carry light across whole features.
const int LAST_RELAXED_STEP = 8;

struct Estimate {
    vec3 shadowed;
    vec3 unshadowed;
    float deviation;
};

// Weighted sums. In the first iteration the moments are those of the shadowed luminance relative to the pixel's own.
struct Sums {
    vec3 shadowed;
    vec3 unshadowed;
    vec2 moments;
    float variance;
    float weight;
};

const Sums NOTHING = Sums(vec3(0.0), vec3(0.0), vec2(0.0), 0.0, 0.0);

void add(inout Sums sums, Estimate estimate, float difference, float weight) {
    sums.shadowed += weight * estimate.shadowed;
    sums.unshadowed += weight * estimate.unshadowed;
    sums.moments += weight * vec2(difference, difference * difference);
    sums.variance += weight * weight * estimate.deviation * estimate.deviation;
    sums.weight += weight;
}

// Both together, the second in some measure.
Sums plus(Sums a, Sums b, float measure) {
    return Sums(
        a.shadowed + measure * b.shadowed,
        a.unshadowed + measure * b.unshadowed,
        a.moments + measure * b.moments,
        a.variance + measure * measure * b.variance,
        a.weight + measure * b.weight
    );
}

bool is_inside(ivec2 p) { return all(greaterThanEqual(p, ivec2(0))) && all(lessThan(p, ivec2(image_size()))); }

#include "atrous/outliers.glsl"

Estimate estimate_at(ivec2 p, float greatest) {
    vec4 shadowed = texelFetch(shadowed_image, p, 0);
    bool reads_unshadowed = FILTERS_BOTH || (IS_FIRST != 0u && CUTS != 0u);
    vec3 unshadowed = reads_unshadowed ? texelFetch(unshadowed_image, p, 0).rgb : vec3(0.0);
    bool has_deviation = IS_FIRST == 0u || HAS_DEVIATIONS != 0u;
    Estimate estimate = Estimate(shadowed.rgb, unshadowed, has_deviation ? shadowed.a : 1.0);
    if (IS_FIRST != 0u && CUTS != 0u) {
        float kept = min(1.0, greatest / max(luminance(unshadowed), 1e-30));
        estimate.shadowed *= kept;
        estimate.unshadowed *= kept;
    }
    return estimate;
}

// 1 where two estimates may well be of the same light.
float likeness(float difference, float deviations) {
    return exp(-abs(difference) / max(NOISE_SIGMA * deviations, 1e-30));
}

float power_of_32(float x) {
    float x2 = x * x;
    float x4 = x2 * x2;
    float x8 = x4 * x4;
    float x16 = x8 * x8;
    return x16 * x16;
}

// Whether nothing is known of a pixel's noise yet.
bool is_blind(Estimate center) { return IS_FIRST != 0u && (HAS_DEVIATIONS == 0u || center.deviation < 0.0); }

// A neighbour with a deviation that the pixel can do with. Where it has none it is taken to have the pixel's own.
Estimate beside(Estimate center, Estimate estimate) {
    if (IS_FIRST != 0u && HAS_DEVIATIONS != 0u) {
        float known = estimate.deviation < 0.0 ? center.deviation : estimate.deviation;
        estimate.deviation = is_blind(center) ? 1.0 : known;
    }
    return estimate;
}

// Standard deviation of what comes out. Where a pixel's own is not known yet it is what the pixels around differ by.
float deviation_of(Sums sums, bool is_blind) {
    float variance = sums.variance / (sums.weight * sums.weight);
    if (is_blind) {
        vec2 moments = sums.moments / sums.weight;
        variance *= max(moments.y - moments.x * moments.x, 0.0);
    }
    return sqrt(variance);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (!is_inside(pixel)) {
        return;
    }
    float depth = texelFetch(depth_image, pixel, 0).x;
    if (depth <= 0.0) {
        imageStore(out_shadowed, pixel, vec4(0.0));
#ifdef FILTERS_UNSHADOWED
        imageStore(out_unshadowed, pixel, vec4(0.0));
#endif
        return;
    }
    vec3 position = position_from_depth(uvec2(pixel), depth);
    vec3 normal = unpack_octahedral(texelFetch(normals_image, pixel, 0).x);
    float greatest = IS_FIRST != 0u && CUTS != 0u ? greatest_plausible(pixel) : 0.0;
    Estimate center = estimate_at(pixel, greatest);
    float center_luminance = luminance(center.shadowed);
    float footprint = 2.0 * length(frame.up_ws) / float(image_size().y) * frame.near / depth;
    float plane_scale = 1.0 / (PLANE_SIGMA * footprint);
    float nearness = NEARNESS_SIGMA * footprint * float(step_px);
    float nearness_scale = 1.0 / (nearness * nearness);
    Sums strict = NOTHING;
    Sums relaxed = NOTHING;
    float alike = 0.0;
    for (int y = -2; y <= 2; ++y) {
        for (int x = -2; x <= 2; ++x) {
            ivec2 p = pixel + ivec2(x, y) * step_px;
            float depth_p = is_inside(p) ? texelFetch(depth_image, p, 0).x : 0.0;
            if (depth_p <= 0.0) {
                continue;
            }
            vec3 offset = position_from_depth(uvec2(p), depth_p) - position;
            vec3 normal_p = unpack_octahedral(texelFetch(normals_image, p, 0).x);
            Estimate estimate = beside(center, estimate_at(p, greatest));
            float difference = luminance(estimate.shadowed) - center_luminance;
            float tap = KERNEL[abs(x)] * KERNEL[abs(y)];
            float weight = tap * power_of_32(max(dot(normal, normal_p), 0.0));
            weight *= exp(-abs(dot(offset, normal)) * plane_scale);
            alike += weight;
            float same_light = is_blind(center) ? 1.0 : likeness(difference, center.deviation + estimate.deviation);
            add(strict, estimate, difference, weight * same_light);
            if (step_px <= LAST_RELAXED_STEP) {
                add(relaxed, estimate, difference, tap * same_light * exp(-dot(offset, offset) * nearness_scale));
            }
        }
    }
    // A pixel whose surface few neighbours share (thin joints, skirtings, leaves) would keep the noise of its few samples:
    // the fewer are alike, the more it takes from whatever is near and may well have the same light.
    float support = alike - KERNEL[0] * KERNEL[0];
    float lack = step_px <= LAST_RELAXED_STEP ? clamp(1.0 - support / MIN_SUPPORT, 0.0, 1.0) : 0.0;
    Sums sums = plus(strict, relaxed, lack);
    imageStore(out_shadowed, pixel, vec4(sums.shadowed / sums.weight, deviation_of(sums, is_blind(center))));
#ifdef FILTERS_UNSHADOWED
    float unit = texelFetch(unshadowed_image, pixel, 0).a;
    imageStore(out_unshadowed, pixel, vec4(sums.unshadowed / sums.weight, unit));
#endif
}
