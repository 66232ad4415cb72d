// Lighting of one G-buffer pixel by one light of the hierarchy, shared by the volumes and the top level.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/color.glsl"
#include "common/octahedral.glsl"
#include "common/gbuffer.glsl"
#include "common/lights.glsl"
#extension GL_EXT_samplerless_texture_functions : require

// Only fragments that survive the depth test may touch the reservoirs.
layout(early_fragment_tests) in;

layout(set = 0, binding = 1, std430) readonly buffer MergedLights { GridLight merged_lights[]; };
layout(set = 0, binding = 2, std430) readonly buffer SubImages { uint sub_images[]; };
layout(set = 0, binding = 3, std430) readonly buffer Grid { GridPlacement grid; };
layout(set = 0, binding = 4) uniform texture2D depth_image;
layout(set = 0, binding = 5) uniform utexture2D normals_image;
// lights_tested[pixel]: lights tested, counted in frames for statistics only.
layout(set = 0, binding = 6, std430) buffer LightsTested { uint lights_tested[]; };
#define RESERVOIR_BINDING 7
#include "light_volumes/reservoir.glsl"
#include "light_volumes/response.glsl"

layout(constant_id = 0) const uint COUNT_LIGHTS_TESTED = 0u;

struct Surface {
    vec3 position_ws;
    vec3 normal;
    uint index;
};

// The surface at this fragment of the interleaved layout; false where there is none.
bool surface_at(uvec2 fragment, out Surface surface) {
    uvec2 pixel = pixel_from_interleaved(fragment);
    surface.index = reservoir_index(fragment);
    if (any(greaterThanEqual(pixel, image_size()))) {
        return false;
    }
    float depth = texelFetch(depth_image, ivec2(pixel), 0).x;
    if (depth <= 0.0) {
        return false;
    }
    surface.position_ws = position_from_depth(pixel, depth);
    surface.normal = unpack_octahedral(texelFetch(normals_image, ivec2(pixel), 0).x);
    return true;
}

// Radiance per unit albedo in rgb; in a the weight f when the light may become a shadow sample.
vec4 shade(Surface surface, uint index, float radius, uint level) {
    float response = blended_response(surface.position_ws, surface.normal, index, radius, level);
    if (response <= 0.0) {
        return vec4(0.0);
    }
    vec3 radiance = response * merged_lights[index].flux;
    float f = level >= first_shadow_level() ? luminance(radiance) : 0.0;
#ifndef RESERVOIR_NONE
    if (f > 0.0) {
        update_reservoirs(surface.index, index, f);
    }
#endif
    return vec4(radiance, f);
}

void count_lights_tested(uint pixel_index, uint tested) {
    if (COUNT_LIGHTS_TESTED != 0u) {
        atomicAdd(lights_tested[pixel_index], tested);
    }
}
