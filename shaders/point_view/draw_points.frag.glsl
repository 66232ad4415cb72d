// What a point tells, inside its disc: the number that is shown, and its key. One invocation per fragment.
#include "constants.glsl"

layout(location = 0) in vec2 corner;
layout(location = 1) flat in uint number_and_key;
layout(location = 0) out vec4 out_values;

void main() {
    if (dot(corner, corner) > 1.0) {
        discard;
    }
    float number = float(number_and_key >> 24u);
    out_values = vec4(number, float(number_and_key & 0xffffffu), 1.0, number);
}
