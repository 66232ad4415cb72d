// Exposure, a tone curve, sRGB, 8 bits. One thread per pixel.
#include "common/frame.glsl"
#include "tone_map/tone_curves.glsl"
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = TILE_SIZE, local_size_y = TILE_SIZE) in;
layout(set = 0, binding = 1) uniform texture2D radiance_image;
layout(set = 0, binding = 2, std430) readonly buffer Exposure { float exposure[]; };
layout(set = 0, binding = 3, rgba8) uniform writeonly image2D out_picture;

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, image_size()))) {
        return;
    }
    vec3 radiance = texelFetch(radiance_image, ivec2(pixel), 0).rgb;
    imageStore(out_picture, ivec2(pixel), vec4(tone_mapped(radiance, exposure[0], frame.tone_map), 1.0));
}
