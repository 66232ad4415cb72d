// Puts the triangles of the BVH whose vertices have moved where these are now. One thread per triangle.
// CPU twin: scene::refit::moved.
#include "constants.glsl"
#include "common/dispatch.glsl"
#include "common/words.glsl"
#include "shared/BvhTriangle.glsl"
#include "shared/MovedTree.glsl"

layout(local_size_x = WORKGROUP_SIZE) in;
layout(set = 0, binding = 0, std430) readonly buffer MovingTriangles { uint moving_triangles[]; };
layout(set = 0, binding = 1, std430) readonly buffer SceneVertices { uint scene_vertices[]; };
layout(set = 0, binding = 2, std430) readonly buffer SceneIndices { uint scene_indices[]; };
layout(set = 0, binding = 3, rgba32ui) uniform uimage2D bvh_triangles;
layout(set = 0, binding = 4, std430) buffer MovedTrees { MovedTree moved_tree; };
layout(push_constant) uniform Push { uint triangle_count; };

// Bits of an edge's length, which order as the lengths do.
shared uint group_largest;

vec3 position_ws(uint corner) {
    uint first = VERTEX_WORDS * scene_indices[corner];
    return uintBitsToFloat(uvec3(scene_vertices[first], scene_vertices[first + 1u], scene_vertices[first + 2u]));
}

void put(uint texel, vec3 value) {
    ivec2 place = texel_place(texel);
    // The last word says which triangle it is, of which material.
    uint last = imageLoad(bvh_triangles, place).w;
    imageStore(bvh_triangles, place, uvec4(floatBitsToUint(value), last));
}

// The longest edge of the bounding box of the triangle, once it has been moved.
float moved(uint triangle) {
    uint texel = BVH_TRIANGLE_TEXELS * triangle;
    uint corner = 3u * imageLoad(bvh_triangles, texel_place(texel)).w;
    vec3 a = position_ws(corner);
    vec3 b = position_ws(corner + 1u);
    vec3 c = position_ws(corner + 2u);
    put(texel, a);
    put(texel + 1u, b - a);
    put(texel + 2u, c - a);
    vec3 size = max(max(a, b), c) - min(min(a, b), c);
    return max(max(size.x, size.y), size.z);
}

void main() {
    uint index = linear_thread();
    if (gl_LocalInvocationIndex == 0u) {
        group_largest = 0u;
    }
    barrier();
    if (index < triangle_count) {
        atomicMax(group_largest, floatBitsToUint(moved(moving_triangles[index])));
    }
    barrier();
    if (gl_LocalInvocationIndex == 0u) {
        atomicMax(moved_tree.largest_triangle, group_largest);
    }
}
