// Placement of the grid hierarchy from the lights' bounds. One thread.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/lights.glsl"

layout(local_size_x = 1) in;
layout(set = 0, binding = 1, std430) readonly buffer Bounds { uint bounds[]; };
layout(set = 0, binding = 2, std430) readonly buffer LightCounts { uint light_counts[]; };
layout(set = 0, binding = 3, std430) writeonly buffer Grid { GridPlacement grid; };

float float_from_ordered(uint ordered) {
    return uintBitsToFloat((ordered & 0x80000000u) != 0u ? ordered & 0x7fffffffu : ~ordered);
}

void main() {
    bool empty = light_counts[0] == 0u;
    vec3 high = empty ? vec3(0.0)
        : vec3(float_from_ordered(bounds[0]), float_from_ordered(bounds[1]), float_from_ordered(bounds[2]));
    vec3 low = empty ? vec3(0.0)
        : -vec3(float_from_ordered(bounds[3]), float_from_ordered(bounds[4]), float_from_ordered(bounds[5]));
    vec3 extent = high - low;
    float edge = max(extent.x, max(extent.y, extent.z)) * 1.0001;
    // All lights at one point: any cell does, as long as it is not lost against the coordinates.
    edge = max(edge, 1e-4 * scene_radius());
    grid.origin_ws = low;
    grid.h_top = edge;
    grid.inverse_h_top = 1.0 / edge;
    grid.flux_scale = empty ? 1.0 : max(float_from_ordered(bounds[6]), 1e-30);
    grid.light_count = light_counts[0];
    grid.padding = 0u;
}
