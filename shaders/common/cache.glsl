// Caches of light at primary points. Rust: micro_buffers::lobes.
#include "shared/CachePlace.glsl"

// Numbers of a lobe: irradiance from the environment, then from surfaces.
const uint CACHE_CHANNELS = 6u;

// How much further than by their node caches reach, in radii of leaves.
const float CACHE_REACH_LEAVES = 2.0;

// Axis of a lobe in the frame of the cache; some point below the horizon.
vec3 lobe_direction(uint lobe) {
    vec2 at = (vec2(lobe % LOBE_EDGE, lobe / LOBE_EDGE) + 0.5) * (2.0 / float(LOBE_EDGE)) - 1.0;
    float s = dot(at, at);
    return vec3(2.0 * at, 1.0 - s) / (1.0 + s);
}

// Where among the lobes a normal lies, 0 at the middle of the first.
vec2 lobe_place(vec3 normal) {
    vec2 at = normal.xy / max(1.0 + normal.z, 1e-6);
    return clamp((at + 1.0) * (0.5 * float(LOBE_EDGE)) - 0.5, 0.0, float(LOBE_EDGE) - 1.0);
}
