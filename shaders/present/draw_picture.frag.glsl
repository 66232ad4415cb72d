// The finished picture in the window, bilinear between the centres of its pixels where the sizes differ. One thread
// per pixel of the window; reads the picture as sRGB, writes what the window's format wants.
#extension GL_EXT_samplerless_texture_functions : require
#include "common/srgb.glsl"

layout(constant_id = 0) const bool DRIVER_ENCODES = false;
layout(set = 0, binding = 0) uniform texture2D picture;
layout(location = 0) in vec2 position;
layout(location = 0) out vec4 color;

void main() {
    ivec2 last = textureSize(picture, 0) - 1;
    vec2 texel = position * vec2(last + 1) - 0.5;
    vec2 corner = floor(texel);
    vec2 fraction = texel - corner;
    ivec2 low = clamp(ivec2(corner), ivec2(0), last);
    ivec2 high = clamp(ivec2(corner) + 1, ivec2(0), last);
    vec3 top = mix(texelFetch(picture, low, 0).rgb, texelFetch(picture, ivec2(high.x, low.y), 0).rgb, fraction.x);
    vec3 bottom = mix(texelFetch(picture, ivec2(low.x, high.y), 0).rgb, texelFetch(picture, high, 0).rgb, fraction.x);
    vec3 encoded = mix(top, bottom, fraction.y);
    color = vec4(DRIVER_ENCODES ? srgb_decode(encoded) : encoded, 1.0);
}
