// Draws the representatives of every S1 light; those of a further round of samples (ROUND) where there is no history, as then
// all pixels take part and would share what these have in common. One thread per light of S0.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/color.glsl"
#include "common/lights.glsl"
#include "common/dispatch.glsl"
#include "descent/representatives.glsl"

layout(local_size_x = WORKGROUP_SIZE) in;
layout(set = 0, binding = 1, std430) readonly buffer LightPositions { uvec4 light_positions[]; };
layout(set = 0, binding = 2, std430) readonly buffer LightFluxes { vec4 light_fluxes[]; };
layout(set = 0, binding = 3, std430) readonly buffer Grid { GridPlacement grid; };
layout(set = 0, binding = 4, std430) readonly buffer Occupancy { uint occupancy[]; };
layout(set = 0, binding = 5, std430) readonly buffer Ranks { uint ranks[]; };
layout(set = 0, binding = 6, std430) readonly buffer LevelTable { uint level_table[]; };
layout(set = 0, binding = 7, std430) buffer Representatives { uint representatives[]; };
layout(push_constant) uniform Push {
    uint index_bits;
#ifdef ROUND
    uint round_number;
#endif
};

#include "common/samples_seed.glsl"
#include "common/level_table.glsl"
#include "common/occupancy.glsl"
#include "common/vertex_share.glsl"

void main() {
#ifdef ROUND
    if (frame.history_is_valid != 0u) {
        return;
    }
#endif
    uint light = linear_thread();
    if (light >= grid.light_count) {
        return;
    }
    float m = luminance(light_fluxes[light].rgb) / grid.flux_scale;
    vec3 cells = grid_position(uintBitsToFloat(light_positions[light].xyz), grid, 1u);
    uvec3 cell = cell_of(cells, 1u);
    for (uint i = 0u; i < 8u; ++i) {
        uvec3 corner = uvec3(i & 1u, (i >> 1u) & 1u, i >> 2u);
        float share = vertex_share(cells - vec3(cell), corner) * m;
        uint s1 = grid_light_at(cell + corner, 1u);
        if (share <= 0.0 || s1 == NO_LIGHT) {
            continue;
        }
        uint random_state = hash(light, i, samples_seed() ^ 0x27d4eb2fu);
        for (uint r = 0u; r < REPRESENTATIVES; ++r) {
            uint key = packed_race_key(random(random_state), share, index_bits);
            atomicMin(representatives[s1 * REPRESENTATIVES + r], key | light);
        }
    }
}
