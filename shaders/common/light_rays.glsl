// Shadow rays towards lights of the hierarchy. Needs frame.glsl and scene.glsl.

// Whether something stands between `origin` and a light; the ray ends off the light's surface, as the origin is off
// the receiver's.
bool is_light_blocked(vec3 origin, vec3 light_position_ws, vec3 lobe) {
    float off = ray_offset(light_position_ws);
    vec3 to_light = light_position_ws + lobe * off - origin;
    float distance = max(length(to_light), 1e-20);
    return is_blocked(origin, to_light / distance, distance - max(off, ray_offset(origin)));
}
