// One shadow ray per reservoir, from the pixel to a point jittered about the chosen light by its deviation
// (section 3.3). Writes the shadowed and the unshadowed estimate S and U; their ratio is the shadow
// (Heitz et al. 2018). One thread per pixel.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/color.glsl"
#include "common/octahedral.glsl"
#include "common/gbuffer.glsl"
#include "common/lights.glsl"
#include "common/scene.glsl"
#extension GL_EXT_samplerless_texture_functions : require
#ifdef RESERVOIR_EXACT
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#endif

layout(local_size_x = TILE_SIZE, local_size_y = TILE_SIZE) in;
layout(set = 0, binding = 1) uniform texture2D depth_image;
layout(set = 0, binding = 2) uniform utexture2D normals_image;
layout(set = 0, binding = 3) uniform texture2D lighting_image;
layout(set = 0, binding = 4, std430) readonly buffer MergedLights { GridLight merged_lights[]; };
#ifdef RESERVOIR_EXACT
layout(set = 0, binding = 5, std430) readonly buffer Reservoirs { uint64_t reservoirs[]; };
#else
layout(set = 0, binding = 5, std430) readonly buffer Reservoirs { uint reservoirs[]; };
#endif
layout(set = 0, binding = 6, rgba16f) uniform writeonly image2D out_shadowed;
layout(set = 0, binding = 7, rgba16f) uniform writeonly image2D out_unshadowed;
layout(set = 0, binding = 8, std430) buffer RayCount { uint ray_count[]; };

uint selected_light(uint pixel_index, uint i) {
#ifdef RESERVOIR_EXACT
    return uint(reservoirs[pixel_index * shadow_sample_count() + i] & 0xfffffffful);
#else
    uint base = pixel_index * (shadow_sample_count() + 2u);
    return reservoirs[base + 1u] == 0u ? NO_LIGHT : reservoirs[base + 2u + i];
#endif
}

shared uint rays_of_group;

void main() {
    if (gl_LocalInvocationIndex == 0u) {
        rays_of_group = 0u;
    }
    barrier();
    uvec2 pixel = gl_GlobalInvocationID.xy;
    bool inside = all(lessThan(pixel, image_size()));
    float depth = inside ? texelFetch(depth_image, ivec2(pixel), 0).x : 0.0;
    uvec2 interleaved = interleaved_from_pixel(pixel);
    float total = inside ? texelFetch(lighting_image, ivec2(interleaved), 0).a : 0.0;
    vec3 shadowed = vec3(0.0);
    vec3 unshadowed = vec3(0.0);
    uint rays = 0u;
    if (depth > 0.0 && total > 0.0) {
        vec3 geometric = unpack_octahedral(texelFetch(normals_image, ivec2(pixel), 0).y);
        vec3 position = position_from_depth(pixel, depth);
        vec3 origin = position + geometric * surface_offset(position);
        uint index = reservoir_index(interleaved);
        uint state = hash(index, frame_seed() ^ 0x5bd1e995u);
        for (uint i = 0u; i < shadow_sample_count(); ++i) {
            uint light = selected_light(index, i);
            vec3 u = vec3(random(state), random(state), random(state));
            if (light == NO_LIGHT) {
                continue;
            }
            // Uniform with the light's deviation: half-width sqrt(3) sigma per axis.
            vec3 jitter = (2.0 * u - 1.0) * sqrt(3.0 * merged_lights[light].variance);
            vec3 to_light = merged_lights[light].position_ws + jitter - origin;
            float distance = max(length(to_light), 1e-20);
            vec3 flux = merged_lights[light].flux;
            vec3 color = flux * (total / (max(luminance(flux), 1e-30) * float(shadow_sample_count())));
            ++rays;
            unshadowed += color;
            if (!is_blocked(origin, to_light / distance, distance - ray_offset())) {
                shadowed += color;
            }
        }
    }
    if (inside) {
        imageStore(out_shadowed, ivec2(pixel), vec4(shadowed, 1.0));
        imageStore(out_unshadowed, ivec2(pixel), vec4(unshadowed, 1.0));
    }
    atomicAdd(rays_of_group, rays);
    barrier();
    if (gl_LocalInvocationIndex == 0u) {
        atomicAdd(ray_count[1], rays_of_group);
    }
}
