// Irradiance of lit points with one more bounce: their direct light, and what the surfaces that their micro-buffers see
// reflect of the light that they had a bounce before. A workgroup for each point of a list.
#include "common/frame.glsl"
#include "common/dispatch.glsl"
#include "common/random.glsl"
#include "common/octahedral.glsl"
#include "common/micro_buffer.glsl"
#include "common/point_sum.glsl"
#include "shared/PointCounts.glsl"

layout(local_size_x = POINT_LANES) in;
layout(set = 0, binding = 3, std430) readonly buffer Counts { PointCounts point_counts; };
layout(set = 0, binding = 4, std430) readonly buffer Keys { uint keys[]; };
layout(set = 0, binding = 5, std430) readonly buffer SeenTexels { uint texels[]; };
layout(set = 0, binding = 6, std430) readonly buffer Direct { float direct_irradiance[]; };
// Of the bounce before, of all sides that lend.
layout(set = 0, binding = 7, std430) buffer Before { float point_irradiance[]; };
layout(set = 0, binding = 8, std430) writeonly buffer After { float bounced_irradiance[]; };
layout(set = 0, binding = 9, std430) readonly buffer LendingBits { uint lending_bits[]; };
layout(set = 0, binding = 13, std430) readonly buffer PointAlbedos { uint point_albedos[]; };
#include "common/point_albedos.glsl"
#include "common/point_irradiance.glsl"
// Which list, and texels that each of its points has.
layout(push_constant) uniform Push { uint list; uint texel_count; };

bool lends(uint key) { return (lending_bits[key >> 5u] >> (key & 31u) & 1u) != 0u; }

// Light of a side, or of the nearest one above that has any.
vec3 nearest_irradiance(uint key) {
    while (key > 3u && !lends(key)) {
        key = parent_key(key);
    }
    return lends(key) ? irradiance_of(key) : vec3(0.0);
}

// Share of a lane of what a point gets from surfaces.
vec3 reflected_irradiance(uint slot, uint lane) {
    vec3 sum = vec3(0.0);
    // Micro-buffers beyond the room for them were not kept.
    uint count = (slot + 1u) * texel_count <= uint(texels.length()) ? texel_count : 0u;
    for (uint i = lane; i < count; i += POINT_LANES) {
        MicroTexel texel = micro_table[i];
        if (is_used(texel)) {
            uint seen = texels[slot * texel_count + i];
            uint key = key_of(seen);
            if (key != 0u) {
                sum += coverage_of(seen) * texel.cosine_weight * point_albedo(key >> 1u) * nearest_irradiance(key);
            }
        }
    }
    return sum / PI;
}

void main() {
    uint slot = linear_group();
    uint lane = gl_LocalInvocationID.x;
    if (slot >= (list == POINT_LIST_PRIMARIES ? point_counts.primary_count : point_counts.needed_count)) {
        return;
    }
    uint key = keys[slot];
    vec3 reflected = sum_over_lanes(lane, reflected_irradiance(slot, lane));
    if (lane < 3u) {
        bounced_irradiance[3u * key + lane] = direct_irradiance[3u * key + lane] + reflected[lane];
    }
}
