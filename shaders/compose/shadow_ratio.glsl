// The filtered shadow of a pixel. Needs frame.glsl; the includer declares `shadowed_image` and `unshadowed_image`.

// S/U per channel; 0/0 is 1: where no sample carries light there is nothing to darken.
vec3 ratio(vec3 shadowed, vec3 unshadowed) {
    return mix(vec3(1.0), shadowed / max(unshadowed, vec3(1e-30)), greaterThan(unshadowed, vec3(0.0)));
}

// Half the window that stands in for a pixel none of whose samples carry light. Without a filter there are such
// pixels: the few lights that they chose do not reach them.
const int NEIGHBOURS = 2;

vec3 shadow_ratio(ivec2 p) {
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
    return ratio(s, u);
}
