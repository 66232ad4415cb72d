// Lights of S0 from their packed form. Needs octahedral.glsl.

// Mean normal of a light of S0: its surface's, or none where it shines in all directions.
vec3 original_lobe(uvec4 position_normal, vec4 flux) {
    return flux.a > 0.5 ? unpack_octahedral(position_normal.w) : vec3(0.0);
}
