// Direct light of suns, spots and points with one shadow ray each, of the environment and of surfaces that shine as it has been
// sampled, what surfaces send out by themselves, and the environment where no surface hides it. One thread per pixel. Reads the
// G-buffer and the scene, writes outgoing radiance.
#include "common/frame.glsl"
#include "common/octahedral.glsl"
#include "common/gbuffer.glsl"
#include "common/random.glsl"
#include "common/scene.glsl"
#include "common/punctual.glsl"
#include "common/environment.glsl"

#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = TILE_SIZE, local_size_y = TILE_SIZE) in;
layout(set = 0, binding = 1) uniform texture2D depth_image;
layout(set = 0, binding = 2) uniform texture2D albedo_image;
layout(set = 0, binding = 3) uniform utexture2D normals_image;
// Radiance per unit albedo.
layout(set = 0, binding = 4) uniform texture2D environment_lighting;
layout(set = 0, binding = 5, rgba32f) uniform writeonly image2D out_direct;
// Radiance per unit albedo.
layout(set = 0, binding = 6) uniform texture2D emitter_lighting;
// Radiance of the surface itself.
layout(set = 0, binding = 7) uniform texture2D emission_image;
layout(constant_id = 0) const uint HAS_ENVIRONMENT_LIGHT = 0u;
layout(constant_id = 1) const uint HAS_EMITTER_LIGHT = 0u;
layout(constant_id = 2) const uint HAS_EMISSION = 0u;

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, image_size()))) {
        return;
    }
    float depth = texelFetch(depth_image, ivec2(pixel), 0).x;
    vec3 radiance = vec3(0.0);
    if (depth > 0.0) {
        vec3 position = position_from_depth(pixel, depth);
        uvec2 normals = texelFetch(normals_image, ivec2(pixel), 0).xy;
        vec3 shading = unpack_octahedral(normals.x);
        vec3 geometric = unpack_octahedral(normals.y);
        vec3 origin = position + geometric * surface_offset(position);
        vec3 irradiance = vec3(0.0);
        for (uint i = 0u; i < frame.direct_lights; ++i) {
            irradiance += irradiance_from(punctual_lights[i], position, shading, geometric, origin);
        }
        vec3 albedo = texelFetch(albedo_image, ivec2(pixel), 0).rgb;
        radiance = albedo / PI * irradiance;
        if (HAS_ENVIRONMENT_LIGHT != 0u) {
            radiance += albedo * texelFetch(environment_lighting, ivec2(pixel), 0).rgb;
        }
        if (HAS_EMITTER_LIGHT != 0u) {
            radiance += albedo * texelFetch(emitter_lighting, ivec2(pixel), 0).rgb;
        }
        if (HAS_EMISSION != 0u) {
            radiance += texelFetch(emission_image, ivec2(pixel), 0).rgb;
        }
    } else if (has_environment()) {
        radiance = environment_radiance(normalize(view_ray(pixel)));
    }
    imageStore(out_direct, ivec2(pixel), vec4(radiance, 1.0));
}
