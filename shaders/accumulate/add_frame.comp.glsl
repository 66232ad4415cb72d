// Adds the frame to the sum of the frames so far and gives their mean. A frame that was stopped early weighs as
// much as the share of its samples. One thread per pixel.
#include "common/frame.glsl"
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = TILE_SIZE, local_size_y = TILE_SIZE) in;
layout(set = 0, binding = 1) uniform texture2D frame_image;
layout(set = 0, binding = 2, rgba32f) uniform image2D sum_image;
layout(set = 0, binding = 3, rgba32f) uniform writeonly image2D out_mean;

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, image_size()))) {
        return;
    }
    vec4 frame_radiance = texelFetch(frame_image, ivec2(pixel), 0);
    vec4 sum = accumulated_frame() == 0u ? vec4(0.0) : imageLoad(sum_image, ivec2(pixel));
    sum += vec4(frame_radiance.rgb * frame_radiance.a, frame_radiance.a);
    imageStore(sum_image, ivec2(pixel), sum);
    imageStore(out_mean, ivec2(pixel), vec4(sum.a > 0.0 ? sum.rgb / sum.a : vec3(0.0), 1.0));
}
