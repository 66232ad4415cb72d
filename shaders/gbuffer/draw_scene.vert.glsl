// Draws the scene into the G-buffer. One invocation per vertex.
#include "common/frame.glsl"
#include "common/octahedral.glsl"

layout(location = 0) in vec3 position_ws;
layout(location = 1) in uint normal_oct;
layout(location = 2) in vec2 uv;
layout(location = 3) in vec4 color;

layout(location = 0) out vec3 out_from_eye_ws;
layout(location = 1) out vec3 out_normal_ws;
layout(location = 2) out vec2 out_uv;
layout(location = 3) out vec4 out_color;

void main() {
    out_from_eye_ws = position_ws - frame.eye_ws;
    out_normal_ws = unpack_octahedral(normal_oct);
    out_uv = uv;
    out_color = color;
    gl_Position = clip_position(position_ws);
}
