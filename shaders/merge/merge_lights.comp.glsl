// Copies the lights of all used levels into one list, as structs and as texels, dealt to the sub-images with their flux scaled to match.
// One thread per light: grid lights first, then S0 when it is used. `vertex` of a merged light is its index in
// the grid lights or in S0.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/color.glsl"
#include "common/octahedral.glsl"
#include "common/lights.glsl"
#include "common/original_lights.glsl"
#include "common/light_texels.glsl"
#include "common/dispatch.glsl"

layout(local_size_x = WORKGROUP_SIZE) in;
layout(set = 0, binding = 1, std430) readonly buffer GridLights { GridLight grid_lights[]; };
layout(set = 0, binding = 2, std430) readonly buffer LevelTable { uint level_table[]; };
layout(set = 0, binding = 3, std430) readonly buffer SubImages { uint sub_images[]; };
layout(set = 0, binding = 4, std430) readonly buffer LightPositions { uvec4 light_positions[]; };
layout(set = 0, binding = 5, std430) readonly buffer LightFluxes { vec4 light_fluxes[]; };
layout(set = 0, binding = 6, std430) readonly buffer LightCounts { uint light_counts[]; };
layout(set = 0, binding = 7, std430) writeonly buffer MergedLights { GridLight merged_lights[]; };

layout(set = 0, binding = 8, std430) readonly buffer Grid { GridPlacement grid; };
layout(set = 0, binding = 9, rgba32f) uniform writeonly image2D light_texels;

#include "common/level_table.glsl"
#include "merge/sub_images.glsl"

void store(uint index, GridLight light) {
    merged_lights[index] = light;
    float radius = alpha() * cell_size(grid.h_top, light.level);
    imageStore(light_texels, light_texel(index, 0u), vec4(light.position_ws, radius));
    imageStore(light_texels, light_texel(index, 1u), vec4(light.lobe, light.luminance));
    imageStore(light_texels, light_texel(index, 2u), vec4(light.flux, light.weight));
}

void deal(GridLight light, uint index, uint count) {
    uint sub_image_count = interleave() * interleave();
    if (count < sub_image_count) {
        for (uint sub_image = 0u; sub_image < sub_image_count; ++sub_image) {
            store(sub_images[SUB_IMAGE_STRIDE * sub_image + light.level] + index, light);
        }
        return;
    }
    light.flux *= float(sub_image_count);
    light.luminance *= float(sub_image_count);
    light.weight *= float(sub_image_count);
    store(sub_images[SUB_IMAGE_STRIDE * (index % sub_image_count) + light.level] + index / sub_image_count, light);
}

GridLight original_light(uint index) {
    uvec4 position_normal = light_positions[index];
    vec4 flux = light_fluxes[index];
    vec3 lobe = original_lobe(position_normal, flux);
    return GridLight(uintBitsToFloat(position_normal.xyz), luminance(flux.rgb), vec3(0.0), 0u, lobe, 1.0, flux.rgb, index);
}

void main() {
    uint index = linear_thread();
    uint grid_light_count = level_first(top_level()) + level_count(top_level());
    if (index < grid_light_count) {
        GridLight light = grid_lights[index];
        light.vertex = index;
        if (light.level >= first_level()) {
            deal(light, index - level_first(light.level), level_count(light.level));
        }
    } else if (first_level() == 0u && index - grid_light_count < light_counts[0]) {
        deal(original_light(index - grid_light_count), index - grid_light_count, light_counts[0]);
    }
}
