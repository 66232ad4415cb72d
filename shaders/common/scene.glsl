// The scene in descriptor set 1: geometry, BVH, materials, lights; and ray traversal over it.
// Needs constants.glsl and octahedral.glsl.

// Rust: scene::bvh::BvhNode. Eight children; see there.
struct BvhNode {
    vec3 origin;
    uint exponents_and_inner;
    uint first_child;
    uint first_triangle;
    uvec2 meta;
    uvec4 x;
    uvec4 y;
    uvec4 z;
};

// Rust: scene::bvh::BvhTriangle.
struct BvhTriangle {
    vec3 v0;
    uint triangle;
    vec3 edge1;
    uint material;
    vec3 edge2;
    uint flags;
};

#include "common/material.glsl"

// Rust: shared::PunctualLight.
struct PunctualLight {
    vec3 position_ws;
    uint kind;
    vec3 direction_ws;
    float inner_cos;
    vec3 intensity;
    float outer_cos;
    float path_cdf;
    float path_probability;
    vec2 padding;
};

layout(set = 1, binding = 0, std430) readonly buffer BvhNodes { BvhNode bvh_nodes[]; };
layout(set = 1, binding = 1, std430) readonly buffer BvhTriangles { BvhTriangle bvh_triangles[]; };
// Six words per vertex: position, octahedral normal, uv. Rust: scene::Vertex.
layout(set = 1, binding = 2, std430) readonly buffer SceneVertices { uint scene_vertices[]; };
layout(set = 1, binding = 3, std430) readonly buffer SceneIndices { uint scene_indices[]; };
layout(set = 1, binding = 4, std430) readonly buffer Materials { Material materials[]; };
layout(set = 1, binding = 5, std430) readonly buffer PunctualLights { PunctualLight punctual_lights[]; };
layout(set = 1, binding = 6) uniform sampler2DArray albedo_array;

struct Hit {
    float t;
    vec2 barycentric;
    uint bvh_triangle;
};

vec2 vertex_uv(uint vertex) {
    return vec2(uintBitsToFloat(scene_vertices[6u * vertex + 4u]), uintBitsToFloat(scene_vertices[6u * vertex + 5u]));
}

vec2 hit_uv(uint triangle, vec2 barycentric) {
    vec2 a = vertex_uv(scene_indices[3u * triangle]);
    vec2 b = vertex_uv(scene_indices[3u * triangle + 1u]);
    vec2 c = vertex_uv(scene_indices[3u * triangle + 2u]);
    return a + (b - a) * barycentric.x + (c - a) * barycentric.y;
}

// Base colour with alpha at a point of a triangle, from the small textures of the albedo array.
vec4 base_color_at(uint material_index, uint triangle, vec2 barycentric) {
    Material material = materials[material_index];
    if (material.albedo_layer == NO_LAYER) {
        return material.base_color;
    }
    vec2 uv = hit_uv(triangle, barycentric);
    return material.base_color * textureLod(albedo_array, vec3(uv, float(material.albedo_layer)), 0.0);
}

vec3 hit_normal(uint triangle, vec2 barycentric) {
    vec3 a = unpack_octahedral(scene_vertices[6u * scene_indices[3u * triangle] + 3u]);
    vec3 b = unpack_octahedral(scene_vertices[6u * scene_indices[3u * triangle + 1u] + 3u]);
    vec3 c = unpack_octahedral(scene_vertices[6u * scene_indices[3u * triangle + 2u] + 3u]);
    return a + (b - a) * barycentric.x + (c - a) * barycentric.y;
}

// Where a ray met the scene.
struct HitSurface {
    vec3 position_ws;
    // Both turned towards where the ray came from.
    vec3 geometric;
    vec3 normal;
    vec3 albedo;
};

HitSurface surface_at_hit(Hit hit, vec3 direction) {
    BvhTriangle tri = bvh_triangles[hit.bvh_triangle];
    vec3 geometric = normalize(cross(tri.edge1, tri.edge2));
    geometric = dot(geometric, direction) > 0.0 ? -geometric : geometric;
    vec3 normal = normalize(hit_normal(tri.triangle, hit.barycentric));
    normal = dot(normal, geometric) < 0.0 ? -normal : normal;
    vec3 position_ws = tri.v0 + tri.edge1 * hit.barycentric.x + tri.edge2 * hit.barycentric.y;
    vec3 albedo = base_color_at(tri.material, tri.triangle, hit.barycentric).rgb;
    return HitSurface(position_ws, geometric, normal, albedo);
}

// Moller and Trumbore, two-sided. Returns t or a negative number.
float intersect_triangle(vec3 origin, vec3 direction, BvhTriangle tri, out vec2 barycentric) {
    vec3 p = cross(direction, tri.edge2);
    float determinant = dot(tri.edge1, p);
    float inverse = 1.0 / determinant;
    vec3 s = origin - tri.v0;
    float u = dot(s, p) * inverse;
    vec3 q = cross(s, tri.edge1);
    float v = dot(direction, q) * inverse;
    barycentric = vec2(u, v);
    bool inside = determinant != 0.0 && u >= 0.0 && v >= 0.0 && u + v <= 1.0;
    return inside ? dot(tri.edge2, q) * inverse : -1.0;
}

// Directions with a zero component would give NaNs in the slab test.
vec3 safe_inverse(vec3 direction) {
    vec3 tiny = vec3(1e-20);
    vec3 safe = mix(direction, tiny, lessThan(abs(direction), tiny));
    return 1.0 / safe;
}

// Rust: scene::bvh::MAX_WIDE_DEPTH.
const uint STACK_SIZE = 32u;

bool is_hole(BvhTriangle tri, vec2 barycentric) {
    return (tri.flags & 1u) != 0u
        && base_color_at(tri.material, tri.triangle, barycentric).a < materials[tri.material].alpha_cutoff;
}

// Nearest hit, or the first hit of any kind when `any_hit`. Cut-out texels are holes. Returns false on a miss.
// Ylitie et al. 2017, algorithm 1, without postponed triangles.
bool traverse(vec3 origin, vec3 direction, float t_max, bool any_hit, out Hit hit) {
    vec3 inverse_direction = safe_inverse(direction);
    bvec3 negative = lessThan(direction, vec3(0.0));
    // Children in the order of their slots exclusive-or this are front to back.
    uint octant = (negative.x ? 0u : 4u) | (negative.y ? 0u : 2u) | (negative.z ? 0u : 1u);
    uint octant4 = octant * 0x01010101u;
    uvec2 stack[STACK_SIZE];
    uint depth = 0u;
    hit = Hit(t_max, vec2(0.0), 0u);
    bool found = false;
    // Node group: first child; hit inner children in the upper byte, inner slots in the lowest.
    uvec2 group = uvec2(0u, 0x80000000u);
    while (true) {
        uint child = uint(findMSB(group.y));
        uint inner = group.y;
        group.y &= ~(1u << child);
        uint first_child = group.x;
        if ((group.y & 0xff000000u) != 0u && depth < STACK_SIZE) {
            stack[depth++] = group;
        }
        uint slot = (child - 24u) ^ octant;
        uint node = first_child + uint(bitCount(inner & ~(0xffffffffu << slot)));
        uint exponents_and_inner = bvh_nodes[node].exponents_and_inner;
        uvec2 meta = bvh_nodes[node].meta;
        // Nearer planes of the eight children in xy, farther ones in zw.
        uvec4 qx = bvh_nodes[node].x;
        uvec4 qy = bvh_nodes[node].y;
        uvec4 qz = bvh_nodes[node].z;
        vec3 extent = uintBitsToFloat(((uvec3(exponents_and_inner) >> uvec3(0u, 8u, 16u)) & 0xffu) << 23u);
        vec3 scale = extent * inverse_direction;
        vec3 start = (bvh_nodes[node].origin - origin) * inverse_direction;
        qx = negative.x ? qx.zwxy : qx;
        qy = negative.y ? qy.zwxy : qy;
        qz = negative.z ? qz.zwxy : qz;
        uint hits = 0u;
        for (uint half_node = 0u; half_node < 2u; ++half_node) {
            bool second = half_node == 1u;
            uint meta4 = second ? meta.y : meta.x;
            uint is_inner = (meta4 & (meta4 << 1u)) & 0x10101010u;
            uint bit_index4 = (meta4 ^ (octant4 & ((is_inner >> 4u) * 0xffu))) & 0x1f1f1f1fu;
            uint child_bits4 = (meta4 >> 5u) & 0x07070707u;
            const uvec4 SHIFT = uvec4(0u, 8u, 16u, 24u);
            vec4 near = max(vec4((uvec4(second ? qx.y : qx.x) >> SHIFT) & 0xffu) * scale.x + start.x,
                max(vec4((uvec4(second ? qy.y : qy.x) >> SHIFT) & 0xffu) * scale.y + start.y,
                    vec4((uvec4(second ? qz.y : qz.x) >> SHIFT) & 0xffu) * scale.z + start.z));
            vec4 far = min(vec4((uvec4(second ? qx.w : qx.z) >> SHIFT) & 0xffu) * scale.x + start.x,
                min(vec4((uvec4(second ? qy.w : qy.z) >> SHIFT) & 0xffu) * scale.y + start.y,
                    vec4((uvec4(second ? qz.w : qz.z) >> SHIFT) & 0xffu) * scale.z + start.z));
            bvec4 inside = lessThanEqual(max(near, vec4(0.0)), min(far, vec4(hit.t)));
            uvec4 bits = ((uvec4(child_bits4) >> SHIFT) & 0xffu) << ((uvec4(bit_index4) >> SHIFT) & 0xffu);
            bits = mix(uvec4(0u), bits, inside);
            hits |= bits.x | bits.y | bits.z | bits.w;
        }
        group = uvec2(bvh_nodes[node].first_child, (hits & 0xff000000u) | (exponents_and_inner >> 24u));
        uint leaf_bits = hits & 0xffffffu;
        while (leaf_bits != 0u) {
            uint i = bvh_nodes[node].first_triangle + uint(findLSB(leaf_bits));
            leaf_bits &= leaf_bits - 1u;
            vec2 barycentric;
            float t = intersect_triangle(origin, direction, bvh_triangles[i], barycentric);
            if (t > 0.0 && t < hit.t && !is_hole(bvh_triangles[i], barycentric)) {
                hit = Hit(t, barycentric, i);
                found = true;
                if (any_hit) {
                    return true;
                }
            }
        }
        if ((group.y & 0xff000000u) == 0u) {
            if (depth == 0u) {
                return found;
            }
            group = stack[--depth];
        }
    }
    return found;
}

// Whether anything solid lies between `origin` and `origin + direction * t_max`.
bool is_blocked(vec3 origin, vec3 direction, float t_max) {
    Hit hit;
    return traverse(origin, direction, t_max, true, hit);
}
