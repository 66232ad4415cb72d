// Turns the moments of one level into grid lights: illumination centre, variance, mean normal, flux. One thread
// per grid light.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/lights.glsl"
#include "common/dispatch.glsl"
#include "grid_scatter/fixed_point.glsl"

layout(local_size_x = WORKGROUP_SIZE) in;
layout(set = 0, binding = 1, std430) readonly buffer Moments { uint moments[]; };
layout(set = 0, binding = 2, std430) readonly buffer Grid { GridPlacement grid; };
layout(set = 0, binding = 3, std430) readonly buffer LevelTable { uint level_table[]; };
layout(set = 0, binding = 4, std430) buffer GridLights { GridLight grid_lights[]; };
layout(push_constant) uniform Push { uint level; };
// 1: lights counted the same in positions.
layout(constant_id = 0) const uint UNIFORM_CENTER = 0u;

#include "common/level_table.glsl"

float moment(uint record, uint index) {
    uint word = record * MOMENT_WORDS + 2u * index;
    return float_from_fixed(uvec2(moments[word], moments[word + 1u]));
}

vec3 moment3(uint record, uint index) {
    return vec3(moment(record, index), moment(record, index + 1u), moment(record, index + 2u));
}

void main() {
    uint index = linear_thread();
    if (index >= level_count(level)) {
        return;
    }
    uint record = level_first(level) + index;
    float wm = moment(record, 1u);
    float wp = UNIFORM_CENTER != 0u ? moment(record, 0u) : wm;
    vec3 mean = moment3(record, 2u) / wp;
    vec3 variance = max(moment3(record, 5u) / wp - mean * mean, vec3(0.0));
    float h = cell_size(grid.h_top, level);
    vec3 vertex = vec3(vertex_from_index(grid_lights[record].vertex, level));
    grid_lights[record].position_ws = grid.origin_ws + (vertex + mean) * h;
    grid_lights[record].luminance = wm * grid.flux_scale;
    grid_lights[record].variance = variance * h * h;
    grid_lights[record].lobe = moment3(record, 8u) / wm;
    grid_lights[record].weight = moment(record, 0u);
    grid_lights[record].flux = moment3(record, 11u) * grid.flux_scale;
}
