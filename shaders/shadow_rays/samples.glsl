// The shadow samples of a pixel: which light each reservoir holds, and the ray towards it. Needs frame.glsl, random.glsl,
// color.glsl, octahedral.glsl, gbuffer.glsl, lights.glsl, original_lights.glsl, light_texels.glsl, scene.glsl and light_rays.glsl.
#extension GL_EXT_samplerless_texture_functions : require

layout(set = 0, binding = 1) uniform texture2D depth_image;
layout(set = 0, binding = 2) uniform utexture2D normals_image;
// Unshadowed lighting in the interleaved layout; in a the sum of f over all lights.
layout(set = 0, binding = 3) uniform texture2D lighting_image;
layout(set = 0, binding = 4, std430) readonly buffer MergedLights { GridLight merged_lights[]; };
layout(set = 0, binding = 10, std430) readonly buffer LevelTable { uint level_table[]; };
layout(set = 0, binding = 11, std430) readonly buffer Descent { uint descent[]; };
layout(set = 0, binding = 12, std430) readonly buffer Representatives { uint representatives[]; };
#ifdef ROUND
// In frames without history those of the round.
layout(set = 0, binding = 28, std430) readonly buffer RoundRepresentatives { uint round_representatives[]; };
#endif
layout(set = 0, binding = 13, std430) readonly buffer LightPositions { uvec4 light_positions[]; };
layout(set = 0, binding = 14, std430) readonly buffer LightFluxes { vec4 light_fluxes[]; };
layout(set = 0, binding = 15, std430) readonly buffer Grid { GridPlacement grid; };
layout(set = 0, binding = 16, std430) readonly buffer SubImages { uint sub_images[]; };
layout(set = 0, binding = 24, std430) readonly buffer Occupancy { uint occupancy[]; };
layout(set = 0, binding = 25, std430) readonly buffer Ranks { uint ranks[]; };
layout(set = 0, binding = 26, std430) readonly buffer GridLights { GridLight grid_lights[]; };
layout(set = 0, binding = 27) uniform texture2D light_texels;
#define RESERVOIR_BINDING 5
#include "shadow_rays/chosen_lights.glsl"
// 1: descend from a coarse light to one of the lights S0 it is made of; 0: the chosen light itself.
layout(constant_id = 0) const uint DESCEND = 1u;

#include "common/samples_seed.glsl"
#include "common/level_table.glsl"
#include "common/occupancy.glsl"
#include "merge/sub_images.glsl"
#include "shadow_rays/estimate.glsl"
#include "descent/tables.glsl"
#include "descent/representatives.glsl"
#include "descent/way_down.glsl"

// Where shadow rays start.
struct Receiver {
    vec3 origin;
    vec3 position_ws;
    vec3 normal;
    // Sum of f over the lights that its samples were chosen from.
    float total;
    // That sum, or where samples count for all ways the mean of it over a pattern; and what estimates are per unit of: the
    // same, or 1 where it is nothing.
    float mean_total;
    float unit;
    // Luminance of all lights, where samples may start at any.
    float luminance_of_all;
};

// The chosen light's centre jittered uniformly with its deviation: half-width sqrt(3) sigma per axis.
Sender jittered_sender(GridLight chosen, inout uint random_state) {
    vec3 jitter = vec3(random(random_state), random(random_state), random(random_state)) * 2.0 - 1.0;
    return Sender(chosen.position_ws + jitter * sqrt(3.0 * chosen.variance), chosen.lobe, chosen.flux, chosen.level);
}

// One reservoir's estimate of the unshadowed lighting, per unit of its sum of weights, and whether something stands before
// its light. Without light towards the receiver there is no ray.
struct ShadowSample {
    Sender sender;
    vec3 estimate;
    bool has_ray;
    bool blocked;
};

// The random numbers of a pixel's samples, which are traced in their order.
uint sampling_state(uint pixel_index) { return hash(pixel_index, samples_seed() ^ 0x5bd1e995u); }

#include "shadow_rays/all_ways.glsl"

Receiver receiver_at(uvec2 pixel, float depth) {
    uvec2 normals = texelFetch(normals_image, ivec2(pixel), 0).xy;
    Receiver receiver;
    receiver.total = texelFetch(lighting_image, ivec2(interleaved_from_pixel(pixel)), 0).a;
    receiver.position_ws = position_from_depth(pixel, depth);
    receiver.normal = unpack_octahedral(normals.x);
    bool all_ways = ESTIMATE != ESTIMATE_RATIO;
    receiver.mean_total = all_ways ? mean_total(pixel) : receiver.total;
    receiver.unit = all_ways && receiver.mean_total <= 0.0 ? 1.0 : receiver.mean_total;
    receiver.luminance_of_all = all_ways ? luminance_of_all() : 0.0;
    receiver.origin = receiver.position_ws + unpack_octahedral(normals.y) * surface_offset(receiver.position_ws);
    return receiver;
}

// A sample that counts as what its light sends, relative to what the chosen light was chosen for.
ShadowSample sample_of_chosen(Receiver receiver, GridLight chosen, float share, inout uint random_state) {
    ShadowSample result;
    result.blocked = false;
    uint original = DESCEND != 0u ? original_below(chosen.vertex, chosen.level, random_state) : NO_LIGHT;
    if (original != NO_LIGHT) {
        result.sender = original_sender(original);
    } else {
        result.sender = jittered_sender(chosen, random_state);
    }
    Sender sender = result.sender;
    float taken = receiver.total / receiver.unit;
    result.estimate = sender.flux * (share * taken / max(luminance(sender.flux), 1e-30));
    result.has_ray = true;
    if (DESCEND != 0u) {
        float response = sent_response(sender, receiver.position_ws, receiver.normal);
        result.estimate *= stand_in_ratio(response, expected_response(chosen, receiver.position_ws, receiver.normal));
        result.has_ray = response > 0.0;
    }
    return result;
}

// A sample that counts as what its light sends, over the probability of that light on all ways: the mean over samples is
// what all lights send, whatever the chosen lights stand for.
ShadowSample sample_of_all_ways(Receiver receiver, uint light, float share, inout uint random_state) {
    ShadowSample result = ShadowSample(Sender(receiver.position_ws, vec3(0.0), vec3(0.0), 0u), vec3(0.0), false, false);
    float elsewhere = light == NO_LIGHT ? 1.0 : ELSEWHERE_SHARE;
    GridLight chosen = merged_lights[light == NO_LIGHT ? 0u : light];
    Start start = Start(chosen.vertex, chosen.level);
    bool is_elsewhere = random(random_state) < elsewhere;
    Start other = start_elsewhere(receiver, random_state);
    if (is_elsewhere) {
        start = other;
    }
    if (start.light == NO_LIGHT) {
        return result;
    }
    uint original = original_below(start.light, start.level, random_state);
    if (original == NO_LIGHT) {
        return result;
    }
    result.sender = original_sender(original);
    vec3 offset = result.sender.position_ws - receiver.position_ws;
    float brightness = luminance(result.sender.flux);
    float response = light_response(offset, length(offset), receiver.normal, result.sender.lobe, 0u, brightness);
    if (response > 0.0) {
        float expected = expected_on_all_ways(chosen_for(original, result.sender.position_ws, receiver), receiver);
        float taken = is_elsewhere ? ELSEWHERE_SHARE / elsewhere : receiver.total / receiver.unit;
        float weight = share * taken * response / expected;
        result.estimate = result.sender.flux * (weight / max(brightness, 1e-30));
        result.has_ray = true;
    }
    return result;
}

// Whether every grid light above S1 has a table. Under another sun than the one their number was measured under, some may not.
bool has_all_tables() {
    uint end = level_first(top_level()) + level_count(top_level());
    return descent_table(end, level_first(2u)) <= uint(descent.length());
}

// Traces the ray of one reservoir, whose light may be NO_LIGHT. `share` is one over the number of reservoirs.
ShadowSample trace_sample(Receiver receiver, uint light, float share, inout uint random_state) {
    ShadowSample result = ShadowSample(Sender(receiver.position_ws, vec3(0.0), vec3(0.0), 0u), vec3(0.0), false, false);
    if (ESTIMATE != ESTIMATE_RATIO && has_all_tables()) {
        result = sample_of_all_ways(receiver, light, share, random_state);
    } else if (light != NO_LIGHT) {
        result = sample_of_chosen(receiver, merged_lights[light], share, random_state);
    }
    if (result.has_ray) {
        result.blocked = is_light_blocked(receiver.origin, result.sender.position_ws, result.sender.lobe);
    }
    return result;
}
