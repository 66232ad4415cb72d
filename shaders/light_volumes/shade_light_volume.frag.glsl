// One light at one pixel inside its volume. Additive blending sums the lights. One invocation per fragment.
#include "light_volumes/shade.glsl"

layout(location = 0) flat in uint light;
layout(location = 1) flat in float radius;
layout(location = 0) out vec4 out_lighting;

void main() {
    Surface surface;
    bool found = surface_at(uvec2(gl_FragCoord.xy), surface);
    count_lights_tested(reservoir_index(uvec2(gl_FragCoord.xy)), 1u);
    vec4 lighting = found ? shade(surface, light, radius, merged_lights[light].level) : vec4(0.0);
    if (lighting.rgb == vec3(0.0)) {
        discard;
    }
    out_lighting = lighting;
}
