// Final composition in linear radiance: direct light plus, with the hierarchy, albedo times the unshadowed
// lighting times the filtered shadow ratio (Heitz et al. 2018). One thread per pixel.
#include "common/frame.glsl"
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = TILE_SIZE, local_size_y = TILE_SIZE) in;
// Whether there is direct and indirect light, and whether the latter has shadows.
layout(constant_id = 0) const uint HAS_INDIRECT = 1u;
layout(constant_id = 1) const uint HAS_SHADOWS = 1u;
layout(constant_id = 2) const uint HAS_DIRECT = 1u;
// Whether the indirect image's alpha is the share of its samples that were taken; the radiance's alpha keeps it.
layout(constant_id = 3) const uint HAS_SHARE = 0u;

layout(set = 0, binding = 1) uniform texture2D direct_image;
layout(set = 0, binding = 2) uniform texture2D albedo_image;
layout(set = 0, binding = 3) uniform texture2D indirect_image;
layout(set = 0, binding = 4) uniform texture2D shadowed_image;
layout(set = 0, binding = 5) uniform texture2D unshadowed_image;
layout(set = 0, binding = 6, rgba32f) uniform writeonly image2D out_radiance;

// S/U per channel; 0/0 is 1: where no sample carries light there is nothing to darken.
vec3 ratio(vec3 shadowed, vec3 unshadowed) {
    return mix(vec3(1.0), shadowed / max(unshadowed, vec3(1e-30)), greaterThan(unshadowed, vec3(0.0)));
}

// Half the window that stands in for a pixel none of whose samples carry light. Without a filter there are such
// pixels: the few lights that they chose do not reach them.
const int NEIGHBOURS = 2;

vec3 shadow_ratio(ivec2 p) {
    vec3 s = texelFetch(shadowed_image, p, 0).rgb;
    vec3 u = texelFetch(unshadowed_image, p, 0).rgb;
    if (u == vec3(0.0)) {
        for (int y = -NEIGHBOURS; y <= NEIGHBOURS; ++y) {
            for (int x = -NEIGHBOURS; x <= NEIGHBOURS; ++x) {
                ivec2 q = clamp(p + ivec2(x, y), ivec2(0), ivec2(image_size()) - 1);
                s += texelFetch(shadowed_image, q, 0).rgb;
                u += texelFetch(unshadowed_image, q, 0).rgb;
            }
        }
    }
    return ratio(s, u);
}

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, image_size()))) {
        return;
    }
    ivec2 p = ivec2(pixel);
    vec3 radiance = HAS_DIRECT != 0u ? texelFetch(direct_image, p, 0).rgb : vec3(0.0);
    float share = 1.0;
    if (HAS_INDIRECT != 0u) {
        vec4 indirect = texelFetch(indirect_image, p, 0);
        vec3 lighting = indirect.rgb;
        share = HAS_SHARE != 0u ? indirect.a : 1.0;
        if (HAS_SHADOWS != 0u) {
            lighting *= shadow_ratio(p);
        }
        radiance += texelFetch(albedo_image, p, 0).rgb * lighting;
    }
    imageStore(out_radiance, p, vec4(radiance, share));
}
