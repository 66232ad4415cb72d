// Placement of the grid hierarchy: around the lights, or, where they are others in every frame, at an anchor that does not
// follow them. One thread.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/lights.glsl"

layout(local_size_x = 1) in;
layout(set = 0, binding = 1, std430) readonly buffer Bounds { uint bounds[]; };
layout(set = 0, binding = 2, std430) readonly buffer LightCounts { uint light_counts[]; };
layout(set = 0, binding = 3, std430) writeonly buffer Grid { GridPlacement grid; };
// The cube that the anchor is; without an edge the grids stand around the lights.
layout(push_constant) uniform Push { float anchor_edge; float anchor_x_ws; float anchor_y_ws; float anchor_z_ws; };

const uint MOST_DOUBLINGS = 256u;
// How far lights may lie outside, as a part of the edge, to count as on the face.
const float SLACK = 1.0 / 1024.0;

float float_from_ordered(uint ordered) {
    return uintBitsToFloat((ordered & 0x80000000u) != 0u ? ordered & 0x7fffffffu : ~ordered);
}

// Doubles the anchor until the lights are inside, in the directions in which they lie: what were vertices of a level are those of
// the level below.
void grow_anchor(inout vec3 origin, inout float edge, vec3 low, vec3 high) {
    for (uint i = 0u; i < MOST_DOUBLINGS; ++i) {
        float slack = edge * SLACK;
        bvec3 below = lessThan(low, origin - slack);
        if (!any(below) && !any(greaterThan(high, origin + edge + slack))) {
            break;
        }
        origin -= mix(vec3(0.0), vec3(edge), below);
        edge *= 2.0;
    }
}

// The least power of two that is no less than a value in the range of normal floats.
float power_of_two_above(float value) {
    uint bits = floatBitsToUint(value);
    uint exponent = (bits >> 23u) + ((bits & 0x7fffffu) != 0u ? 1u : 0u);
    return uintBitsToFloat(min(exponent, 254u) << 23u);
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
    vec3 origin = low;
    float flux_scale = empty ? 1.0 : max(float_from_ordered(bounds[6]), 1e-30);
    if (anchor_edge > 0.0) {
        origin = vec3(anchor_x_ws, anchor_y_ws, anchor_z_ws);
        edge = anchor_edge;
        if (!empty) {
            grow_anchor(origin, edge, low, high);
        }
        // The unit of flux stays as well while the brightest light changes little.
        flux_scale = power_of_two_above(flux_scale);
    }
    grid.origin_ws = origin;
    grid.h_top = edge;
    grid.inverse_h_top = 1.0 / edge;
    grid.flux_scale = flux_scale;
    grid.light_count = light_counts[0];
    grid.padding = 0u;
}
