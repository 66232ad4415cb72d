// Blends the unshadowed lighting of this frame into that of the frames before, by the weights of the shadow estimates. One
// thread per pixel.
#include "common/frame.glsl"
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = TILE_SIZE, local_size_y = TILE_SIZE) in;
layout(set = 0, binding = 1) uniform texture2D lighting_image;
// a: what the shadow estimates of this frame are per unit of.
layout(set = 0, binding = 2) uniform texture2D unshadowed_image;
layout(set = 0, binding = 3) uniform texture2D reprojected_lighting;
// a: frames in the history, this one included; one over this one's weight.
layout(set = 0, binding = 4) uniform texture2D history_shadowed;
layout(set = 0, binding = 5, rgba32f) uniform writeonly image2D history_lighting;

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, image_size()))) {
        return;
    }
    ivec2 p = ivec2(pixel);
    vec4 lighting = vec4(texelFetch(lighting_image, p, 0).rgb, texelFetch(unshadowed_image, p, 0).a);
    float frames = texelFetch(history_shadowed, p, 0).a;
    if (frames > 1.0) {
        lighting = mix(texelFetch(reprojected_lighting, p, 0), lighting, 1.0 / frames);
    }
    imageStore(history_lighting, p, lighting);
}
