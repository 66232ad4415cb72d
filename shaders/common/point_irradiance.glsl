// Irradiance by key. Needs the buffer `point_irradiance`, three floats a key.
vec3 irradiance_of(uint key) {
    return vec3(point_irradiance[3u * key], point_irradiance[3u * key + 1u], point_irradiance[3u * key + 2u]);
}

void set_irradiance(uint key, vec3 irradiance) {
    point_irradiance[3u * key] = irradiance.r;
    point_irradiance[3u * key + 1u] = irradiance.g;
    point_irradiance[3u * key + 2u] = irradiance.b;
}
