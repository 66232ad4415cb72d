// The lights of the scene file. Needs frame.glsl and scene.glsl.

// The light at a position (0 to 1) in the order of the lights, each as wide as its share of the power.
uint light_at_share(float position) {
    uint low = 0u;
    uint high = uint(punctual_lights.length()) - 1u;
    while (low < high) {
        uint middle = (low + high) / 2u;
        if (position < punctual_lights[middle].path_cdf) {
            high = middle;
        } else {
            low = middle + 1u;
        }
    }
    return low;
}

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

// Irradiance from one light with its shadow; `origin` is where rays leave the surface. A light behind the surface's
// own plane is hidden by it, although a ray that starts off the surface may pass its edge.
vec3 irradiance_from(PunctualLight light, vec3 position, vec3 normal, vec3 geometric, vec3 origin) {
    vec3 to_light;
    float distance;
    vec3 e = unshadowed_irradiance(light, position, normal, to_light, distance);
    float reach = distance - ray_offset(origin);
    bool lit = dot(to_light, geometric) > 0.0 && any(greaterThan(e, vec3(0.0))) && !is_blocked(origin, to_light, reach);
    return lit ? e : vec3(0.0);
}
