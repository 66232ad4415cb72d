// Counts the lights of S0 in each cell of S1. One thread per light.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/lights.glsl"
#include "common/dispatch.glsl"

layout(local_size_x = WORKGROUP_SIZE) in;
layout(set = 0, binding = 1, std430) readonly buffer LightPositions { uvec4 light_positions[]; };
layout(set = 0, binding = 2, std430) readonly buffer Grid { GridPlacement grid; };
layout(set = 0, binding = 3, std430) readonly buffer CellBits { uint cell_bits[]; };
layout(set = 0, binding = 4, std430) readonly buffer CellRanks { uint cell_ranks[]; };
layout(set = 0, binding = 5, std430) buffer BucketCounts { uint bucket_counts[]; };

#include "common/cells.glsl"

void main() {
    uint light = linear_thread();
    if (light < grid.light_count) {
        uvec3 cell = cell_of(grid_position(uintBitsToFloat(light_positions[light].xyz), grid, 1u), 1u);
        uint bucket = cell_rank(occupancy_word(cell, 1u), (1u << (cell.x % 32u)) - 1u);
        atomicAdd(bucket_counts[bucket], 1u);
    }
}
