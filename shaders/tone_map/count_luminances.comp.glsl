// Histogram of the picture's luminances for the automatic exposure: equal steps of log2, surfaces first, then what is
// behind them. Black counts nowhere. Each workgroup counts the samples of its threads in shared memory and adds them
// to the histogram; integers, so that the order does not matter.
#include "common/frame.glsl"
#include "common/color.glsl"
#include "tone_map/exposure_bins.glsl"
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = WORKGROUP_SIZE) in;
// Of every square of so many pixels one is looked at.
layout(constant_id = 0) const uint STEP_PX = 1u;
layout(set = 0, binding = 1) uniform texture2D radiance_image;
layout(set = 0, binding = 2) uniform texture2D depth_image;
layout(set = 0, binding = 3, std430) buffer Histogram { uint histogram[]; };

shared uint counts[2u * EXPOSURE_BINS];

void count(ivec2 pixel) {
    float value = luminance(texelFetch(radiance_image, pixel, 0).rgb);
    // Neither what is black nor what is no number.
    if (value > exp2(LOWEST_STOP)) {
        uint background = texelFetch(depth_image, pixel, 0).x > 0.0 ? 0u : EXPOSURE_BINS;
        atomicAdd(counts[background + bin_of(value)], 1u);
    }
}

void main() {
    uint lane = gl_LocalInvocationID.x;
    for (uint i = lane; i < 2u * EXPOSURE_BINS; i += WORKGROUP_SIZE) {
        counts[i] = 0u;
    }
    barrier();
    uvec2 samples = (image_size() + STEP_PX - 1u) / STEP_PX;
    uint threads = gl_NumWorkGroups.x * WORKGROUP_SIZE;
    for (uint i = gl_GlobalInvocationID.x; i < samples.x * samples.y; i += threads) {
        uvec2 pixel = uvec2(i % samples.x, i / samples.x) * STEP_PX + STEP_PX / 2u;
        count(ivec2(min(pixel, image_size() - 1u)));
    }
    barrier();
    for (uint i = lane; i < 2u * EXPOSURE_BINS; i += WORKGROUP_SIZE) {
        if (counts[i] > 0u) {
            atomicAdd(histogram[i], counts[i]);
        }
    }
}
