// Discontinuity buffer: bit 0 where the surface breaks between a pixel and its right neighbour, bit 1 between it
// and the one below (Segovia et al. 2006). One thread per pixel.
#include "common/frame.glsl"
#include "common/octahedral.glsl"
#include "common/gbuffer.glsl"
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = TILE_SIZE, local_size_y = TILE_SIZE) in;
layout(set = 0, binding = 1) uniform texture2D depth_image;
layout(set = 0, binding = 2) uniform utexture2D normals_image;
layout(set = 0, binding = 3, std430) writeonly buffer Edges { uint edges[]; };

// Surfaces that turn by more than this cosine, or that leave each other's plane by more than this fraction of
// the distance to the eye, are different ones.
const float MIN_COSINE = 0.9;
const float MAX_PLANE_DISTANCE = 0.01;

bool is_edge(uvec2 a, uvec2 b) {
    if (any(greaterThanEqual(b, image_size()))) {
        return true;
    }
    float depth_a = texelFetch(depth_image, ivec2(a), 0).x;
    float depth_b = texelFetch(depth_image, ivec2(b), 0).x;
    if (depth_a <= 0.0 || depth_b <= 0.0) {
        return true;
    }
    vec3 normal_a = unpack_octahedral(texelFetch(normals_image, ivec2(a), 0).x);
    vec3 normal_b = unpack_octahedral(texelFetch(normals_image, ivec2(b), 0).x);
    vec3 offset = position_from_depth(b, depth_b) - position_from_depth(a, depth_a);
    float view_depth = frame.near / max(depth_a, depth_b);
    float off_plane = max(abs(dot(offset, normal_a)), abs(dot(offset, normal_b)));
    return dot(normal_a, normal_b) < MIN_COSINE || off_plane > MAX_PLANE_DISTANCE * view_depth;
}

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (all(lessThan(pixel, image_size()))) {
        uint right = is_edge(pixel, pixel + uvec2(1u, 0u)) ? 1u : 0u;
        uint below = is_edge(pixel, pixel + uvec2(0u, 1u)) ? 2u : 0u;
        edges[pixel.y * image_size().x + pixel.x] = right | below;
    }
}
