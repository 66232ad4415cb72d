// Lights that each pixel tests, from the interleaved layout to the picture's. One thread per pixel.
#include "common/frame.glsl"

layout(local_size_x = TILE_SIZE, local_size_y = TILE_SIZE) in;
layout(set = 0, binding = 1, std430) readonly buffer LightsTested { uint lights_tested[]; };
layout(set = 0, binding = 2, rgba32f) uniform writeonly image2D out_values;

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (all(lessThan(pixel, image_size()))) {
        uint tested = lights_tested[reservoir_index(interleaved_from_pixel(pixel))];
        imageStore(out_values, ivec2(pixel), vec4(float(tested)));
    }
}
