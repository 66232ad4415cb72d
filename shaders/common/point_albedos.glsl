// Albedo of nodes. Needs the buffer `point_albedos`. Rust: points::unpack_rgb9e5.
vec3 point_albedo(uint node) {
    uint color = point_albedos[node];
    return vec3(uvec3(color, color >> 9u, color >> 18u) & 0x1ffu) * exp2(float(color >> 27u) - 24.0);
}
