// One triangle over the whole window. Row 0 of the picture is at the top, where clip space has y = -1.
layout(location = 0) out vec2 position;

void main() {
    position = vec2((gl_VertexIndex << 1) & 2, gl_VertexIndex & 2);
    gl_Position = vec4(2.0 * position - 1.0, 0.0, 1.0);
}
