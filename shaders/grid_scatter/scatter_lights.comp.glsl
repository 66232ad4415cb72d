// Every light adds its moments to its eight surrounding vertices of one level (section 3.1). One thread per light.
// Moments per vertex, with w the trilinear weight, m the luminance over the largest flux, q the offset from the
// vertex in cells: w, wm, wmq, wmq^2, wmn, w flux; 14 sums.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/color.glsl"
#include "common/octahedral.glsl"
#include "common/lights.glsl"
#include "common/original_lights.glsl"
#include "common/dispatch.glsl"
#include "grid_scatter/fixed_point.glsl"

layout(local_size_x = WORKGROUP_SIZE) in;
layout(set = 0, binding = 1, std430) readonly buffer LightPositions { uvec4 light_positions[]; };
layout(set = 0, binding = 2, std430) readonly buffer LightFluxes { vec4 light_fluxes[]; };
layout(set = 0, binding = 3, std430) readonly buffer Grid { GridPlacement grid; };
layout(set = 0, binding = 4, std430) readonly buffer Occupancy { uint occupancy[]; };
layout(set = 0, binding = 5, std430) readonly buffer Ranks { uint ranks[]; };
layout(set = 0, binding = 6, std430) readonly buffer LevelTable { uint level_table[]; };
layout(set = 0, binding = 7, std430) buffer Moments { uint moments[]; };
layout(push_constant) uniform Push { uint level; };
// 1: lights count the same in positions, with w in place of wm.
layout(constant_id = 0) const uint UNIFORM_CENTER = 0u;

#include "common/level_table.glsl"
#include "common/occupancy.glsl"

void add_moment(uint record, uint moment, float value) {
    uvec2 words = fixed_from_float(value);
    uint index = record * MOMENT_WORDS + 2u * moment;
    uint carry = 0u;
    if (words.x != 0u) {
        uint before = atomicAdd(moments[index], words.x);
        carry = before + words.x < before ? 1u : 0u;
    }
    if (words.y + carry != 0u) {
        atomicAdd(moments[index + 1u], words.y + carry);
    }
}

void add_moments(uint record, float weight, vec3 q, float m, vec3 normal, vec3 flux) {
    // A light never vanishes by rounding: at least one unit of luminance.
    float wm = max(weight * m, 1.0 / (FIXED_HIGH * FIXED_LOW));
    add_moment(record, 0u, weight);
    add_moment(record, 1u, wm);
    float wp = UNIFORM_CENTER != 0u ? weight : wm;
    for (uint axis = 0u; axis < 3u; ++axis) {
        add_moment(record, 2u + axis, wp * q[axis]);
        add_moment(record, 5u + axis, wp * q[axis] * q[axis]);
        add_moment(record, 8u + axis, wm * normal[axis]);
        add_moment(record, 11u + axis, weight * flux[axis]);
    }
}

void main() {
    uint light = linear_thread();
    if (light >= grid.light_count) {
        return;
    }
    uvec4 position_normal = light_positions[light];
    vec4 flux_kind = light_fluxes[light];
    vec3 flux = flux_kind.rgb / grid.flux_scale;
    float m = luminance(flux);
    vec3 normal = original_lobe(position_normal, flux_kind);
    vec3 cells = grid_position(uintBitsToFloat(position_normal.xyz), grid, level);
    uvec3 cell = cell_of(cells, level);
    vec3 fraction = cells - vec3(cell);
    for (uint i = 0u; i < 8u; ++i) {
        uvec3 corner = uvec3(i & 1u, (i >> 1u) & 1u, i >> 2u);
        float weight = trilinear_weight(fraction, corner);
        uint record = grid_light_at(cell + corner, level);
        if (record != NO_LIGHT && weight > 0.0) {
            add_moments(record, weight, fraction - vec3(corner), m, normal, flux);
        }
    }
}
