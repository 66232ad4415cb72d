// Marks the cells of S1 that hold lights of S0. One thread per light.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/lights.glsl"
#include "common/dispatch.glsl"

layout(local_size_x = WORKGROUP_SIZE) in;
layout(set = 0, binding = 1, std430) readonly buffer LightPositions { uvec4 light_positions[]; };
layout(set = 0, binding = 2, std430) readonly buffer Grid { GridPlacement grid; };
layout(set = 0, binding = 3, std430) buffer CellBits { uint cell_bits[]; };

void main() {
    uint light = linear_thread();
    if (light < grid.light_count) {
        uvec3 cell = cell_of(grid_position(uintBitsToFloat(light_positions[light].xyz), grid, 1u), 1u);
        atomicOr(cell_bits[occupancy_word(cell, 1u)], 1u << (cell.x % 32u));
    }
}
