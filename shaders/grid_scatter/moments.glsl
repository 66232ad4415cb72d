// What one light adds to one vertex: with w the trilinear weight, m the luminance over the largest flux, q the offset from
// the vertex in cells: w, wm, wmq (3), wmq^2 (3), wmn (3), w flux (3).
const uint MOMENTS = 14u;

#include "common/vertex_share.glsl"

// 1: lights count the same in positions, with w in place of wm.
layout(constant_id = 0) const uint UNIFORM_CENTER = 0u;

// A light in units of the grid.
struct ScaledLight {
    vec3 cells;
    vec3 normal;
    vec3 flux;
    float luminance;
};

ScaledLight scaled_light(uvec4 position_normal, vec4 flux_kind, uint level) {
    precise vec3 flux = flux_kind.rgb / grid.flux_scale;
    vec3 cells = grid_position(uintBitsToFloat(position_normal.xyz), grid, level);
    return ScaledLight(cells, original_lobe(position_normal, flux_kind), flux, luminance(flux));
}

// Precise, as several shaders compute these terms and their sums are to be the same to the bit.
float[MOMENTS] moments_of(ScaledLight light, float weight, vec3 q) {
    // A light never vanishes by rounding: at least one unit of luminance.
    precise float wm = max(weight * light.luminance, 1.0 / (FIXED_HIGH * FIXED_LOW));
    float wp = UNIFORM_CENTER != 0u ? weight : wm;
    precise vec3 first = wp * q;
    precise vec3 second = first * q;
    precise vec3 lobe = wm * light.normal;
    precise vec3 flux = weight * light.flux;
    return float[MOMENTS](weight, wm, first.x, first.y, first.z, second.x, second.y, second.z,
                          lobe.x, lobe.y, lobe.z, flux.x, flux.y, flux.z);
}
