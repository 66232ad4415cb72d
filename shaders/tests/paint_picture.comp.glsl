// A picture and its depth from a buffer: radiance in rgb, depth in a. One thread per pixel.
#include "constants.glsl"

layout(local_size_x = TILE_SIZE, local_size_y = TILE_SIZE) in;
layout(set = 0, binding = 0, std430) readonly buffer Pixels { vec4 pixels[]; };
layout(set = 0, binding = 1, rgba32f) uniform writeonly image2D out_radiance;
layout(set = 0, binding = 2, r32f) uniform writeonly image2D out_depth;

void main() {
    uvec2 size = uvec2(imageSize(out_radiance));
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, size))) {
        return;
    }
    vec4 painted = pixels[pixel.y * size.x + pixel.x];
    imageStore(out_radiance, ivec2(pixel), vec4(painted.rgb, 1.0));
    imageStore(out_depth, ivec2(pixel), vec4(painted.a));
}
