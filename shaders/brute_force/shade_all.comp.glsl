// Some more lights of S0 at every pixel, each with a shadow ray or all without: what the hierarchy approximates.
// Adds to the sum of radiance per unit albedo; its alpha is the share of the lights that are in it. One thread per
// pixel of one part.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/color.glsl"
#include "common/octahedral.glsl"
#include "common/gbuffer.glsl"
#include "common/lights.glsl"
#include "common/original_lights.glsl"
#include "common/scene.glsl"
#include "common/light_rays.glsl"
#include "common/reference_tiles.glsl"
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = TILE_SIZE, local_size_y = TILE_SIZE) in;
layout(set = 0, binding = 1) uniform texture2D depth_image;
layout(set = 0, binding = 2) uniform utexture2D normals_image;
layout(set = 0, binding = 3, rgba32f) uniform image2D sum_image;
layout(set = 0, binding = 4, std430) readonly buffer LightPositions { uvec4 light_positions[]; };
layout(set = 0, binding = 5, std430) readonly buffer LightFluxes { vec4 light_fluxes[]; };
layout(set = 0, binding = 6, std430) readonly buffer LightCounts { uint light_counts[]; };
layout(constant_id = 0) const uint HAS_SHADOWS = 1u;
layout(push_constant) uniform Push { uint lights_per_round; uint round; uint part; };

// Radiance per unit albedo from one light.
vec3 shade(uint light, vec3 position, vec3 normal, vec3 origin) {
    uvec4 position_normal = light_positions[light];
    vec4 flux = light_fluxes[light];
    vec3 light_position = uintBitsToFloat(position_normal.xyz);
    vec3 lobe = original_lobe(position_normal, flux);
    vec3 offset = light_position - position;
    float response = light_response(offset, length(offset), normal, lobe, 0u, luminance(flux.rgb));
    if (response <= 0.0) {
        return vec3(0.0);
    }
    bool blocked = HAS_SHADOWS != 0u && is_light_blocked(origin, light_position, lobe);
    return blocked ? vec3(0.0) : response * flux.rgb;
}

void main() {
    uvec2 pixel;
    uint count = light_counts[0];
    uint first = round * lights_per_round;
    if (!reference_pixel(part, pixel) || (round > 0u && first >= count)) {
        return;
    }
    uint end = min(first + lights_per_round, count);
    vec4 sum = round == 0u ? vec4(0.0) : imageLoad(sum_image, ivec2(pixel));
    float depth = texelFetch(depth_image, ivec2(pixel), 0).x;
    if (depth > 0.0) {
        uvec2 normals = texelFetch(normals_image, ivec2(pixel), 0).xy;
        vec3 position = position_from_depth(pixel, depth);
        vec3 origin = position + unpack_octahedral(normals.y) * surface_offset(position);
        for (uint light = first; light < end; ++light) {
            sum.rgb += shade(light, position, unpack_octahedral(normals.x), origin);
        }
    }
    sum.a = count == 0u ? 1.0 : float(end) / float(count);
    imageStore(sum_image, ivec2(pixel), sum);
}
