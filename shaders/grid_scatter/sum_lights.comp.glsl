// The moments of S1 without atomics: every vertex sums the lights of its eight cells, which are listed by cell. The sums
// are integers, so that they equal those of scatter_lights whatever the order. One thread per vertex.
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
layout(set = 0, binding = 4, std430) readonly buffer CellBits { uint cell_bits[]; };
layout(set = 0, binding = 5, std430) readonly buffer CellRanks { uint cell_ranks[]; };
layout(set = 0, binding = 6, std430) readonly buffer LevelTable { uint level_table[]; };
layout(set = 0, binding = 7, std430) writeonly buffer Moments { uint moments[]; };
layout(set = 0, binding = 8, std430) readonly buffer GridLights { GridLight grid_lights[]; };
layout(set = 0, binding = 9, std430) readonly buffer BucketStarts { uint bucket_starts[]; };
layout(set = 0, binding = 10, std430) readonly buffer BucketLights { uint bucket_lights[]; };

#include "common/level_table.glsl"
#include "common/cells.glsl"
#include "grid_scatter/moments.glsl"

// The lights in the two cells to the left and right of a vertex of S1, in the row of cells that begins at its y and z.
uvec2 lights_beside(uvec3 vertex) {
    uvec2 cells = cells_of_row(vertex.yz, max(vertex.x, 1u) - 1u, vertex.x);
    return uvec2(bucket_starts[cells.x], bucket_starts[cells.y]);
}

void add_light(uint index, uvec3 vertex, inout uvec2 sums[MOMENTS]) {
    ScaledLight light = scaled_light(light_positions[index], light_fluxes[index], 1u);
    uvec3 cell = cell_of(light.cells, 1u);
    uvec3 corner = vertex - cell;
    vec3 fraction = light.cells - vec3(cell);
    float weight = vertex_share(fraction, corner);
    if (weight > 0.0) {
        float[MOMENTS] terms = moments_of(light, weight, fraction - vec3(corner));
        for (uint moment = 0u; moment < MOMENTS; ++moment) {
            sums[moment] = fixed_sum(sums[moment], fixed_from_float(terms[moment]));
        }
    }
}

void main() {
    uint index = linear_thread();
    if (index >= level_count(1u)) {
        return;
    }
    uint record = level_first(1u) + index;
    uvec3 vertex = vertex_from_index(grid_lights[record].vertex, 1u);
    uvec2 sums[MOMENTS];
    for (uint moment = 0u; moment < MOMENTS; ++moment) {
        sums[moment] = uvec2(0u);
    }
    for (uint row = 0u; row < 4u; ++row) {
        uvec3 below = uvec3(0u, row & 1u, row >> 1u);
        if (all(greaterThanEqual(vertex, below))) {
            uvec2 range = lights_beside(vertex - below);
            for (uint i = range.x; i < range.y; ++i) {
                add_light(bucket_lights[i], vertex, sums);
            }
        }
    }
    for (uint moment = 0u; moment < MOMENTS; ++moment) {
        moments[record * MOMENT_WORDS + 2u * moment] = sums[moment].x;
        moments[record * MOMENT_WORDS + 2u * moment + 1u] = sums[moment].y;
    }
}
