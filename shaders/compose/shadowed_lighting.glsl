// The lighting of a pixel with its shadow. Needs shadow_ratio.glsl and what that needs.
#include "shadow_rays/estimate.glsl"

vec3 shadowed_lighting(ivec2 p) {
    if (ESTIMATE == ESTIMATE_RATIO) {
        return texelFetch(indirect_image, p, 0).rgb * shadow_ratio(p).rgb;
    }
    return texelFetch(shadowed_image, p, 0).rgb * texelFetch(unshadowed_image, p, 0).a;
}
