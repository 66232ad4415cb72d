// One more path per pixel: cosine-distributed diffuse bounces from the G-buffer's surface on, at every vertex the
// light of one sun, spot or point with a shadow ray. Unbiased, nothing clamped. Adds to the sum of radiance per unit
// albedo; its alpha is the share of the paths that are in it. One thread per pixel of one part.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/octahedral.glsl"
#include "common/gbuffer.glsl"
#include "common/scene.glsl"
#include "common/punctual.glsl"
#include "common/reference_tiles.glsl"
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = TILE_SIZE, local_size_y = TILE_SIZE) in;
layout(set = 0, binding = 1) uniform texture2D depth_image;
layout(set = 0, binding = 2) uniform utexture2D normals_image;
layout(set = 0, binding = 3, rgba32f) uniform image2D sum_image;
layout(push_constant) uniform Push { uint rounds; uint round; uint part; };

// Irradiance from one light, picked by its share of the power.
vec3 sampled_irradiance(HitSurface surface, vec3 origin, inout uint random_state) {
    PunctualLight light = punctual_lights[light_at_share(random(random_state))];
    return irradiance_from(light, surface.position_ws, surface.normal, surface.geometric, origin) / max(light.path_probability, 1e-20);
}

// Radiance that arrives by one path of up to `bounces` diffuse surfaces, per unit albedo of the first.
vec3 trace_path(vec3 origin, vec3 geometric, vec3 direction, inout uint random_state) {
    vec3 throughput = vec3(1.0);
    vec3 lighting = vec3(0.0);
    for (uint bounce = 0u; bounce < frame.bounces; ++bounce) {
        Hit hit;
        if (dot(direction, geometric) <= 0.0 || !traverse(origin, direction, 3e38, false, hit)) {
            break;
        }
        HitSurface surface = surface_at_hit(hit, direction);
        throughput *= surface.albedo;
        if (!any(greaterThan(throughput, vec3(0.0)))) {
            break;
        }
        origin = surface.position_ws + surface.geometric * ray_offset(surface.position_ws);
        geometric = surface.geometric;
        lighting += throughput / PI * sampled_irradiance(surface, origin, random_state);
        direction = cosine_direction(surface.normal, vec2(random(random_state), random(random_state)));
    }
    return lighting;
}

void main() {
    uvec2 pixel;
    if (!reference_pixel(part, pixel)) {
        return;
    }
    vec4 sum = round == 0u ? vec4(0.0) : imageLoad(sum_image, ivec2(pixel));
    float depth = texelFetch(depth_image, ivec2(pixel), 0).x;
    if (depth > 0.0 && punctual_lights.length() > 0) {
        uvec2 normals = texelFetch(normals_image, ivec2(pixel), 0).xy;
        vec3 normal = unpack_octahedral(normals.x);
        vec3 geometric = unpack_octahedral(normals.y);
        vec3 position = position_from_depth(pixel, depth);
        vec3 origin = position + geometric * surface_offset(position);
        uint index = pixel.y * image_size().x + pixel.x;
        uint random_state = hash(index, round, frame_seed() ^ 0x165667b1u);
        // The paths of a pixel share its hemisphere evenly.
        vec3 direction = cosine_direction(normal, r2_sequence(round, hash(index, frame_seed())));
        sum.rgb += trace_path(origin, geometric, direction, random_state) / float(rounds);
    }
    sum.a += 1.0 / float(rounds);
    imageStore(sum_image, ivec2(pixel), sum);
}
