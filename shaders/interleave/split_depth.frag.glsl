// Deals the depth buffer to the n x n sub-images, so that light volumes can be tested against it.
#include "common/frame.glsl"
#extension GL_EXT_samplerless_texture_functions : require

layout(set = 0, binding = 1) uniform texture2D depth_image;

void main() {
    uvec2 pixel = pixel_from_interleaved(uvec2(gl_FragCoord.xy));
    bool inside = all(lessThan(pixel, image_size()));
    gl_FragDepth = inside ? texelFetch(depth_image, ivec2(pixel), 0).x : 0.0;
}
