// Direct light of suns, spots and points with one shadow ray each. One thread per pixel.
// Reads the G-buffer and the scene, writes outgoing radiance.
#include "common/frame.glsl"
#include "common/octahedral.glsl"
#include "common/gbuffer.glsl"
#include "common/random.glsl"
#include "common/scene.glsl"

#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = TILE_SIZE, local_size_y = TILE_SIZE) in;
layout(set = 0, binding = 1) uniform texture2D depth_image;
layout(set = 0, binding = 2) uniform texture2D albedo_image;
layout(set = 0, binding = 3) uniform utexture2D normals_image;
layout(set = 0, binding = 4, rgba32f) uniform writeonly image2D out_direct;

// Irradiance without shadow; sets the direction and distance of the shadow ray.
vec3 unshadowed_irradiance(PunctualLight light, vec3 position, vec3 normal, out vec3 to_light, out float distance) {
    if (light.kind == LIGHT_DIRECTIONAL) {
        to_light = -light.direction_ws;
        distance = 4.0 * scene_radius();
        return light.intensity * max(dot(normal, to_light), 0.0);
    }
    vec3 offset = light.position_ws - position;
    distance = length(offset);
    to_light = offset / max(distance, 1e-20);
    float cone = 1.0;
    if (light.kind == LIGHT_SPOT) {
        float along = -dot(to_light, light.direction_ws);
        float edge = clamp((along - light.outer_cos) / max(light.inner_cos - light.outer_cos, 1e-4), 0.0, 1.0);
        cone = edge * edge;
    }
    return light.intensity * cone * max(dot(normal, to_light), 0.0) / max(distance * distance, 1e-12);
}

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
        vec3 origin = position + unpack_octahedral(normals.y) * surface_offset(position);
        vec3 irradiance = vec3(0.0);
        for (uint i = 0u; i < frame.lights.y; ++i) {
            vec3 to_light;
            float distance;
            vec3 e = unshadowed_irradiance(punctual_lights[i], position, shading, to_light, distance);
            if (any(greaterThan(e, vec3(0.0))) && !is_blocked(origin, to_light, distance - ray_offset())) {
                irradiance += e;
            }
        }
        radiance = texelFetch(albedo_image, ivec2(pixel), 0).rgb / PI * irradiance;
    }
    imageStore(out_direct, ivec2(pixel), vec4(radiance, 1.0));
}
