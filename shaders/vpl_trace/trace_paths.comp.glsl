// Light paths from suns, spots and points; a VPL at every diffuse hit. One thread per path; path p writes VPL b
// to slot p * bounces + b and sets that slot's bit, so that the result does not depend on scheduling.
// Reads the scene. Keller 1997; Lin and Yuksel 2019, section 4.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/octahedral.glsl"
#include "common/scene.glsl"
#include "common/punctual.glsl"
#include "common/dispatch.glsl"

layout(local_size_x = 64) in;
layout(set = 0, binding = 1, std430) writeonly buffer SlotPositions { uvec4 slot_positions[]; };
layout(set = 0, binding = 2, std430) writeonly buffer SlotFluxes { vec4 slot_fluxes[]; };
layout(set = 0, binding = 3, std430) buffer SlotBits { uint slot_bits[]; };
layout(set = 0, binding = 4, std430) buffer RayCount { uint ray_count[]; };

struct Emission {
    vec3 origin;
    vec3 direction;
    vec3 flux;
};

// Start of a path; its flux is the light's flux over the expected number of its paths.
Emission emit_path(PunctualLight light, vec2 u) {
    float paths = max(light.path_probability * float(frame.path_count), 1e-20);
    if (light.kind == LIGHT_DIRECTIONAL) {
        // Uniform over the disc that covers the scene's bounding sphere.
        vec3 t, b;
        tangent_frame(light.direction_ws, t, b);
        float radius = scene_radius() * sqrt(u.x);
        float angle = 2.0 * PI * u.y;
        vec3 on_disc = radius * (cos(angle) * t + sin(angle) * b);
        vec3 origin = frame.scene_center_ws + on_disc - light.direction_ws * (2.0 * scene_radius());
        float area = PI * scene_radius() * scene_radius();
        return Emission(origin, light.direction_ws, light.intensity * area / paths);
    }
    if (light.kind == LIGHT_POINT) {
        return Emission(light.position_ws, sphere_direction(u), light.intensity * 4.0 * PI / paths);
    }
    vec3 t, b;
    tangent_frame(light.direction_ws, t, b);
    float along = mix(1.0, light.outer_cos, u.x);
    float across = sqrt(max(1.0 - along * along, 0.0));
    float angle = 2.0 * PI * u.y;
    vec3 direction = normalize(across * (cos(angle) * t + sin(angle) * b) + along * light.direction_ws);
    float edge = clamp((along - light.outer_cos) / max(light.inner_cos - light.outer_cos, 1e-4), 0.0, 1.0);
    float solid_angle = 2.0 * PI * (1.0 - light.outer_cos);
    return Emission(light.position_ws, direction, light.intensity * (edge * edge * solid_angle / paths));
}

void main() {
    uint path = linear_thread();
    if (path >= frame.path_count) {
        return;
    }
    uint random_state = hash(path, frame_seed());
    float position = (float(path) + random(random_state)) / float(frame.path_count);
    vec2 u = r2_sequence(path, frame_seed());
    Emission emission = emit_path(punctual_lights[light_at_share(position)], u);
    vec3 origin = emission.origin;
    vec3 direction = emission.direction;
    vec3 flux = emission.flux;
    uint rays = 0u;
    for (uint bounce = 0u; bounce < frame.bounces; ++bounce) {
        Hit hit;
        ++rays;
        if (!any(greaterThan(flux, vec3(0.0))) || !traverse(origin, direction, 3e38, false, hit)) {
            break;
        }
        HitSurface surface = surface_at_hit(hit, direction);
        flux *= surface.albedo;
        uint slot = path * frame.bounces + bounce;
        if (any(greaterThan(flux, vec3(0.0)))) {
            slot_positions[slot] = uvec4(floatBitsToUint(surface.position_ws), pack_octahedral(surface.normal));
            slot_fluxes[slot] = vec4(flux, 1.0);
            atomicOr(slot_bits[slot / 32u], 1u << (slot % 32u));
        }
        origin = surface.position_ws + surface.geometric * ray_offset(surface.position_ws);
        direction = cosine_direction(surface.normal, vec2(random(random_state), random(random_state)));
        if (dot(direction, surface.geometric) <= 0.0) {
            break;
        }
    }
    atomicAdd(ray_count[0], rays);
}
