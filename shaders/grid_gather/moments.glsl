// Both ways of gathering: their buffers, and the sums of finer grid lights over a vertex of `level`, positions relative to
// the vertex in cells of that level. Moments are additive, so that lights of lights lose nothing. Needs frame.glsl and
// lights.glsl.
layout(set = 0, binding = 1, std430) readonly buffer Grid { GridPlacement grid; };
layout(set = 0, binding = 2, std430) readonly buffer Occupancy { uint occupancy[]; };
layout(set = 0, binding = 3, std430) readonly buffer Ranks { uint ranks[]; };
layout(set = 0, binding = 4, std430) readonly buffer LevelTable { uint level_table[]; };
layout(set = 0, binding = 5, std430) buffer GridLights { GridLight grid_lights[]; };
layout(push_constant) uniform Push { uint level; };

#include "common/level_table.glsl"

// 1: lights count the same in positions, with their weight in place of their luminance.
layout(constant_id = 0) const uint UNIFORM_CENTER = 0u;

struct Moments {
    vec4 flux_weight;
    vec4 position_luminance;
    vec3 square;
    vec3 lobe;
};

Moments no_moments() { return Moments(vec4(0.0), vec4(0.0), vec3(0.0), vec3(0.0)); }

void add_light(inout Moments sums, GridLight light, float weight, vec3 vertex, float h) {
    vec3 q = grid_position(light.position_ws, grid, level) - vertex;
    float wm = weight * light.luminance;
    sums.flux_weight += weight * vec4(light.flux, light.weight);
    float wp = UNIFORM_CENTER != 0u ? weight * light.weight : wm;
    sums.position_luminance += vec4(wp * q, wm);
    sums.square += wp * (light.variance / (h * h) + q * q);
    sums.lobe += wm * light.lobe;
}

void store_light(uint record, Moments sums, vec3 vertex, float h) {
    float wm = max(sums.position_luminance.w, 1e-37);
    float wp = UNIFORM_CENTER != 0u ? max(sums.flux_weight.w, 1e-37) : wm;
    vec3 mean = sums.position_luminance.xyz / wp;
    grid_lights[record].position_ws = grid.origin_ws + (vertex + mean) * h;
    grid_lights[record].luminance = wm;
    grid_lights[record].variance = max(sums.square / wp - mean * mean, vec3(0.0)) * h * h;
    grid_lights[record].lobe = sums.lobe / wm;
    grid_lights[record].weight = sums.flux_weight.w;
    grid_lights[record].flux = sums.flux_weight.rgb;
}
