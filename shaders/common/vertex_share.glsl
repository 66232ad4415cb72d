// What a light shares with a vertex of its cell: one function for marking vertices and for summing at them, so that a vertex holds the
// same whether or not another light marked it. Precise, as these are shaders of their own.

// Corners with no more than this weight are left out: they would hold nothing but rounding.
const float MIN_WEIGHT = 1e-6;

// Trilinear weight of corner (0 or 1 per axis) for a position `fraction` inside its cell, or 0 where that is left out.
float vertex_share(vec3 fraction, uvec3 corner) {
    precise vec3 w = mix(1.0 - fraction, fraction, equal(corner, uvec3(1u)));
    precise float weight = w.x * w.y * w.z;
    return weight > MIN_WEIGHT ? weight : 0.0;
}
