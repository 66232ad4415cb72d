// One level of the irradiance that follows from the children's: the mean of those that lend it by the light that they
// reflect, so that the node reflects as much as they do; the last level has all those of word 0. One thread per word of the level.
#include "common/frame.glsl"
#include "common/octahedral.glsl"
#include "common/dispatch.glsl"
layout(local_size_x = WORKGROUP_SIZE) in;

layout(set = 0, binding = 1) uniform utexture2D point_nodes;
layout(set = 0, binding = 2, std430) readonly buffer PointAlbedos { uint point_albedos[]; };
layout(set = 0, binding = 3, std430) readonly buffer DerivedBits { uint derived_bits[]; };
layout(set = 0, binding = 4, std430) buffer PointIrradiance { float point_irradiance[]; };
layout(set = 0, binding = 5, std430) readonly buffer KnownBits { uint known_bits[]; };
layout(push_constant) uniform Push { uint first_word; uint word_count; };

#include "common/points.glsl"
#include "common/point_albedos.glsl"
#include "common/point_irradiance.glsl"

vec3 mean_of_children(uint key) {
    vec3 reflected = vec3(0.0);
    vec3 albedos = vec3(0.0);
    vec3 received = vec3(0.0);
    float areas = 0.0;
    for (uint child = 0u; child < 2u; ++child) {
        uint side = child_key(key, child);
        if ((known_bits[side >> 5u] >> (side & 31u) & 1u) == 0u) {
            continue;
        }
        uint node = side >> 1u;
        float area = point_node(node).area;
        vec3 albedo = point_albedo(node);
        vec3 irradiance = irradiance_of(side);
        reflected += area * albedo * irradiance;
        albedos += area * albedo;
        received += area * irradiance;
        areas += area;
    }
    // Where nothing is reflected, what is received.
    return mix(received / areas, reflected / max(albedos, vec3(1e-30)), greaterThan(albedos, vec3(1e-30)));
}

void main() {
    uint thread = linear_thread();
    if (thread >= word_count) {
        return;
    }
    uint word = first_word + thread;
    // From the highest key down: in word 0 children come before their parents.
    for (uint left = derived_bits[word]; left != 0u;) {
        uint bit = uint(findMSB(left));
        uint key = 32u * word + bit;
        set_irradiance(key, mean_of_children(key));
        left &= ~(1u << bit);
    }
}
