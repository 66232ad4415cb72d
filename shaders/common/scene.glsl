// The scene in descriptor set 1: geometry, BVH, materials, lights; and ray traversal over it.
// Needs constants.glsl and octahedral.glsl.

#include "common/words.glsl"

#include "shared/BvhTriangle.glsl"

#include "common/material.glsl"

#include "shared/PunctualLight.glsl"

// Images, as drivers without a GPU read the four words of a texel together, those of a buffer one by one.
layout(set = 1, binding = 0) uniform utexture2D bvh_nodes;
layout(set = 1, binding = 1) uniform utexture2D bvh_triangles;
// VERTEX_WORDS words per vertex: position, octahedral normal, uv, colour. Rust: scene::Vertex.
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

BvhTriangle bvh_triangle(uint i) {
    uint first = BVH_TRIANGLE_TEXELS * i;
    return bvh_triangle_from_texels(
        texelFetch(bvh_triangles, texel_place(first), 0),
        texelFetch(bvh_triangles, texel_place(first + 1u), 0),
        texelFetch(bvh_triangles, texel_place(first + 2u), 0));
}

vec2 vertex_uv(uint vertex) {
    uint first = VERTEX_WORDS * vertex + 4u;
    return vec2(uintBitsToFloat(scene_vertices[first]), uintBitsToFloat(scene_vertices[first + 1u]));
}

vec4 vertex_color(uint vertex) {
    uint first = VERTEX_WORDS * vertex + 6u;
    return vec4(unpackUnorm2x16(scene_vertices[first]), unpackUnorm2x16(scene_vertices[first + 1u]));
}

vec2 hit_uv(uint triangle, vec2 barycentric) {
    vec2 a = vertex_uv(scene_indices[3u * triangle]);
    vec2 b = vertex_uv(scene_indices[3u * triangle + 1u]);
    vec2 c = vertex_uv(scene_indices[3u * triangle + 2u]);
    return a + (b - a) * barycentric.x + (c - a) * barycentric.y;
}

vec4 hit_color(uint triangle, vec2 barycentric) {
    vec4 a = vertex_color(scene_indices[3u * triangle]);
    vec4 b = vertex_color(scene_indices[3u * triangle + 1u]);
    vec4 c = vertex_color(scene_indices[3u * triangle + 2u]);
    return a + (b - a) * barycentric.x + (c - a) * barycentric.y;
}

// Base colour with alpha at a point of a triangle, from the small textures of the albedo array.
vec4 base_color_at(uint material_index, uint triangle, vec2 barycentric) {
    Material material = materials[material_index];
    vec4 factor = material.base_color;
    if ((material.flags & MATERIAL_VERTEX_COLORS) != 0u) {
        factor *= hit_color(triangle, barycentric);
    }
    if (material.albedo_layer == NO_LAYER) {
        return factor;
    }
    vec2 uv = hit_uv(triangle, barycentric);
    if ((material.flags & MATERIAL_SAMPLING) != 0u) {
        uv = place_in_layer(material.flags, uv, float(textureSize(albedo_array, 0).x));
    }
    return factor * textureLod(albedo_array, vec3(uv, float(material.albedo_layer)), 0.0);
}

// What a surface that shines by itself sends out at a point of a triangle.
vec3 emission_at(uint material_index, uint triangle, vec2 barycentric) {
    Material material = materials[material_index];
    if (material.emission_layer == NO_LAYER) {
        return material.emission;
    }
    uint flags = material.flags >> MATERIAL_EMISSION_SHIFT;
    vec2 uv = place_in_layer(flags, hit_uv(triangle, barycentric), float(textureSize(albedo_array, 0).x));
    return material.emission * textureLod(albedo_array, vec3(uv, float(material.emission_layer)), 0.0).rgb;
}

vec3 hit_normal(uint triangle, vec2 barycentric) {
    vec3 a = unpack_octahedral(scene_vertices[VERTEX_WORDS * scene_indices[3u * triangle] + 3u]);
    vec3 b = unpack_octahedral(scene_vertices[VERTEX_WORDS * scene_indices[3u * triangle + 1u] + 3u]);
    vec3 c = unpack_octahedral(scene_vertices[VERTEX_WORDS * scene_indices[3u * triangle + 2u] + 3u]);
    return a + (b - a) * barycentric.x + (c - a) * barycentric.y;
}

// Whether all numbers of a ray are finite. By their bits: compilers may take it for granted that there are no others.
bool is_finite_ray(vec3 origin, vec3 direction, float t_max) {
    uvec3 exponents = max(floatBitsToUint(origin) & 0x7f800000u, floatBitsToUint(direction) & 0x7f800000u);
    return max(max(exponents.x, exponents.y), max(exponents.z, floatBitsToUint(t_max) & 0x7f800000u)) != 0x7f800000u;
}

// The direction of a vector, or another one where it has none.
vec3 direction_or(vec3 v, vec3 otherwise) { return dot(v, v) > 0.0 ? normalize(v) : otherwise; }

// Where a ray met the scene.
struct HitSurface {
    vec3 position_ws;
    // Both turned towards where the ray came from.
    vec3 geometric;
    vec3 normal;
    vec3 albedo;
};

HitSurface surface_at_hit(Hit hit, vec3 direction) {
    BvhTriangle tri = bvh_triangle(hit.bvh_triangle);
    vec3 geometric = direction_or(cross(tri.edge1, tri.edge2), -direction);
    geometric = dot(geometric, direction) > 0.0 ? -geometric : geometric;
    // Normals of corners may cancel out.
    vec3 normal = direction_or(hit_normal(tri.triangle_index, hit.barycentric), geometric);
    normal = dot(normal, geometric) < 0.0 ? -normal : normal;
    vec3 position_ws = tri.v0 + tri.edge1 * hit.barycentric.x + tri.edge2 * hit.barycentric.y;
    vec3 albedo = base_color_at(tri.material, tri.triangle_index, hit.barycentric).rgb;
    return HitSurface(position_ws, geometric, normal, albedo);
}

// Whether a hit on an alpha-masked triangle goes through a cut-out texel.
bool is_hole(Hit hit) {
    BvhTriangle tri = bvh_triangle(hit.bvh_triangle);
    return base_color_at(tri.material, tri.triangle_index, hit.barycentric).a < materials[tri.material].alpha_cutoff;
}

#ifdef RAY_QUERY
#include "common/ray_query.glsl"
#else
#include "common/bvh.glsl"
#endif

// Whether anything solid lies between `origin` and `origin + direction * t_max`.
bool is_blocked(vec3 origin, vec3 direction, float t_max) {
    Hit hit;
    return traverse(origin, direction, t_max, true, hit);
}
