// Automatic exposure: 0.18 over the log-average of the non-black pixels, from a fixed grid of samples. One
// workgroup; the result goes to exposure[0].
#include "common/frame.glsl"
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = WORKGROUP_SIZE) in;
layout(set = 0, binding = 1) uniform texture2D radiance_image;
layout(set = 0, binding = 2, std430) writeonly buffer Exposure { float exposure[]; };

const uvec2 SAMPLES = uvec2(256u, 144u);
shared float log_sums[WORKGROUP_SIZE];
shared float counts[WORKGROUP_SIZE];

void main() {
    uint lane = gl_LocalInvocationID.x;
    float log_sum = 0.0;
    float count = 0.0;
    for (uint i = lane; i < SAMPLES.x * SAMPLES.y; i += WORKGROUP_SIZE) {
        uvec2 cell = uvec2(i % SAMPLES.x, i / SAMPLES.x);
        ivec2 p = ivec2((vec2(cell) + 0.5) / vec2(SAMPLES) * vec2(image_size()));
        vec3 radiance = texelFetch(radiance_image, p, 0).rgb;
        float mean = (radiance.r + radiance.g + radiance.b) / 3.0;
        if (mean > 0.0) {
            log_sum += log(mean);
            count += 1.0;
        }
    }
    log_sums[lane] = log_sum;
    counts[lane] = count;
    barrier();
    for (uint stride = WORKGROUP_SIZE / 2u; stride > 0u; stride /= 2u) {
        if (lane < stride) {
            log_sums[lane] += log_sums[lane + stride];
            counts[lane] += counts[lane + stride];
        }
        barrier();
    }
    if (lane == 0u) {
        float automatic = counts[0] > 0.0 ? 0.18 / exp(log_sums[0] / counts[0]) : 1.0;
        exposure[0] = frame.exposure > 0.0 ? frame.exposure : automatic;
    }
}
