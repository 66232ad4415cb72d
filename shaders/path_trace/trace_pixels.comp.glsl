// One more path per pixel: cosine-distributed diffuse bounces from the G-buffer's surface on, at every vertex the
// light of one sun, spot or point, or of one point on the surfaces that shine, with a shadow ray; these surfaces do not shine
// where paths meet them. The environment's light comes both by a direction drawn for it and by
// the paths that leave the scene, weighted against each other (Veach and Guibas 1995). Unbiased, nothing clamped. Adds to
// the sum of radiance per unit albedo; its alpha is the share of the paths that are in it. One thread per pixel of one
// part.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/octahedral.glsl"
#include "common/gbuffer.glsl"
#include "common/scene.glsl"
#include "common/punctual.glsl"
#include "common/environment.glsl"
#include "common/emitters.glsl"
#include "common/reference_tiles.glsl"
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = TILE_SIZE, local_size_y = TILE_SIZE) in;
layout(set = 0, binding = 1) uniform texture2D depth_image;
layout(set = 0, binding = 2) uniform utexture2D normals_image;
layout(set = 0, binding = 3, rgba32f) uniform image2D sum_image;
layout(push_constant) uniform Push {
    uint rounds;
    // Whether the light that the environment and surfaces that shine send to the G-buffer's surface itself is part of it.
    uint with_direct;
    uint round;
    uint part;
};

// Irradiance from one light, picked by its share of the power.
vec3 sampled_irradiance(HitSurface surface, vec3 origin, inout uint random_state) {
    PunctualLight light = punctual_lights[light_at_share(random(random_state))];
    vec3 irradiance;
    if (light.kind == LIGHT_EMITTERS) {
        vec2 u = vec2(random(random_state), random(random_state));
        irradiance = emitter_irradiance(surface.position_ws, surface.normal, surface.geometric, origin, u);
    } else {
        irradiance = irradiance_from(light, surface.position_ws, surface.normal, surface.geometric, origin);
    }
    return irradiance / max(light.path_probability, 1e-20);
}

// Where a path is.
struct Vertex {
    vec3 origin;
    vec3 geometric;
    vec3 normal;
};

// Irradiance from the environment by the direction that two numbers stand for; its weight is its share of the density with
// which this direction is drawn at all.
vec3 environment_irradiance(Vertex vertex, vec2 u) {
    EnvironmentSample drawn = sample_environment(u);
    float cosine = dot(vertex.normal, drawn.direction);
    if (cosine <= 0.0 || dot(vertex.geometric, drawn.direction) <= 0.0 || !is_open(vertex.origin, drawn.direction)) {
        return vec3(0.0);
    }
    return environment_radiance(drawn.direction) * (cosine / (drawn.density + cosine / PI));
}

// Radiance from the environment along a path that leaves the scene, weighted likewise.
vec3 escaped_radiance(vec3 normal, vec3 direction) {
    float density = max(dot(normal, direction), 0.0) / PI;
    return environment_radiance(direction) * (density / max(density + environment_density(direction), 1e-20));
}

// Radiance that arrives by one path of up to `bounces` diffuse surfaces, per unit albedo of the first. The direction of its
// first ray and the numbers for the environment's light at its first vertex are given.
vec3 trace_path(Vertex vertex, vec3 direction, vec2 environment_u, inout uint random_state, inout uint environment_state) {
    vec3 throughput = vec3(1.0);
    vec3 lighting = vec3(0.0);
    for (uint bounce = 0u; bounce <= frame.bounces; ++bounce) {
        bool under_environment = has_environment() && (bounce > 0u || with_direct != 0u);
        if (under_environment) {
            lighting += throughput / PI * environment_irradiance(vertex, environment_u);
            environment_u = vec2(random(environment_state), random(environment_state));
        }
        // The last ray only looks for the environment.
        bool is_last = bounce == frame.bounces;
        if (dot(direction, vertex.geometric) <= 0.0 || (is_last && !under_environment)) {
            break;
        }
        Hit hit;
        if (!traverse(vertex.origin, direction, 3e38, is_last, hit)) {
            if (under_environment) {
                lighting += throughput * escaped_radiance(vertex.normal, direction);
            }
            break;
        }
        if (is_last) {
            break;
        }
        HitSurface surface = surface_at_hit(hit, direction);
        throughput *= surface.albedo;
        if (!any(greaterThan(throughput, vec3(0.0)))) {
            break;
        }
        vec3 origin = surface.position_ws + surface.geometric * ray_offset(surface.position_ws);
        vertex = Vertex(origin, surface.geometric, surface.normal);
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
        uint environment_state = hash(index, round, frame_seed() ^ 0x2c1b3c6du);
        // The paths of a pixel share its hemisphere evenly, and so do their first directions towards the environment.
        vec3 direction = cosine_direction(normal, r2_sequence(round, hash(index, frame_seed())));
        vec2 environment_u = r2_sequence(round, hash(index, frame_seed() ^ 0x297a2d39u));
        Vertex vertex = Vertex(origin, geometric, normal);
        sum.rgb += trace_path(vertex, direction, environment_u, random_state, environment_state) / float(rounds);
        if (with_direct != 0u && has_emitters()) {
            vec2 u = r2_sequence(round, hash(index, frame_seed() ^ 0x3c6ef372u));
            sum.rgb += emitter_irradiance(position, normal, geometric, origin, u) / (PI * float(rounds));
        }
    }
    sum.a += 1.0 / float(rounds);
    imageStore(sum_image, ivec2(pixel), sum);
}
