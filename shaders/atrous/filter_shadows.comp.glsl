// One iteration of the edge-avoiding a-trous wavelet (Dammertz et al. 2010) over the shadowed and the unshadowed
// estimate at once, both per unit of what is in a. Weights stop at normals, positions and colours: that of the analytic lighting, which has no
// noise, and that of the shadow itself, with a width that halves from iteration to iteration. One thread per pixel.
#include "common/frame.glsl"
#include "common/octahedral.glsl"
#include "common/color.glsl"
#include "common/gbuffer.glsl"
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = TILE_SIZE, local_size_y = TILE_SIZE) in;
layout(set = 0, binding = 1) uniform texture2D depth_image;
layout(set = 0, binding = 2) uniform utexture2D normals_image;
layout(set = 0, binding = 3) uniform texture2D lighting_image;
layout(set = 0, binding = 4) uniform texture2D shadowed_image;
layout(set = 0, binding = 5) uniform texture2D unshadowed_image;
layout(set = 0, binding = 6, rgba32f) uniform writeonly image2D out_shadowed;
layout(set = 0, binding = 7, rgba32f) uniform writeonly image2D out_unshadowed;
// ratio_sigma: difference of the shadow ratio at which a weight falls to 1/e; smaller in later iterations, when
// the noise is gone and what is left are shadow edges.
layout(push_constant) uniform Push { int step_px; float ratio_sigma; };

const float KERNEL[3] = float[](3.0 / 8.0, 1.0 / 4.0, 1.0 / 16.0);
const float NORMAL_POWER = 32.0;
// Distance from the tangent plane, in units of the pixel's footprint, and ratio of luminances, at which a weight
// falls to 1/e.
const float PLANE_SIGMA = 4.0;
const float COLOR_SIGMA = 1.5;
// Weight of neighbours on the same surface (all of them weigh 0.86) below which others count too, and the distance,
// in pixels' footprints per step, within which they do.
const float MIN_SUPPORT = 0.15;
const float NEARNESS_SIGMA = 4.0;
// Wider steps would carry light across whole features.
const int LAST_RELAXED_STEP = 2;

struct Estimate {
    vec3 shadowed;
    vec3 unshadowed;
    float weight;
};

float brightness(ivec2 p) {
    vec3 lighting = texelFetch(lighting_image, p, 0).rgb;
    return log2(max(luminance(lighting), 1e-20));
}

float shadow_ratio(vec3 shadowed, vec3 unshadowed) {
    float u = luminance(unshadowed);
    return u > 0.0 ? luminance(shadowed) / u : 1.0;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = ivec2(image_size());
    if (any(greaterThanEqual(pixel, size))) {
        return;
    }
    float depth = texelFetch(depth_image, pixel, 0).x;
    if (depth <= 0.0) {
        imageStore(out_shadowed, pixel, vec4(0.0));
        imageStore(out_unshadowed, pixel, vec4(0.0));
        return;
    }
    vec3 position = position_from_depth(uvec2(pixel), depth);
    vec3 normal = unpack_octahedral(texelFetch(normals_image, pixel, 0).x);
    float center_brightness = brightness(pixel);
    float center_ratio = shadow_ratio(texelFetch(shadowed_image, pixel, 0).rgb, texelFetch(unshadowed_image, pixel, 0).rgb);
    float footprint = 2.0 * length(frame.up_ws) / float(size.y) * frame.near / depth;
    float plane_scale = 1.0 / (PLANE_SIGMA * footprint);
    float nearness = NEARNESS_SIGMA * footprint * float(step_px);
    float nearness_scale = 1.0 / (nearness * nearness);
    Estimate strict = Estimate(vec3(0.0), vec3(0.0), 0.0);
    float alike = 0.0;
    Estimate relaxed = Estimate(vec3(0.0), vec3(0.0), 0.0);
    for (int y = -2; y <= 2; ++y) {
        for (int x = -2; x <= 2; ++x) {
            ivec2 p = pixel + ivec2(x, y) * step_px;
            if (any(lessThan(p, ivec2(0))) || any(greaterThanEqual(p, size))) {
                continue;
            }
            float depth_p = texelFetch(depth_image, p, 0).x;
            if (depth_p <= 0.0) {
                continue;
            }
            vec3 offset = position_from_depth(uvec2(p), depth_p) - position;
            vec3 normal_p = unpack_octahedral(texelFetch(normals_image, p, 0).x);
            float weight = KERNEL[abs(x)] * KERNEL[abs(y)];
            weight *= pow(max(dot(normal, normal_p), 0.0), NORMAL_POWER);
            weight *= exp(-abs(dot(offset, normal)) * plane_scale);
            alike += weight;
            weight *= exp(-abs(brightness(p) - center_brightness) / COLOR_SIGMA);
            vec3 s = texelFetch(shadowed_image, p, 0).rgb;
            vec3 u = texelFetch(unshadowed_image, p, 0).rgb;
            weight *= exp(-abs(shadow_ratio(s, u) - center_ratio) / ratio_sigma);
            strict.shadowed += weight * s;
            strict.unshadowed += weight * u;
            strict.weight += weight;
            float relaxed_weight = KERNEL[abs(x)] * KERNEL[abs(y)] * exp(-dot(offset, offset) * nearness_scale);
            relaxed.shadowed += relaxed_weight * s;
            relaxed.unshadowed += relaxed_weight * u;
            relaxed.weight += relaxed_weight;
        }
    }
    // A pixel whose surface no neighbour shares (thin joints, leaves) would keep the noise of its few samples: the
    // fewer are alike, the more it takes from whatever is near.
    float support = alike - KERNEL[0] * KERNEL[0];
    float lack = step_px <= LAST_RELAXED_STEP ? clamp(1.0 - support / MIN_SUPPORT, 0.0, 1.0) : 0.0;
    float unit = texelFetch(shadowed_image, pixel, 0).a;
    float inverse_weight = 1.0 / (strict.weight + lack * relaxed.weight);
    imageStore(out_shadowed, pixel, vec4((strict.shadowed + lack * relaxed.shadowed) * inverse_weight, unit));
    imageStore(out_unshadowed, pixel, vec4((strict.unshadowed + lack * relaxed.unshadowed) * inverse_weight, unit));
}
