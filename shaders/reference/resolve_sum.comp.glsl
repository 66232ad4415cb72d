// The sum of a reference technique over the share of its samples that are in it: right even when it was stopped
// early. Alpha keeps the share. One thread per pixel.
#include "common/frame.glsl"
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = TILE_SIZE, local_size_y = TILE_SIZE) in;
layout(set = 0, binding = 1) uniform texture2D sum_image;
layout(set = 0, binding = 2, rgba32f) uniform writeonly image2D out_lighting;

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, image_size()))) {
        return;
    }
    vec4 sum = texelFetch(sum_image, ivec2(pixel), 0);
    imageStore(out_lighting, ivec2(pixel), vec4(sum.a > 0.0 ? sum.rgb / sum.a : vec3(0.0), sum.a));
}
