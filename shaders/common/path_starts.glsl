// Where light paths start: one number says from which light, two from where and in which direction, and back. The
// environment comes after the lights of the scene, with its share of the paths; its two numbers say from which direction.
// Surfaces that shine by themselves are one light; its two numbers say from which point.
// Needs frame.glsl, random.glsl, scene.glsl, punctual.glsl, environment.glsl, emitters.glsl.

struct Emission {
    vec3 origin;
    vec3 direction;
    vec3 flux;
};

// Share of the paths that start at lights of the scene.
float lamp_share() { return 1.0 - frame.environment_share; }

bool is_environment(float position) { return frame.environment_share > 0.0 && position >= lamp_share(); }

// The light of the scene at a position in the order of all.
PunctualLight lamp_at(float position) {
    return punctual_lights[light_at_share(position / lamp_share())];
}

// Probability of the paths that start at a light of the scene.
float lamp_probability(PunctualLight light) { return light.path_probability * lamp_share(); }

// A path from far away in a direction, one of so many, its origin uniform over the disc that covers the scene's bounding
// sphere.
Emission emit_through_scene(vec3 direction, vec3 irradiance, float paths, vec2 u) {
    vec3 t, b;
    tangent_frame(direction, t, b);
    float radius = scene_radius() * sqrt(u.x);
    float angle = 2.0 * PI * u.y;
    vec3 on_disc = radius * (cos(angle) * t + sin(angle) * b);
    vec3 origin = frame.scene_center_ws + on_disc - direction * (2.0 * scene_radius());
    float area = PI * scene_radius() * scene_radius();
    return Emission(origin, direction, irradiance * area / paths);
}

// A path from the environment for u, and two further numbers for where it crosses the scene.
Emission emit_from_environment(vec2 u, vec2 on_disc) {
    EnvironmentSample drawn = sample_environment(u);
    float paths = max(frame.environment_share * float(frame.path_count), 1e-20);
    vec3 irradiance = environment_radiance(drawn.direction) / max(drawn.density, 1e-20);
    return emit_through_scene(-drawn.direction, irradiance, paths, on_disc);
}

// A path from the point of u on a surface that shines, and two further numbers for its direction.
Emission emit_from_surface(PunctualLight light, vec2 u, vec2 towards) {
    EmitterPoint point = sample_emitter(u);
    vec3 normal = point.normal;
    if (point.sides > 1.0) {
        normal = towards.x < 0.5 ? normal : -normal;
        towards.x = fract(2.0 * towards.x);
    }
    float paths = max(lamp_probability(light) * float(frame.path_count), 1e-20);
    vec3 flux = point.radiance * (PI * point.sides / (point.density * paths));
    return Emission(point.position_ws + normal * ray_offset(point.position_ws), cosine_direction(normal, towards), flux);
}

// Start of a path for u in the unit square; its flux is the light's flux over the expected number of its paths.
Emission emit_path(PunctualLight light, vec2 u) {
    float paths = max(lamp_probability(light) * float(frame.path_count), 1e-20);
    if (light.kind == LIGHT_DIRECTIONAL) {
        return emit_through_scene(light.direction_ws, light.intensity, paths, u);
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

// The u with which a path from a light goes through a position that the light shines on.
vec2 start_through(PunctualLight light, vec3 position_ws) {
    vec3 from = light.kind == LIGHT_DIRECTIONAL ? frame.scene_center_ws : light.position_ws;
    vec3 offset = position_ws - from;
    vec3 direction = offset / max(length(offset), 1e-20);
    // The sphere's directions turn about z, in the plane of x and y.
    vec2 around = direction.xy;
    float first = 0.5 - 0.5 * direction.z;
    if (light.kind != LIGHT_POINT) {
        vec3 t, b;
        tangent_frame(light.direction_ws, t, b);
        around = vec2(dot(offset, t), dot(offset, b));
        float on_disc = dot(around, around) / max(scene_radius() * scene_radius(), 1e-37);
        float in_cone = (1.0 - dot(direction, light.direction_ws)) / max(1.0 - light.outer_cos, 1e-20);
        first = light.kind == LIGHT_DIRECTIONAL ? on_disc : in_cone;
    }
    float turn = all(equal(around, vec2(0.0))) ? 0.0 : atan(around.y, around.x) / (2.0 * PI);
    return clamp(vec2(first, fract(turn)), 0.0, 1.0);
}
