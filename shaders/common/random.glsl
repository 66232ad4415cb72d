// Random numbers by hashing: no state, the same on every device. PCG hash (Jarzynski and Olano 2020).
uint hash(uint value) {
    uint state = value * 747796405u + 2891336453u;
    uint word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

uint hash(uint a, uint b) { return hash(a ^ hash(b)); }
uint hash(uint a, uint b, uint c) { return hash(a ^ hash(b ^ hash(c))); }

// Strictly between 0 and 1: 23 bits, so that the half is kept and 1 is never reached.
float unit_float(uint bits) { return (float(bits >> 9u) + 0.5) * (1.0 / 8388608.0); }

// -ln(u) of a number strictly between 0 and 1. Never negative, nor -0, where a device's logarithm near 1 is a little above 0:
// such numbers sort as their bits do.
float negative_log(float u) { return abs(log(u)); }

// Key of a light of weight f > 0 in the race for shadow sample `i` of a pixel, whose `stream` is hashed from light and
// pixel: the smallest key falls on a light with probability f / sum of f (exponential race).
float race_key(uint stream, uint i, float f) { return negative_log(unit_float(hash(stream + i * 0x9e3779b9u))) / f; }

// The n-th number of a stream.
float random(inout uint state) {
    state = hash(state);
    return unit_float(state);
}

// Point n of the R2 sequence (Roberts 2018) shifted by a seed, in fixed point so that it never degrades.
vec2 r2_sequence(uint index, uint seed) {
    uvec2 fixed_point = uvec2(3242174889u, 2447445414u) * index + uvec2(hash(seed), hash(seed ^ 0x68bc21ebu));
    return vec2(unit_float(fixed_point.x), unit_float(fixed_point.y));
}

// Point n of the R3 sequence, likewise.
vec3 r3_sequence(uint index, uint seed) {
    uvec3 shift = uvec3(hash(seed), hash(seed ^ 0x68bc21ebu), hash(seed ^ 0x02e5be93u));
    uvec3 fixed_point = uvec3(3518319155u, 2882110345u, 2360945575u) * index + shift;
    return vec3(unit_float(fixed_point.x), unit_float(fixed_point.y), unit_float(fixed_point.z));
}

const float PI = 3.14159265358979;

// Two unit vectors that with `n` form an orthonormal frame (Duff et al. 2017).
void tangent_frame(vec3 n, out vec3 t, out vec3 b) {
    float s = n.z >= 0.0 ? 1.0 : -1.0;
    float a = -1.0 / (s + n.z);
    float c = n.x * n.y * a;
    t = vec3(1.0 + s * n.x * n.x * a, s * c, -s * n.x);
    b = vec3(c, s + n.y * n.y * a, -n.y);
}

// Cosine-distributed direction about `n`.
vec3 cosine_direction(vec3 n, vec2 u) {
    float radius = sqrt(u.x);
    float angle = 2.0 * PI * u.y;
    vec3 t, b;
    tangent_frame(n, t, b);
    return normalize(radius * cos(angle) * t + radius * sin(angle) * b + sqrt(max(1.0 - u.x, 0.0)) * n);
}

// Uniform direction on the sphere.
vec3 sphere_direction(vec2 u) {
    float z = 1.0 - 2.0 * u.x;
    float radius = sqrt(max(1.0 - z * z, 0.0));
    float angle = 2.0 * PI * u.y;
    return vec3(radius * cos(angle), radius * sin(angle), z);
}
