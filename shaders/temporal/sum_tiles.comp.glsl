// The shadowed light of each tile of pixels, and what the frames before have of the same surfaces. One workgroup per tile.
#include "common/frame.glsl"
#include "common/color.glsl"
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = TILE_SIZE, local_size_y = TILE_SIZE) in;
// Whether histories are of light itself rather than per unit of the frame's own unshadowed light.
layout(constant_id = 0) const uint KEEPS_LIGHT = 0u;
// Whether the estimates are light by themselves: their unit is then what arrives without shadow, which the frames before know
// better than this one.
layout(constant_id = 1) const uint IS_RADIANCE = 0u;
layout(set = 0, binding = 1) uniform texture2D shadowed_image;
layout(set = 0, binding = 2) uniform texture2D unshadowed_image;
layout(set = 0, binding = 3) uniform texture2D reprojected_shadowed;
// Over the pixels that have a history. r: light of the frame. g: light of the history. b: what it is per unit of. a: that
// over the number of frames in the history.
layout(set = 0, binding = 4, rgba32f) uniform writeonly image2D out_sums;
layout(set = 0, binding = 5) uniform texture2D reprojected_unshadowed;

const uint PIXELS = TILE_SIZE * TILE_SIZE;

shared vec4 sums[PIXELS];

vec4 light_at(ivec2 p) {
    vec4 before = texelFetch(reprojected_shadowed, p, 0);
    if (before.a <= 0.0) {
        return vec4(0.0);
    }
    if (IS_RADIANCE != 0u) {
        float unit = luminance(texelFetch(reprojected_unshadowed, p, 0).rgb);
        return vec4(luminance(texelFetch(shadowed_image, p, 0).rgb), luminance(before.rgb), unit, unit / before.a);
    }
    float unit = texelFetch(unshadowed_image, p, 0).a;
    float now = luminance(texelFetch(shadowed_image, p, 0).rgb) * unit;
    return vec4(now, luminance(before.rgb) * (KEEPS_LIGHT != 0u ? 1.0 : unit), unit, unit / before.a);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    uint lane = gl_LocalInvocationIndex;
    sums[lane] = all(lessThan(pixel, ivec2(image_size()))) ? light_at(pixel) : vec4(0.0);
    // In pairs, so that the order is always the same.
    for (uint count = PIXELS / 2u; count > 0u; count /= 2u) {
        barrier();
        if (lane < count) {
            sums[lane] += sums[lane + count];
        }
    }
    if (lane == 0u) {
        imageStore(out_sums, ivec2(gl_WorkGroupID.xy), sums[0]);
    }
}
