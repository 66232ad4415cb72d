// Every light adds its moments to its eight surrounding vertices of one level (section 3.1), by atomic additions. One
// thread per light.
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

#include "common/level_table.glsl"
#include "common/occupancy.glsl"
#include "grid_scatter/moments.glsl"

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

void main() {
    uint index = linear_thread();
    if (index >= grid.light_count) {
        return;
    }
    ScaledLight light = scaled_light(light_positions[index], light_fluxes[index], level);
    uvec3 cell = cell_of(light.cells, level);
    vec3 fraction = light.cells - vec3(cell);
    for (uint i = 0u; i < 8u; ++i) {
        uvec3 corner = uvec3(i & 1u, (i >> 1u) & 1u, i >> 2u);
        float weight = vertex_share(fraction, corner);
        uint record = grid_light_at(cell + corner, level);
        if (record != NO_LIGHT && weight > 0.0) {
            float[MOMENTS] terms = moments_of(light, weight, fraction - vec3(corner));
            for (uint moment = 0u; moment < MOMENTS; ++moment) {
                add_moment(record, moment, terms[moment]);
            }
        }
    }
}
