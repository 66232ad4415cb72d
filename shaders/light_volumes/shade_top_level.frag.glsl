// The lights of the top level, which reach everywhere, at one pixel of one sub-image. One invocation per pixel.
#include "light_volumes/shade.glsl"
#include "merge/tiles.glsl"

layout(push_constant) uniform Push { uint tile; };
layout(location = 0) out vec4 out_lighting;

void main() {
    Surface surface;
    vec4 sum = vec4(0.0);
    if (surface_at(uvec2(gl_FragCoord.xy), surface)) {
        uint first = tiles[TILE_STRIDE * tile + top_level()];
        uint end = tiles[TILE_STRIDE * tile + top_level() + 1u];
        float radius = alpha() * cell_size(grid.h_top, top_level());
        for (uint light = first; light < end; ++light) {
            sum += shade(surface, light, radius, top_level());
        }
        count_fragments(surface.index, end - first);
    }
    out_lighting = sum;
}
