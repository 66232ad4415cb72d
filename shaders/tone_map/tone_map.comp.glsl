// Exposure, Reinhard per channel, sRGB, 8 bits. One thread per pixel.
#include "common/frame.glsl"
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = TILE_SIZE, local_size_y = TILE_SIZE) in;
layout(set = 0, binding = 1) uniform texture2D radiance_image;
layout(set = 0, binding = 2, std430) readonly buffer Exposure { float exposure[]; };
layout(set = 0, binding = 3, rgba8) uniform writeonly image2D out_picture;

vec3 srgb_encode(vec3 linear) {
    vec3 low = 12.92 * linear;
    vec3 high = 1.055 * pow(max(linear, vec3(1e-12)), vec3(1.0 / 2.4)) - 0.055;
    return mix(high, low, lessThanEqual(linear, vec3(0.0031308)));
}

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, image_size()))) {
        return;
    }
    vec3 exposed = max(texelFetch(radiance_image, ivec2(pixel), 0).rgb * exposure[0], vec3(0.0));
    imageStore(out_picture, ivec2(pixel), vec4(srgb_encode(exposed / (1.0 + exposed)), 1.0));
}
