// The filtered shadow of a pixel. Needs frame.glsl and color.glsl; the includer declares `indirect_image` (the unshadowed
// lighting), `shadowed_image` and `unshadowed_image`.

// A channel has a shadow of its own where the samples carry at least this fraction of the light that the lighting says it
// has relative to the others. Below that its few samples, or none, say nothing, and it takes the shadow of all light.
const float LEAST_SHARE = 1.0 / 16.0;

// S/U per channel, in a that of the luminances; 0/0 is 1: where no sample carries light there is nothing to darken.
vec4 ratio(vec3 shadowed, vec3 unshadowed, vec3 lighting) {
    float all_unshadowed = luminance(unshadowed);
    if (all_unshadowed <= 0.0) {
        return vec4(1.0);
    }
    float all = luminance(shadowed) / all_unshadowed;
    vec3 expected = all_unshadowed * lighting / max(luminance(lighting), 1e-30);
    vec3 trust = clamp(unshadowed / max(LEAST_SHARE * expected, vec3(1e-30)), 0.0, 1.0);
    return vec4(mix(vec3(all), shadowed / max(unshadowed, vec3(1e-30)), trust), all);
}

// Half the window that stands in for a pixel none of whose samples carry light. Without a filter there are such
// pixels: the few lights that they chose do not reach them.
const int NEIGHBOURS = 2;

vec4 shadow_ratio(ivec2 p) {
    vec3 s = texelFetch(shadowed_image, p, 0).rgb;
    vec3 u = texelFetch(unshadowed_image, p, 0).rgb;
    if (u == vec3(0.0)) {
        for (int y = -NEIGHBOURS; y <= NEIGHBOURS; ++y) {
            for (int x = -NEIGHBOURS; x <= NEIGHBOURS; ++x) {
                ivec2 q = clamp(p + ivec2(x, y), ivec2(0), ivec2(image_size()) - 1);
                s += texelFetch(shadowed_image, q, 0).rgb;
                u += texelFetch(unshadowed_image, q, 0).rgb;
            }
        }
    }
    return ratio(s, u, texelFetch(indirect_image, p, 0).rgb);
}
