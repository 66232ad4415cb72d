// Where light paths would have to start that light what the camera sees. One thread per path from the camera: through a
// point of the picture, then by cosine-distributed diffuse bounces; at every vertex the light of one lamp or from one
// direction of the environment, and the start of the light path that would bring it. Light is the same in both directions,
// so that the starts, each weighted by its light, lie as densely as light paths should.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/color.glsl"
#include "common/octahedral.glsl"
#include "common/scene.glsl"
#include "common/eye_rays.glsl"
#include "common/punctual.glsl"
#include "common/environment.glsl"
#include "common/emitters.glsl"
#include "common/path_starts.glsl"
#include "common/dispatch.glsl"

layout(local_size_x = 64) in;
#include "shared/StartSample.glsl"
// Path p of visible point v, vertex b: sample (v * paths_per_part + p) * bounces + b.
layout(set = 0, binding = 1, std430) writeonly buffer StartSamples { StartSample start_samples[]; };

layout(push_constant) uniform Push {
    // The picture has parts_per_edge^2 parts, and the point that is seen in each has so many paths.
    uint parts_per_edge;
    uint paths_per_part;
    // Luminance of the flux of all lights while they emit most, where they change; else 0.
    float changing_flux;
};

// A light as it is, or while it emits most: one that is dark now is to have paths that start where they will count. Its flux over
// its intensity: Rust's Light::flux_luminance.
PunctualLight at_its_brightest(PunctualLight light) {
    if (changing_flux > 0.0) {
        float spot = 2.0 * PI * (1.0 - light.outer_cos);
        float point = light.kind == LIGHT_POINT ? 4.0 * PI : spot;
        float flux_per_intensity = light.kind == LIGHT_DIRECTIONAL ? PI * scene_radius() * scene_radius() : point;
        light.intensity = vec3(light.path_probability * changing_flux / max(flux_per_intensity, 1e-20));
    }
    return light;
}

// A point in one of parts_per_edge^2 parts of the picture, as a direction from the eye.
vec3 view_direction(uint part, inout uint random_state) {
    vec2 inside = vec2(random(random_state), random(random_state));
    vec2 at = (vec2(part % parts_per_edge, part / parts_per_edge) + inside) / float(parts_per_edge) * 2.0 - 1.0;
    return normalize(ray_through(at));
}

// What the environment sends to the surface from one direction, drawn by its light or by the cosine, and its two numbers.
vec3 sample_environment_start(HitSurface surface, vec3 origin, inout uint random_state, out vec2 numbers) {
    vec2 u = vec2(random(random_state), random(random_state));
    vec3 direction = mixed_direction(surface.normal, u, random(random_state) < 0.5);
    numbers = environment_numbers(direction);
    float cosine = dot(direction, surface.normal);
    if (cosine <= 0.0 || dot(direction, surface.geometric) <= 0.0 || !is_open(origin, direction)) {
        return vec3(0.0);
    }
    return environment_radiance(direction) * cosine / mixed_density(direction, cosine);
}

// What one light, picked by its share of the power, sends to the surface, and the start of its path.
StartSample sample_start(HitSurface surface, vec3 origin, vec3 throughput, inout uint random_state) {
    float position = random(random_state);
    if (is_environment(position)) {
        vec2 numbers;
        vec3 irradiance = sample_environment_start(surface, origin, random_state, numbers);
        vec3 received = throughput / PI * irradiance / frame.environment_share;
        return StartSample(vec3(position, numbers), luminance(received));
    }
    PunctualLight light = lamp_at(position);
    vec2 numbers;
    vec3 irradiance;
    if (light.kind == LIGHT_EMITTERS) {
        numbers = vec2(random(random_state), random(random_state));
        irradiance = emitter_irradiance(surface.position_ws, surface.normal, surface.geometric, origin, numbers);
    } else {
        numbers = start_through(light, surface.position_ws);
        irradiance = irradiance_from(at_its_brightest(light), surface.position_ws, surface.normal, surface.geometric, origin);
    }
    vec3 received = throughput / PI * irradiance / max(lamp_probability(light), 1e-20);
    return StartSample(vec3(position, numbers), luminance(received));
}

void main() {
    uint path = linear_thread();
    if (path >= parts_per_edge * parts_per_edge * paths_per_part) {
        return;
    }
    for (uint bounce = 0u; bounce < frame.bounces; ++bounce) {
        start_samples[path * frame.bounces + bounce] = StartSample(vec3(0.0), 0.0);
    }
    // The paths of one part of the picture leave one point.
    uint part = path / paths_per_part;
    uint view_state = hash(part, frame_seed() ^ 0x2545f491u);
    vec3 direction = view_direction(part, view_state);
    Hit hit;
    if (!traverse_from_eye(direction, hit)) {
        return;
    }
    HitSurface surface = surface_at_hit(hit, direction);
    vec3 origin = surface.position_ws + surface.geometric * ray_offset(surface.position_ws);
    uint random_state = hash(path, frame_seed() ^ 0x165667b1u);
    direction = cosine_direction(surface.normal, r2_sequence(path % paths_per_part, view_state));
    vec3 throughput = vec3(1.0);
    for (uint bounce = 0u; bounce < frame.bounces; ++bounce) {
        if (dot(direction, surface.geometric) <= 0.0 || !traverse(origin, direction, 3e38, false, hit)) {
            return;
        }
        surface = surface_at_hit(hit, direction);
        throughput *= surface.albedo;
        origin = surface.position_ws + surface.geometric * ray_offset(surface.position_ws);
        start_samples[path * frame.bounces + bounce] = sample_start(surface, origin, throughput, random_state);
        direction = cosine_direction(surface.normal, vec2(random(random_state), random(random_state)));
    }
}
