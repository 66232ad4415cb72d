// The lighting of a pixel with its shadow. Needs shadow_ratio.glsl and what that needs; the includer declares
// `typical_image`, the widely filtered unshadowed estimate.
#include "shadow_rays/estimate.glsl"

vec3 shadowed_lighting(ivec2 p) {
    if (ESTIMATE == ESTIMATE_UNBIASED) {
        vec4 shadowed = texelFetch(shadowed_image, p, 0);
        return shadowed.rgb * shadowed.a;
    }
    vec4 typical = texelFetch(typical_image, p, 0);
    vec3 unshadowed = ESTIMATE == ESTIMATE_CORRECTED ? typical.rgb * typical.a : texelFetch(indirect_image, p, 0).rgb;
    return unshadowed * shadow_ratio(p).rgb;
}
