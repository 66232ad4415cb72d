// Unit vectors in 32 bits: octahedral mapping, two 16-bit snorm. Rust: scene::octahedral.
// The place of a direction in the square from -1 to 1.
vec2 octahedral_place(vec3 n) {
    n /= abs(n.x) + abs(n.y) + abs(n.z);
    vec2 folded = (1.0 - abs(n.yx)) * vec2(n.x >= 0.0 ? 1.0 : -1.0, n.y >= 0.0 ? 1.0 : -1.0);
    return n.z >= 0.0 ? n.xy : folded;
}

uint pack_octahedral(vec3 n) { return packSnorm2x16(octahedral_place(n)); }

// Precise, as several shaders sum normals of lights and their sums are to be the same to the bit.
vec3 unpack_octahedral(uint packed_normal) {
    vec2 e = unpackSnorm2x16(packed_normal);
    precise vec3 n = vec3(e, 1.0 - abs(e.x) - abs(e.y));
    float t = max(-n.z, 0.0);
    n.x += n.x >= 0.0 ? -t : t;
    n.y += n.y >= 0.0 ? -t : t;
    precise vec3 unit = normalize(n);
    return unit;
}
