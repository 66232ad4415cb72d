// What one light adds to one vertex: with w the trilinear weight, m the luminance over the largest flux, q the offset from
// the vertex in cells: w, wm, wmq (3), wmq^2 (3), wmn (3), w flux (3).
const uint MOMENTS = 14u;

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
    vec3 flux = flux_kind.rgb / grid.flux_scale;
    vec3 cells = grid_position(uintBitsToFloat(position_normal.xyz), grid, level);
    return ScaledLight(cells, original_lobe(position_normal, flux_kind), flux, luminance(flux));
}

float[MOMENTS] moments_of(ScaledLight light, float weight, vec3 q) {
    // A light never vanishes by rounding: at least one unit of luminance.
    float wm = max(weight * light.luminance, 1.0 / (FIXED_HIGH * FIXED_LOW));
    float wp = UNIFORM_CENTER != 0u ? weight : wm;
    return float[MOMENTS](weight, wm, wp * q.x, wp * q.y, wp * q.z, wp * q.x * q.x, wp * q.y * q.y, wp * q.z * q.z,
                          wm * light.normal.x, wm * light.normal.y, wm * light.normal.z,
                          weight * light.flux.x, weight * light.flux.y, weight * light.flux.z);
}
