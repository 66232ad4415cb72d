// The scene in descriptor set 1: geometry, BVH, materials, lights; and ray traversal over it.
// Needs constants.glsl and octahedral.glsl.

// obvhs Bvh2Node as it is: inner nodes have prim_count 0 and children first_index, first_index + 1.
struct BvhNode {
    vec3 aabb_min;
    uint prim_count;
    vec3 aabb_max;
    uint first_index;
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

// Rust: shared::GpuMaterial.
struct Material {
    vec4 base_color;
    uint albedo_layer;
    float alpha_cutoff;
    float normal_scale;
    uint has_normal_map;
};

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

// Entry distance of the ray into a box, or a number beyond t_max when it misses.
float intersect_box(vec3 origin, vec3 inverse_direction, vec3 aabb_min, vec3 aabb_max, float t_max) {
    vec3 a = (aabb_min - origin) * inverse_direction;
    vec3 b = (aabb_max - origin) * inverse_direction;
    vec3 near = min(a, b);
    vec3 far = max(a, b);
    float t_near = max(max(near.x, near.y), max(near.z, 0.0));
    float t_far = min(min(far.x, far.y), min(far.z, t_max));
    return t_near <= t_far ? t_near : 3.4e38;
}

// Directions with a zero component would give NaNs in the slab test.
vec3 safe_inverse(vec3 direction) {
    vec3 tiny = vec3(1e-20);
    vec3 safe = mix(direction, tiny, lessThan(abs(direction), tiny));
    return 1.0 / safe;
}

const uint STACK_SIZE = 64u;

bool is_hole(BvhTriangle tri, vec2 barycentric) {
    return (tri.flags & 1u) != 0u
        && base_color_at(tri.material, tri.triangle, barycentric).a < materials[tri.material].alpha_cutoff;
}

// Nearest hit, or the first hit of any kind when `any_hit`. Cut-out texels are holes. Returns false on a miss.
bool traverse(vec3 origin, vec3 direction, float t_max, bool any_hit, out Hit hit) {
    vec3 inverse_direction = safe_inverse(direction);
    uint stack[STACK_SIZE];
    uint depth = 0u;
    hit = Hit(t_max, vec2(0.0), 0u);
    bool found = false;
    uint node_index = 0u;
    BvhNode root = bvh_nodes[0];
    bool active_node = intersect_box(origin, inverse_direction, root.aabb_min, root.aabb_max, hit.t) < 3e38;
    while (active_node) {
        BvhNode node = bvh_nodes[node_index];
        if (node.prim_count > 0u) {
            for (uint i = node.first_index; i < node.first_index + node.prim_count; ++i) {
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
        } else {
            BvhNode left = bvh_nodes[node.first_index];
            BvhNode right = bvh_nodes[node.first_index + 1u];
            float t_left = intersect_box(origin, inverse_direction, left.aabb_min, left.aabb_max, hit.t);
            float t_right = intersect_box(origin, inverse_direction, right.aabb_min, right.aabb_max, hit.t);
            bool right_first = t_right < t_left;
            float t_far = max(t_left, t_right);
            if (min(t_left, t_right) < 3e38) {
                node_index = node.first_index + (right_first ? 1u : 0u);
                if (t_far < 3e38 && depth < STACK_SIZE) {
                    stack[depth++] = node.first_index + (right_first ? 0u : 1u);
                }
                continue;
            }
        }
        active_node = depth > 0u;
        if (active_node) {
            node_index = stack[--depth];
        }
    }
    return found;
}

// Whether anything solid lies between `origin` and `origin + direction * t_max`.
bool is_blocked(vec3 origin, vec3 direction, float t_max) {
    Hit hit;
    return traverse(origin, direction, t_max, true, hit);
}
