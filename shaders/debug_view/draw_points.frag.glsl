// A light's flux inside its disc, with alpha 1. One invocation per fragment.
#include "common/frame.glsl"

layout(location = 0) in vec2 corner;
layout(location = 1) flat in vec3 flux;
layout(location = 0) out vec4 out_values;

void main() {
    if (dot(corner, corner) > 1.0) {
        discard;
    }
    out_values = vec4(flux, 1.0);
}
