// The lights of the top level, which reach everywhere, at one pixel of one sub-image. One invocation per pixel.
#include "light_volumes/shade.glsl"
#include "merge/sub_images.glsl"

layout(push_constant) uniform Push { uint sub_image; };
layout(location = 0) out vec4 out_lighting;

void main() {
    Surface surface;
    vec4 sum = vec4(0.0);
    if (surface_at(uvec2(gl_FragCoord.xy), surface)) {
        uint first = sub_images[SUB_IMAGE_STRIDE * sub_image + top_level()];
        uint end = sub_images[SUB_IMAGE_STRIDE * sub_image + top_level() + 1u];
        float radius = alpha() * cell_size(grid.h_top, top_level());
        for (uint light = first; light < end; ++light) {
            sum += shade(surface, light, radius, top_level());
        }
        count_lights_tested(surface.index, end - first);
    }
    out_lighting = sum;
}
