// One shadow ray per reservoir, from the pixel to a point on the chosen light (section 3.3). Writes the shadowed
// and the unshadowed estimate S and U; their ratio is the shadow (Heitz et al. 2018). One thread per pixel.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/color.glsl"
#include "common/octahedral.glsl"
#include "common/gbuffer.glsl"
#include "common/lights.glsl"
#include "common/original_lights.glsl"
#include "common/scene.glsl"
#include "common/light_rays.glsl"
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = TILE_SIZE, local_size_y = TILE_SIZE) in;
layout(set = 0, binding = 1) uniform texture2D depth_image;
layout(set = 0, binding = 2) uniform utexture2D normals_image;
layout(set = 0, binding = 3) uniform texture2D lighting_image;
layout(set = 0, binding = 4, std430) readonly buffer MergedLights { GridLight merged_lights[]; };
layout(set = 0, binding = 9, std430) readonly buffer GridLights { GridLight grid_lights[]; };
layout(set = 0, binding = 10, std430) readonly buffer LevelTable { uint level_table[]; };
layout(set = 0, binding = 11, std430) readonly buffer Descent { uint descent[]; };
layout(set = 0, binding = 12, std430) readonly buffer Representatives { uint representatives[]; };
layout(set = 0, binding = 13, std430) readonly buffer LightPositions { uvec4 light_positions[]; };
layout(set = 0, binding = 14, std430) readonly buffer LightFluxes { vec4 light_fluxes[]; };
#define RESERVOIR_BINDING 5
#include "shadow_rays/chosen_lights.glsl"
layout(set = 0, binding = 6, rgba16f) uniform writeonly image2D out_shadowed;
layout(set = 0, binding = 7, rgba16f) uniform writeonly image2D out_unshadowed;
layout(set = 0, binding = 8, std430) buffer RayCount { uint ray_count[]; };
// 1: descend from a coarse light to one of the lights S0 it is made of; 0: the chosen light itself.
layout(constant_id = 0) const uint DESCEND = 1u;
layout(push_constant) uniform Push { uint index_bits; };

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

// The S1 light that grid light `index` hands a ray to: at every level a part with a probability proportional to
// its luminance.
uint descend(uint index, uint level, inout uint random_state) {
    for (; level > 1u; --level) {
        uint table = descent_table(index, level_first(2u));
        uint parts = descent[table];
        if (parts == 0u) {
            break;
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

// A light of S0 that the chosen light is made of.
Sender original_sender(GridLight chosen, inout uint random_state) {
    uint light = chosen.vertex;
    if (chosen.level > 0u) {
        uint s1 = descend(chosen.vertex, chosen.level, random_state);
        uint r = min(uint(random(random_state) * float(REPRESENTATIVES)), REPRESENTATIVES - 1u);
        light = representatives[s1 * REPRESENTATIVES + r] & index_mask(index_bits);
    }
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

// Traces the ray of one reservoir. `total` is the sum of f over the number of reservoirs. Returns whether a ray
// was traced.
bool add_sample(Receiver receiver, uint light, float total, inout uint random_state, inout vec3 s, inout vec3 u) {
    GridLight chosen = merged_lights[light];
    Sender sender;
    if (DESCEND != 0u) {
        sender = original_sender(chosen, random_state);
    } else {
        sender = jittered_sender(chosen, random_state);
    }
    vec3 color = sender.flux * (total / max(luminance(sender.flux), 1e-30));
    if (DESCEND != 0u) {
        // The sender counts as what it is, relative to what the chosen light was chosen for.
        vec3 offset = sender.position_ws - receiver.position_ws;
        vec3 chosen_offset = chosen.position_ws - receiver.position_ws;
        float response = light_response(offset, length(offset), receiver.normal, sender.lobe, sender.level);
        float expected = light_response(chosen_offset, length(chosen_offset), receiver.normal, chosen.lobe, chosen.level);
        color *= min(response / max(expected, 1e-30), MAX_RESPONSE_RATIO);
        if (response <= 0.0) {
            return false;
        }
    }
    u += color;
    if (!is_light_blocked(receiver.origin, sender.position_ws, sender.lobe)) {
        s += color;
    }
    return true;
}

shared uint rays_of_group;

void main() {
    if (gl_LocalInvocationIndex == 0u) {
        rays_of_group = 0u;
    }
    barrier();
    uvec2 pixel = gl_GlobalInvocationID.xy;
    bool inside = all(lessThan(pixel, image_size()));
    float depth = inside ? texelFetch(depth_image, ivec2(pixel), 0).x : 0.0;
    uvec2 interleaved = interleaved_from_pixel(pixel);
    float total = inside ? texelFetch(lighting_image, ivec2(interleaved), 0).a : 0.0;
    vec3 shadowed = vec3(0.0);
    vec3 unshadowed = vec3(0.0);
    uint rays = 0u;
    if (depth > 0.0 && total > 0.0) {
        uvec2 normals = texelFetch(normals_image, ivec2(pixel), 0).xy;
        Receiver receiver;
        receiver.position_ws = position_from_depth(pixel, depth);
        receiver.normal = unpack_octahedral(normals.x);
        receiver.origin =
            receiver.position_ws + unpack_octahedral(normals.y) * surface_offset(receiver.position_ws);
        uint index = reservoir_index(interleaved);
        uint random_state = hash(index, sampling_seed() ^ 0x5bd1e995u);
        float share = 1.0 / float(shadow_sample_count());
        for (uint i = 0u; i < shadow_sample_count(); ++i) {
            uint light = selected_light(index, i);
            if (light != NO_LIGHT && add_sample(receiver, light, share, random_state, shadowed, unshadowed)) {
                ++rays;
            }
        }
    }
    if (inside) {
        imageStore(out_shadowed, ivec2(pixel), vec4(shadowed, 1.0));
        imageStore(out_unshadowed, ivec2(pixel), vec4(unshadowed, 1.0));
    }
    atomicAdd(rays_of_group, rays);
    barrier();
    if (gl_LocalInvocationIndex == 0u) {
        atomicAdd(ray_count[1], rays_of_group);
    }
}
