// What one light of the merged list sends to a surface point. Needs frame.glsl and lights.glsl; the includer declares
// `merged_lights`.

// Outgoing radiance per unit albedo and unit flux, times the blending weight of the light's level, with
// `radius` = alpha times the level's cell. Rejects on distance before anything else is read: most fragments end there.
float blended_response(vec3 position_ws, vec3 normal, uint index, float radius, uint level) {
    vec3 offset = merged_lights[index].position_ws - position_ws;
    float distance_squared = dot(offset, offset);
    if (level != top_level() && distance_squared >= 4.0 * radius * radius) {
        return 0.0;
    }
    float distance = sqrt(distance_squared);
    float weight = blend_weight(distance, radius, level, first_level(), top_level());
    if (weight <= 0.0) {
        return 0.0;
    }
    return weight * light_response(offset, distance, normal, merged_lights[index].lobe, level, own_luminance(merged_lights[index]));
}
