// The environment as texels of micro-buffers see it: means over caps of several sizes. Needs environment.glsl.
// Rust: environment::blurred.
layout(set = 0, binding = 2, std430) readonly buffer EnvironmentMeans { vec4 environment_means[]; };

// Of one level, bilinear, around in u and up to the poles in v.
vec3 environment_mean_at(vec2 place, uint level) {
    vec2 at = place * vec2(BLURRED_COLUMNS, BLURRED_ROWS) - 0.5;
    vec2 part = fract(at);
    ivec2 low = ivec2(floor(at));
    uvec2 left_top = uvec2((low.x + int(BLURRED_COLUMNS)) % int(BLURRED_COLUMNS), max(low.y, 0));
    uvec2 right_bottom = uvec2((low.x + 1) % int(BLURRED_COLUMNS), min(low.y + 1, int(BLURRED_ROWS) - 1));
    uint top = (level * BLURRED_ROWS + left_top.y) * BLURRED_COLUMNS;
    uint bottom = (level * BLURRED_ROWS + right_bottom.y) * BLURRED_COLUMNS;
    vec3 above = mix(environment_means[top + left_top.x].rgb, environment_means[top + right_bottom.x].rgb, part.x);
    vec3 below = mix(environment_means[bottom + left_top.x].rgb, environment_means[bottom + right_bottom.x].rgb, part.x);
    return mix(above, below, part.y);
}

// Radiance from about a direction, as a texel of a micro-buffer sees it whose level this is.
vec3 environment_mean(vec3 direction, float level) {
    if (!has_environment()) {
        return vec3(0.0);
    }
    vec2 place = environment_place(direction);
    uint fine = min(uint(level), BLURRED_LEVELS - 1u);
    uint coarse = min(fine + 1u, BLURRED_LEVELS - 1u);
    vec3 radiance = mix(environment_mean_at(place, fine), environment_mean_at(place, coarse), level - float(fine));
    return frame.environment_scale * radiance;
}
