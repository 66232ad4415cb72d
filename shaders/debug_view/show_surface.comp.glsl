// Views that are one texel of one or two images: values in rgb, and in a the number that a colour map shows, -1 where
// there is no surface. One thread per pixel.
#include "common/frame.glsl"
#include "common/color.glsl"
#include "common/octahedral.glsl"
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = TILE_SIZE, local_size_y = TILE_SIZE) in;
// Rust: passes::debug_view::SurfaceView.
const uint ALBEDO = 0u;
const uint NORMAL = 1u;
const uint DEPTH = 2u;
const uint INDIRECT = 3u;
const uint SHADOW_RATIO = 4u;
const uint ENVIRONMENT_VISIBILITY = 5u;
const uint MOTION = 6u;
layout(constant_id = 0) const uint SHOWN = ALBEDO;

layout(set = 0, binding = 1) uniform texture2D depth_image;
layout(set = 0, binding = 2) uniform texture2D albedo_image;
layout(set = 0, binding = 3) uniform utexture2D normals_image;
// INDIRECT: lighting per unit albedo. MOTION: that. SHADOW_RATIO: the lighting, S and U. ENVIRONMENT_VISIBILITY: S and U.
layout(set = 0, binding = 4) uniform texture2D indirect_image;
layout(set = 0, binding = 5) uniform texture2D shadowed_image;
layout(set = 0, binding = 6) uniform texture2D unshadowed_image;
layout(set = 0, binding = 7, rgba32f) uniform writeonly image2D out_values;
#include "compose/shadow_ratio.glsl"

// S / U, then U and S, as luminances; without a value where nothing would come even without shadow.
vec4 environment_visibility(ivec2 p) {
    float shadowed = luminance(texelFetch(shadowed_image, p, 0).rgb);
    float unshadowed = luminance(texelFetch(unshadowed_image, p, 0).rgb);
    float visible = shadowed / max(unshadowed, 1e-30);
    return unshadowed > 0.0 ? vec4(visible, unshadowed, shadowed, visible) : vec4(0.0, 0.0, 0.0, -1.0);
}

vec4 shown(ivec2 p, float depth) {
    switch (SHOWN) {
    case NORMAL:
        return vec4(unpack_octahedral(texelFetch(normals_image, p, 0).x), 0.0);
    case DEPTH:
        return vec4(frame.near / depth);
    case MOTION:
        vec3 motion = texelFetch(indirect_image, p, 0).xyz;
        return vec4(motion, length(motion.xy));
    case INDIRECT:
        return vec4(texelFetch(albedo_image, p, 0).rgb * texelFetch(indirect_image, p, 0).rgb, 0.0);
    case SHADOW_RATIO:
        return shadow_ratio(p);
    case ENVIRONMENT_VISIBILITY:
        return environment_visibility(p);
    default:
        return vec4(texelFetch(albedo_image, p, 0).rgb, 0.0);
    }
}

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, image_size()))) {
        return;
    }
    ivec2 p = ivec2(pixel);
    float depth = texelFetch(depth_image, p, 0).x;
    vec3 nothing = vec3(SHOWN == SHADOW_RATIO ? 1.0 : 0.0);
    imageStore(out_values, p, depth > 0.0 ? shown(p, depth) : vec4(nothing, -1.0));
}
