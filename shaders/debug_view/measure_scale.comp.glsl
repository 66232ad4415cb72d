// The largest number to show, in a of the values: the upper end of a colour map, in scale[0]. One workgroup.
#include "common/frame.glsl"
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = WORKGROUP_SIZE) in;
layout(set = 0, binding = 1) uniform texture2D values_image;
layout(set = 0, binding = 2, std430) writeonly buffer Scale { float scale[]; };

shared float largest[WORKGROUP_SIZE];

void main() {
    uint lane = gl_LocalInvocationID.x;
    float most = 0.0;
    for (uint y = 0u; y < image_size().y; ++y) {
        for (uint x = lane; x < image_size().x; x += WORKGROUP_SIZE) {
            most = max(most, texelFetch(values_image, ivec2(x, y), 0).a);
        }
    }
    largest[lane] = most;
    barrier();
    for (uint stride = WORKGROUP_SIZE / 2u; stride > 0u; stride /= 2u) {
        if (lane < stride) {
            largest[lane] = max(largest[lane], largest[lane + stride]);
        }
        barrier();
    }
    if (lane == 0u) {
        scale[0] = largest[0];
    }
}
