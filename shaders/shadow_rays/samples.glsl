// The shadow samples of a pixel: which light each reservoir holds, and the ray towards it. Needs frame.glsl, random.glsl,
// color.glsl, octahedral.glsl, gbuffer.glsl, lights.glsl, original_lights.glsl, scene.glsl and light_rays.glsl.
#extension GL_EXT_samplerless_texture_functions : require

layout(set = 0, binding = 1) uniform texture2D depth_image;
layout(set = 0, binding = 2) uniform utexture2D normals_image;
// Unshadowed lighting in the interleaved layout; in a the sum of f over all lights.
layout(set = 0, binding = 3) uniform texture2D lighting_image;
layout(set = 0, binding = 4, std430) readonly buffer MergedLights { GridLight merged_lights[]; };
layout(set = 0, binding = 10, std430) readonly buffer LevelTable { uint level_table[]; };
layout(set = 0, binding = 11, std430) readonly buffer Descent { uint descent[]; };
layout(set = 0, binding = 12, std430) readonly buffer Representatives { uint representatives[]; };
layout(set = 0, binding = 13, std430) readonly buffer LightPositions { uvec4 light_positions[]; };
layout(set = 0, binding = 14, std430) readonly buffer LightFluxes { vec4 light_fluxes[]; };
#define RESERVOIR_BINDING 5
#include "shadow_rays/chosen_lights.glsl"
// 1: descend from a coarse light to one of the lights S0 it is made of; 0: the chosen light itself.
layout(constant_id = 0) const uint DESCEND = 1u;

#include "common/level_table.glsl"
#include "descent/tables.glsl"
#include "descent/representatives.glsl"

// Bounds what one sample may count for: a finer light can lie much nearer than the light it stands for.
const float MAX_RESPONSE_RATIO = 16.0;

// Where shadow rays start.
struct Receiver {
    vec3 origin;
    vec3 position_ws;
    vec3 normal;
};

Receiver receiver_at(uvec2 pixel, float depth) {
    uvec2 normals = texelFetch(normals_image, ivec2(pixel), 0).xy;
    Receiver receiver;
    receiver.position_ws = position_from_depth(pixel, depth);
    receiver.normal = unpack_octahedral(normals.x);
    receiver.origin = receiver.position_ws + unpack_octahedral(normals.y) * surface_offset(receiver.position_ws);
    return receiver;
}

// The S1 light that grid light `index` hands a ray to: at every level a part with a probability proportional to
// its luminance. NO_LIGHT where there are more lights than tables, whose number was measured under another sun.
uint descend(uint index, uint level, inout uint random_state) {
    for (; level > 1u; --level) {
        uint table = descent_table(index, level_first(2u));
        if (table + DESCENT_STRIDE > uint(descent.length())) {
            return NO_LIGHT;
        }
        uint parts = min(descent[table], DESCENT_PARTS);
        if (parts == 0u) {
            return NO_LIGHT;
        }
        float target = random(random_state) * uintBitsToFloat(descent[table + 2u * parts]);
        uint part = 0u;
        while (part + 1u < parts && uintBitsToFloat(descent[table + 2u + 2u * part]) <= target) {
            ++part;
        }
        index = descent[table + 3u + 2u * part];
    }
    return index;
}

// Where a ray ends: a point that sends light.
struct Sender {
    vec3 position_ws;
    vec3 lobe;
    vec3 flux;
    uint level;
};

// A light of S0 that the chosen light is made of, or NO_LIGHT where the way down to one is lost.
uint original_of(GridLight chosen, inout uint random_state) {
    if (chosen.level == 0u) {
        return chosen.vertex;
    }
    uint s1 = descend(chosen.vertex, chosen.level, random_state);
    if (s1 == NO_LIGHT) {
        return NO_LIGHT;
    }
    uint r = min(uint(random(random_state) * float(REPRESENTATIVES)), REPRESENTATIVES - 1u);
    uint representative = representatives[s1 * REPRESENTATIVES + r];
    return representative == NO_LIGHT ? NO_LIGHT : representative & index_mask(index_bits);
}

Sender original_sender(uint light) {
    uvec4 position_normal = light_positions[light];
    vec4 flux = light_fluxes[light];
    vec3 lobe = original_lobe(position_normal, flux);
    return Sender(uintBitsToFloat(position_normal.xyz), lobe, flux.rgb, 0u);
}

// The chosen light's centre jittered uniformly with its deviation: half-width sqrt(3) sigma per axis.
Sender jittered_sender(GridLight chosen, inout uint random_state) {
    vec3 jitter = vec3(random(random_state), random(random_state), random(random_state)) * 2.0 - 1.0;
    return Sender(chosen.position_ws + jitter * sqrt(3.0 * chosen.variance), chosen.lobe, chosen.flux, chosen.level);
}

// One reservoir's estimate of the unshadowed lighting, and whether something stands before its light. Without light
// towards the receiver there is no ray.
struct ShadowSample {
    Sender sender;
    vec3 estimate;
    bool has_ray;
    bool blocked;
};

// The random numbers of a pixel's samples, which are traced in their order.
uint sampling_state(uint pixel_index) { return hash(pixel_index, sampling_seed() ^ 0x5bd1e995u); }

// Traces the ray of one reservoir. `share` is one over the number of reservoirs.
ShadowSample trace_sample(Receiver receiver, uint light, float share, inout uint random_state) {
    GridLight chosen = merged_lights[light];
    ShadowSample result;
    uint original = DESCEND != 0u ? original_of(chosen, random_state) : NO_LIGHT;
    if (original != NO_LIGHT) {
        result.sender = original_sender(original);
    } else {
        result.sender = jittered_sender(chosen, random_state);
    }
    Sender sender = result.sender;
    result.estimate = sender.flux * (share / max(luminance(sender.flux), 1e-30));
    result.has_ray = true;
    result.blocked = false;
    if (DESCEND != 0u) {
        // The sender counts as what it is, relative to what the chosen light was chosen for.
        vec3 offset = sender.position_ws - receiver.position_ws;
        vec3 chosen_offset = chosen.position_ws - receiver.position_ws;
        float response = light_response(offset, length(offset), receiver.normal, sender.lobe, sender.level);
        float expected = light_response(chosen_offset, length(chosen_offset), receiver.normal, chosen.lobe, chosen.level);
        result.estimate *= min(response / max(expected, 1e-30), MAX_RESPONSE_RATIO);
        result.has_ray = response > 0.0;
    }
    if (result.has_ray) {
        result.blocked = is_light_blocked(receiver.origin, sender.position_ws, sender.lobe);
    }
    return result;
}
