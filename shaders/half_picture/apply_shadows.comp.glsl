// Indirect light with its shadows, per unit albedo, of the half picture. One thread per pixel of it.
#include "common/frame.glsl"
#include "common/color.glsl"
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = TILE_SIZE, local_size_y = TILE_SIZE) in;
layout(set = 0, binding = 1) uniform texture2D indirect_image;
layout(set = 0, binding = 2) uniform texture2D shadowed_image;
layout(set = 0, binding = 3) uniform texture2D unshadowed_image;
layout(set = 0, binding = 4, rgba32f) uniform writeonly image2D out_indirect;

#include "compose/shadow_ratio.glsl"
#include "compose/shadowed_lighting.glsl"

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (all(lessThan(pixel, image_size()))) {
        imageStore(out_indirect, ivec2(pixel), vec4(shadowed_lighting(ivec2(pixel)), 1.0));
    }
}
