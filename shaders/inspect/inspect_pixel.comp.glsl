// Everything about the pixel that the frame's constants name: its surface and light; with INSPECT_LIGHTS also what the
// lights of each level send to it, and its shadow samples, traced once more. One workgroup.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/color.glsl"
#include "common/octahedral.glsl"
#include "common/gbuffer.glsl"
#include "shadow_rays/estimate.glsl"
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = WORKGROUP_SIZE) in;

#include "shared/InspectedLevel.glsl"

#include "shared/InspectedSample.glsl"

#include "shared/InspectedTexel.glsl"

#include "shared/InspectedPixel.glsl"

layout(push_constant) uniform Push { uint index_bits; uint flags; };
#ifdef INSPECT_LIGHTS
#include "common/lights.glsl"
#include "common/original_lights.glsl"
#include "common/light_texels.glsl"
#include "common/scene.glsl"
#include "common/light_rays.glsl"
#include "shadow_rays/samples.glsl"
#else
layout(set = 0, binding = 1) uniform texture2D depth_image;
layout(set = 0, binding = 2) uniform utexture2D normals_image;
#endif
layout(set = 0, binding = 17) uniform texture2D albedo_image;
layout(set = 0, binding = 18) uniform texture2D radiance_image;
layout(set = 0, binding = 19) uniform texture2D direct_image;
// Lighting per unit albedo, and the filtered shadow estimates.
layout(set = 0, binding = 20) uniform texture2D indirect_image;
layout(set = 0, binding = 21) uniform texture2D shadowed_image;
layout(set = 0, binding = 22) uniform texture2D unshadowed_image;
#include "compose/shadow_ratio.glsl"
#include "compose/shadowed_lighting.glsl"
// Light of the environment per unit albedo.
layout(set = 0, binding = 28) uniform texture2D environment_image;
layout(set = 0, binding = 23, std430) writeonly buffer Inspected { InspectedPixel inspected; };

// Bits of `flags`: which images there are.
const uint HAS_DIRECT = 1u;
const uint HAS_INDIRECT = 2u;
const uint HAS_SHADOWS = 4u;
const uint HAS_ENVIRONMENT = 8u;

vec4 if_there(uint flag, vec4 value) { return (flags & flag) != 0u ? value : vec4(0.0); }

// Everything that is one texel of an image.
void look_at_surface(uvec2 pixel, float depth) {
    ivec2 p = ivec2(pixel);
    uvec2 normals = texelFetch(normals_image, p, 0).xy;
    inspected.position_ws = position_from_depth(pixel, depth);
    inspected.depth = frame.near / depth;
    inspected.normal = unpack_octahedral(normals.x);
    inspected.geometric_normal = unpack_octahedral(normals.y);
    vec3 albedo = texelFetch(albedo_image, p, 0).rgb;
    inspected.albedo = albedo;
    inspected.direct = if_there(HAS_DIRECT, texelFetch(direct_image, p, 0));
    vec4 of_environment = if_there(HAS_ENVIRONMENT, texelFetch(environment_image, p, 0));
    inspected.environment = vec4(albedo * of_environment.rgb, 0.0);
    vec4 lighting = if_there(HAS_INDIRECT, texelFetch(indirect_image, p, 0));
    inspected.lighting = lighting;
    vec3 darkened = (flags & HAS_SHADOWS) != 0u ? shadowed_lighting(p) : lighting.rgb;
    vec3 ratio = darkened / max(lighting.rgb, vec3(1e-30));
    inspected.shadow_ratio = vec4(mix(ratio, vec3(1.0), equal(lighting.rgb, vec3(0.0))), 1.0);
}

#ifdef INSPECT_LIGHTS
shared InspectedLevel of_threads[WORKGROUP_SIZE];

void add_light(inout InspectedLevel sum, uint light, vec3 position_ws, vec3 normal, float radius, uint level) {
    vec3 offset = merged_lights[light].position_ws - position_ws;
    float distance = length(offset);
    float weight = blend_weight(distance, radius, level, first_level(), top_level());
    float response = weight * light_response(offset, distance, normal, merged_lights[light].lobe, level, own_luminance(merged_lights[light]));
    if (response <= 0.0) {
        return;
    }
    float lighting = response * luminance(merged_lights[light].flux);
    sum.count += 1u;
    sum.blended += weight < 1.0 ? 1u : 0u;
    sum.weight += weight;
    sum.lighting += lighting;
    if (lighting > sum.strongest_lighting) {
        sum.strongest = light;
        sum.strongest_lighting = lighting;
        sum.strongest_distance = distance;
        sum.strongest_weight = weight;
    }
}

// The lights of one level of the pixel's sub-image. All threads call it.
void look_at_level(uint sub_image, vec3 position_ws, vec3 normal, uint level) {
    uint lane = gl_LocalInvocationIndex;
    InspectedLevel sum = InspectedLevel(0u, 0u, 0.0, 0.0, NO_LIGHT, 0.0, 0.0, 0.0);
    float radius = alpha() * cell_size(grid.h_top, level);
    uint end = sub_images[SUB_IMAGE_STRIDE * sub_image + level + 1u];
    for (uint light = sub_images[SUB_IMAGE_STRIDE * sub_image + level] + lane; light < end; light += WORKGROUP_SIZE) {
        add_light(sum, light, position_ws, normal, radius, level);
    }
    of_threads[lane] = sum;
    barrier();
    if (lane == 0u) {
        for (uint i = 1u; i < WORKGROUP_SIZE; ++i) {
            InspectedLevel other = of_threads[i];
            if (other.strongest_lighting > sum.strongest_lighting) {
                sum.strongest = other.strongest;
                sum.strongest_lighting = other.strongest_lighting;
                sum.strongest_distance = other.strongest_distance;
                sum.strongest_weight = other.strongest_weight;
            }
            sum.count += other.count;
            sum.blended += other.blended;
            sum.weight += other.weight;
            sum.lighting += other.lighting;
        }
        inspected.levels[level] = sum;
    }
    barrier();
}

// The pixel's shadow samples, with the random numbers that they had in shadow_rays.
void look_at_samples(uvec2 pixel, float depth) {
    uvec2 interleaved = interleaved_from_pixel(pixel);
    Receiver receiver = receiver_at(pixel, depth);
    inspected.total = receiver.total;
    uint index = reservoir_index(interleaved);
    uint random_state = sampling_state(index);
    float share = 1.0 / float(shadow_sample_count());
    float unit = written_unit(receiver);
    for (uint i = 0u; i < shadow_sample_count(); ++i) {
        uint light = receiver.total > 0.0 ? selected_light(index, i) : NO_LIGHT;
        InspectedSample found = InspectedSample(vec3(0.0), light, 0.0, 0u, SAMPLE_EMPTY, 0.0);
        ShadowSample result = trace_sample(receiver, light, share, random_state);
        if (light != NO_LIGHT) {
            found.position_ws = result.sender.position_ws;
            found.estimate = result.has_ray ? luminance(result.estimate) * receiver.unit / max(unit, 1e-30) : 0.0;
            found.level = merged_lights[light].level;
            found.state = !result.has_ray ? SAMPLE_UNLIT : result.blocked ? SAMPLE_BLOCKED : SAMPLE_VISIBLE;
            found.distance = distance(receiver.position_ws, result.sender.position_ws);
        }
        inspected.samples[i] = found;
    }
}
#endif

void main() {
    uvec2 pixel = min(frame.inspected_pixel, image_size() - 1u);
    float depth = texelFetch(depth_image, ivec2(pixel), 0).x;
    bool found = depth > 0.0;
    uint sample_count = 0u;
    uint level_count = 0u;
#ifdef INSPECT_LIGHTS
    sample_count = shadow_sample_count();
    level_count = top_level() + 1u;
#endif
    if (gl_LocalInvocationIndex == 0u) {
        inspected.pixel = pixel;
        inspected.found = found ? 1u : 0u;
        inspected.sample_count = sample_count;
        inspected.level_count = level_count;
        inspected.radiance = texelFetch(radiance_image, ivec2(pixel), 0);
        for (uint level = 0u; level <= MAX_LEVEL; ++level) {
            inspected.levels[level] = InspectedLevel(0u, 0u, 0.0, 0.0, NO_LIGHT, 0.0, 0.0, 0.0);
        }
        if (found) {
            look_at_surface(pixel, depth);
        }
    }
#ifdef INSPECT_LIGHTS
    if (found) {
        vec3 position_ws = position_from_depth(pixel, depth);
        vec3 normal = unpack_octahedral(texelFetch(normals_image, ivec2(pixel), 0).x);
        uint sub_image = pixel.x % interleave() + pixel.y % interleave() * interleave();
        for (uint level = first_level(); level <= top_level(); ++level) {
            look_at_level(sub_image, position_ws, normal, level);
        }
        if (gl_LocalInvocationIndex == 0u) {
            look_at_samples(pixel, depth);
        }
    }
#endif
}
