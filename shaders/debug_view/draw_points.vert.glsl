// A disc in the picture's plane around every light of S0. Six vertices per instance, one instance per light that
// fits; those beyond the count fall outside the picture.
#include "common/frame.glsl"

layout(set = 0, binding = 1, std430) readonly buffer LightPositions { uvec4 light_positions[]; };
layout(set = 0, binding = 2, std430) readonly buffer LightFluxes { vec4 light_fluxes[]; };
layout(set = 0, binding = 3, std430) readonly buffer LightCounts { uint light_counts[]; };
layout(push_constant) uniform Push { float radius_px; };

layout(location = 0) out vec2 out_corner;
layout(location = 1) flat out vec3 out_flux;

// A light lies on its surface: this fraction nearer to the eye it is not lost to rounding or to a slanted surface.
const float DEPTH_BIAS = 0.01;

void main() {
    const vec2 CORNERS[6] = vec2[](
        vec2(-1.0, -1.0), vec2(1.0, -1.0), vec2(1.0, 1.0), vec2(-1.0, -1.0), vec2(1.0, 1.0), vec2(-1.0, 1.0));
    out_corner = vec2(0.0);
    out_flux = vec3(0.0);
    gl_Position = vec4(0.0, 0.0, -1.0, 1.0);
    if (gl_InstanceIndex < light_counts[0]) {
        vec4 clip = clip_position(uintBitsToFloat(light_positions[gl_InstanceIndex].xyz));
        out_corner = CORNERS[gl_VertexIndex];
        out_flux = light_fluxes[gl_InstanceIndex].rgb;
        clip.xy += out_corner * (2.0 * radius_px * clip.w) / vec2(image_size());
        // Reversed depth is near / view z.
        clip.z *= 1.0 + DEPTH_BIAS;
        gl_Position = clip;
    }
}
