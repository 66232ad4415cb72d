// Mean, lowest and highest level of the lights that a pixel's reservoirs have chosen; -1 where there is none. In a the
// mean again, for the colour map. One thread per pixel.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/lights.glsl"
#define RESERVOIR_BINDING 2
#include "shadow_rays/chosen_lights.glsl"

layout(local_size_x = TILE_SIZE, local_size_y = TILE_SIZE) in;
layout(set = 0, binding = 1, std430) readonly buffer MergedLights { GridLight merged_lights[]; };
layout(set = 0, binding = 3, rgba32f) uniform writeonly image2D out_values;

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, image_size()))) {
        return;
    }
    uint index = reservoir_index(interleaved_from_pixel(pixel));
    uint sum = 0u;
    uint chosen = 0u;
    uint lowest = MAX_LEVEL;
    uint highest = 0u;
    for (uint i = 0u; i < shadow_sample_count(); ++i) {
        uint light = selected_light(index, i);
        if (light != NO_LIGHT) {
            uint level = merged_lights[light].level;
            sum += level;
            lowest = min(lowest, level);
            highest = max(highest, level);
            ++chosen;
        }
    }
    float mean = float(sum) / float(max(chosen, 1u));
    vec4 values = chosen > 0u ? vec4(mean, float(lowest), float(highest), mean) : vec4(-1.0);
    imageStore(out_values, ivec2(pixel), values);
}
