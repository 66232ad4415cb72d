// Bounding box and largest flux component of all lights. One thread per light, strided; a shared-memory
// reduction, then one atomic maximum per value and workgroup. Floats are mapped to integers of the same order;
// minima are stored as maxima of the negated value, so that zero-filled memory is the neutral element.
#include "common/frame.glsl"

layout(local_size_x = WORKGROUP_SIZE) in;
layout(set = 0, binding = 1, std430) readonly buffer LightPositions { uvec4 light_positions[]; };
layout(set = 0, binding = 2, std430) readonly buffer LightFluxes { vec4 light_fluxes[]; };
layout(set = 0, binding = 3, std430) readonly buffer LightCounts { uint light_counts[]; };
// [0..2] maxima, [3..5] maxima of the negated coordinates, [6] largest flux component.
layout(set = 0, binding = 4, std430) buffer Bounds { uint bounds[]; };

shared uint scratch[WORKGROUP_SIZE];

uint ordered_from_float(float value) {
    uint bits = floatBitsToUint(value);
    return (bits & 0x80000000u) != 0u ? ~bits : bits | 0x80000000u;
}

void reduce(uint lane, uint target, uint value) {
    scratch[lane] = value;
    barrier();
    for (uint stride = WORKGROUP_SIZE / 2u; stride > 0u; stride /= 2u) {
        if (lane < stride) {
            scratch[lane] = max(scratch[lane], scratch[lane + stride]);
        }
        barrier();
    }
    if (lane == 0u) {
        atomicMax(bounds[target], scratch[0]);
    }
    barrier();
}

void main() {
    uint lane = gl_LocalInvocationID.x;
    uvec3 highest = uvec3(0u);
    uvec3 lowest = uvec3(0u);
    uint flux = 0u;
    uint stride = gl_NumWorkGroups.x * WORKGROUP_SIZE;
    for (uint i = gl_GlobalInvocationID.x; i < light_counts[0]; i += stride) {
        vec3 p = uintBitsToFloat(light_positions[i].xyz);
        vec3 f = light_fluxes[i].rgb;
        highest = max(highest, uvec3(ordered_from_float(p.x), ordered_from_float(p.y), ordered_from_float(p.z)));
        lowest = max(lowest, uvec3(ordered_from_float(-p.x), ordered_from_float(-p.y), ordered_from_float(-p.z)));
        flux = max(flux, ordered_from_float(max(f.r, max(f.g, f.b))));
    }
    for (uint axis = 0u; axis < 3u; ++axis) {
        reduce(lane, axis, highest[axis]);
        reduce(lane, axis + 3u, lowest[axis]);
    }
    reduce(lane, 6u, flux);
}
