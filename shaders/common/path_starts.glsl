// Where light paths start: two numbers of a light say from where and in which direction, and back. Needs frame.glsl,
// random.glsl, scene.glsl.

struct Emission {
    vec3 origin;
    vec3 direction;
    vec3 flux;
};

// Start of a path for u in the unit square; its flux is the light's flux over the expected number of its paths.
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
