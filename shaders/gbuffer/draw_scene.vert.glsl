// Draws the scene into the G-buffer: with the tangents that normal maps need, with FINDS_MOTION also with where each vertex
// was in the frame before. One invocation per vertex.
#include "common/frame.glsl"
#include "common/octahedral.glsl"

// Only materials without normal maps, vertex colours and cut-outs are drawn.
layout(constant_id = 1) const uint IS_PLAIN = 0u;

layout(location = 0) in vec3 position_ws;
layout(location = 1) in uint normal_oct;
layout(location = 2) in vec2 uv;
layout(location = 3) in vec4 color;

layout(location = 0) out vec3 out_from_eye_ws;
layout(location = 1) out vec3 out_normal_ws;
layout(location = 2) out vec2 out_uv;
layout(location = 3) out vec4 out_color;
// Unit length at the vertex. w: the side of the bitangent, 1 or -1. All 0 where there is no normal map.
layout(location = 4) out vec4 out_tangent_ws;
#ifdef FINDS_MOTION
layout(location = 5) out vec3 out_previous_from_eye_ws;
#endif
// One word each up to the last vertex that has a tangent.
layout(set = 0, binding = 2, std430) readonly buffer SceneTangents { uint scene_tangents[]; };
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

// Octahedral: x in 15 bits, then the sign of the side, then y in 16 bits. Rust: scene::octahedral.
vec4 unpack_tangent(uint word) {
    if (word == 0x80000000u) {
        return vec4(0.0);
    }
    vec2 e = vec2(float(int(word << 17) >> 17) / 16383.0, float(int(word) >> 16) / 32767.0);
    vec3 direction = vec3(e, 1.0 - abs(e.x) - abs(e.y));
    float fold = max(-direction.z, 0.0);
    direction.xy -= vec2(e.x >= 0.0 ? fold : -fold, e.y >= 0.0 ? fold : -fold);
    return vec4(normalize(direction), (word & 0x8000u) != 0u ? -1.0 : 1.0);
}

vec4 tangent_ws() {
    uint vertex = uint(gl_VertexIndex);
    return vertex < uint(scene_tangents.length()) ? unpack_tangent(scene_tangents[vertex]) : vec4(0.0);
}

void main() {
    out_from_eye_ws = position_ws - frame.eye_ws;
    out_normal_ws = unpack_octahedral(normal_oct);
    out_uv = uv;
    if (IS_PLAIN == 0u) {
        out_color = color;
        out_tangent_ws = tangent_ws();
    }
#ifdef FINDS_MOTION
    out_previous_from_eye_ws = previous_position_ws() - frame.previous_eye_ws;
#endif
    gl_Position = clip_position(position_ws);
}
