// Final composition in linear radiance: direct light plus, with the hierarchy, albedo times the unshadowed
// lighting times the filtered shadow ratio (Heitz et al. 2018). One thread per pixel.
#include "common/frame.glsl"
#include "common/color.glsl"
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

#include "compose/shadow_ratio.glsl"
#include "compose/shadowed_lighting.glsl"

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
            lighting = shadowed_lighting(p);
        }
        radiance += texelFetch(albedo_image, p, 0).rgb * lighting;
    }
    imageStore(out_radiance, p, vec4(radiance, share));
}
