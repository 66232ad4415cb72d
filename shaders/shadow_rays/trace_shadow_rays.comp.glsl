// One shadow ray per reservoir, from the pixel to a point on the chosen light (section 3.3). Writes the shadowed
// and the unshadowed estimate S and U per unit of what is in a: for their ratio, which is the shadow (Heitz et al. 2018), the
// sum of the weights that the samples were chosen by, and where S is the light itself the unit that it is filtered by. One
// thread per pixel.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/color.glsl"
#include "common/octahedral.glsl"
#include "common/gbuffer.glsl"
#include "common/lights.glsl"
#include "common/original_lights.glsl"
#include "common/light_texels.glsl"
#include "common/scene.glsl"
#include "common/light_rays.glsl"

layout(local_size_x = TILE_SIZE, local_size_y = TILE_SIZE) in;
layout(push_constant) uniform Push {
    uint index_bits;
#ifdef ROUND
    uint round_number;
    float enough_frames;
#endif
};
#include "shadow_rays/samples.glsl"
layout(set = 0, binding = 6, rgba32f) uniform writeonly image2D out_shadowed;
layout(set = 0, binding = 7, rgba32f) uniform writeonly image2D out_unshadowed;
layout(set = 0, binding = 8, std430) buffer RayCount { uint ray_count[]; };
#ifdef ROUND
// a: frames in the history, this one's rounds so far included.
layout(set = 0, binding = 9) uniform texture2D history_shadowed;
#define ROUND_TILES_BINDING 29
#include "common/rounds.glsl"
#endif

shared uint rays_of_group;

void main() {
#ifdef ROUND
    if (!has_tile()) {
        return;
    }
    uvec2 pixel = pixel_in_tile();
#else
    uvec2 pixel = gl_GlobalInvocationID.xy;
#endif
    if (gl_LocalInvocationIndex == 0u) {
        rays_of_group = 0u;
    }
    barrier();
    bool inside = all(lessThan(pixel, image_size()));
#ifdef ROUND
    // Where no round is needed, the estimates of the last one stay.
    inside = inside && is_short(texelFetch(history_shadowed, ivec2(pixel), 0).a);
#endif
    float depth = inside ? texelFetch(depth_image, ivec2(pixel), 0).x : 0.0;
    uvec2 interleaved = interleaved_from_pixel(pixel);
    vec3 shadowed = vec3(0.0);
    vec3 unshadowed = vec3(0.0);
    float unit = 0.0;
    uint rays = 0u;
    if (depth > 0.0) {
        Receiver receiver = receiver_at(pixel, depth);
        unit = written_unit(receiver);
        uint index = reservoir_index(interleaved);
        uint random_state = sampling_state(index);
        float share = 1.0 / float(shadow_sample_count());
        for (uint i = 0u; i < shadow_sample_count(); ++i) {
            uint light = receiver.total > 0.0 ? selected_light(index, i) : NO_LIGHT;
            ShadowSample result = trace_sample(receiver, light, share, random_state);
            if (result.has_ray) {
                unshadowed += result.estimate;
                shadowed += result.blocked ? vec3(0.0) : result.estimate;
                ++rays;
            }
        }
        if (ESTIMATE != ESTIMATE_RATIO) {
            shadowed *= receiver.unit / unit;
            unshadowed *= receiver.unit / unit;
        }
    }
    if (inside) {
        imageStore(out_shadowed, ivec2(pixel), vec4(shadowed, unit));
        imageStore(out_unshadowed, ivec2(pixel), vec4(unshadowed, unit));
    }
    atomicAdd(rays_of_group, rays);
    barrier();
    if (gl_LocalInvocationIndex == 0u) {
        atomicAdd(ray_count[1], rays_of_group);
    }
}
