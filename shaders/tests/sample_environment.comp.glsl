// What common/environment.glsl makes of numbers, for comparison with its twin: each thread draws a direction. A test's shader.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/octahedral.glsl"
#include "common/scene.glsl"
#include "common/environment.glsl"

layout(local_size_x = 64) in;
// Twelve numbers a draw: u; direction, density; from the direction alone u and density again; radiance.
layout(set = 0, binding = 1, std430) writeonly buffer Draws { float draws[]; };
layout(push_constant) uniform Push { uint draw_count; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= draw_count) {
        return;
    }
    vec2 u = r2_sequence(i, frame_seed());
    EnvironmentSample drawn = sample_environment(u);
    vec2 again = environment_numbers(drawn.direction);
    vec3 radiance = environment_radiance(drawn.direction);
    float values[12] = float[](
        u.x, u.y, drawn.direction.x, drawn.direction.y, drawn.direction.z, drawn.density,
        again.x, again.y, environment_density(drawn.direction), radiance.x, radiance.y, radiance.z);
    for (uint k = 0u; k < 12u; ++k) {
        draws[12u * i + k] = values[k];
    }
}
