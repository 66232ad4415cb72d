// A micro-buffer at a pixel: what it sees in each of 16x16 texels, and the light of it. Adds to the sum of radiance per unit
// albedo; its alpha is 1. A workgroup for each pixel of one part.
#include "common/frame.glsl"
#include "common/random.glsl"
#include "common/octahedral.glsl"
#include "common/gbuffer.glsl"
#include "common/scene.glsl"
#include "common/environment.glsl"
#include "common/environment_means.glsl"
#include "common/micro_buffer.glsl"
#include "common/point_sum.glsl"

layout(local_size_x = POINT_LANES) in;
layout(set = 0, binding = 3) uniform texture2D depth_image;
layout(set = 0, binding = 4) uniform utexture2D normals_image;
layout(set = 0, binding = 5, rgba32f) uniform writeonly image2D sum_image;
layout(set = 0, binding = 6, std430) buffer Irradiance { float point_irradiance[]; };
#include "common/point_irradiance.glsl"
layout(set = 0, binding = 11, std430) readonly buffer TriangleCells { uvec2 triangle_cells[]; };
layout(set = 0, binding = 12, std430) readonly buffer LeafCells { uint leaf_cells[]; };
#include "common/point_hits.glsl"
#include "common/hit_key.glsl"
layout(set = 0, binding = 13, std430) readonly buffer PointAlbedos { uint point_albedos[]; };
#include "common/point_albedos.glsl"
layout(push_constant) uniform Push {
    // Whether the light that the environment sends to the pixel itself is part of it.
    uint with_sky;
    uint round;
    uint part;
};

// Radiance from a texel's direction.
vec3 arriving(vec3 origin, vec3 direction, MicroTexel texel) {
    Hit hit;
    if (traverse(origin, direction, 3e38, false, hit)) {
        uint key = hit_key(hit, direction);
        return point_albedo(key >> 1u) * irradiance_of(key) / PI;
    }
    return with_sky != 0u ? environment_mean(direction, texel.environment_level) : vec3(0.0);
}

void main() {
    uint lane = gl_LocalInvocationID.x;
    uint index = part * REFERENCE_TILES * TILE_SIZE * TILE_SIZE + gl_WorkGroupID.x;
    uvec2 pixel = uvec2(index % image_size().x, index / image_size().x);
    if (pixel.y >= image_size().y) {
        return;
    }
    float depth = texelFetch(depth_image, ivec2(pixel), 0).x;
    vec3 sum = vec3(0.0);
    if (depth > 0.0) {
        uvec2 normals = texelFetch(normals_image, ivec2(pixel), 0).xy;
        vec3 geometric = unpack_octahedral(normals.y);
        vec3 position = position_from_depth(pixel, depth);
        vec3 origin = position + geometric * surface_offset(position);
        mat3 to_world = micro_frame(unpack_octahedral(normals.x), index);
        for (uint i = lane; i < PRIMARY_TEXELS; i += POINT_LANES) {
            MicroTexel texel = micro_table[i];
            vec3 direction = to_world * texel.direction;
            if (is_used(texel) && dot(direction, geometric) > 0.0) {
                sum += texel.cosine_weight * arriving(origin, direction, texel);
            }
        }
    }
    sum = sum_over_lanes(lane, sum);
    if (lane == 0u) {
        imageStore(sum_image, ivec2(pixel), vec4(sum / PI, 1.0));
    }
}
