// Draws the scene into the G-buffer; with FINDS_MOTION it also tells where each vertex was in the frame before. One
// invocation per vertex.
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
#ifdef FINDS_MOTION
layout(location = 4) out vec3 out_previous_from_eye_ws;
#endif
#ifdef VERTICES_MOVE
// Those of the frame before, laid out like the scene's. Rust: scene::Vertex.
layout(set = 0, binding = 1, std430) readonly buffer PreviousVertices { float previous_vertices[]; };
#endif

#ifdef FINDS_MOTION
vec3 previous_position_ws() {
#ifdef VERTICES_MOVE
    if (frame.vertices_moved != 0u) {
        uint first = VERTEX_WORDS * uint(gl_VertexIndex);
        return vec3(previous_vertices[first], previous_vertices[first + 1u], previous_vertices[first + 2u]);
    }
#endif
    return position_ws;
}
#endif

void main() {
    out_from_eye_ws = position_ws - frame.eye_ws;
    out_normal_ws = unpack_octahedral(normal_oct);
    out_uv = uv;
    out_color = color;
#ifdef FINDS_MOTION
    out_previous_from_eye_ws = previous_position_ws() - frame.previous_eye_ws;
#endif
    gl_Position = clip_position(position_ws);
}
