// Ray traversal over the eight-wide BVH (docs/bvh.md). Needs scene.glsl up to its surfaces.
#include "shared/BvhNode.glsl"

// Directions with a zero component would give NaNs in the slab test.
vec3 safe_inverse(vec3 direction) {
    vec3 tiny = vec3(1e-20);
    vec3 safe = mix(direction, tiny, lessThan(abs(direction), tiny));
    return 1.0 / safe;
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

// A ray as the boxes of a node need it.
struct SlabRay {
    vec3 origin;
    vec3 inverse_direction;
    bvec3 negative;
    // Children in the order of their slots exclusive-or this are front to back.
    uint octant;
};

SlabRay slab_ray(vec3 origin, vec3 direction) {
    bvec3 negative = lessThan(direction, vec3(0.0));
    uint octant = (negative.x ? 0u : 4u) | (negative.y ? 0u : 2u) | (negative.z ? 0u : 1u);
    return SlabRay(origin, safe_inverse(direction), negative, octant);
}

// What of a node a ray meets.
struct NodeHits {
    // First inner child; hit inner children in the upper byte, inner slots in the lowest.
    uvec2 group;
    uint first_triangle;
    // Triangles of the leaves that were hit, counted from the first.
    uint leaf_bits;
};

BvhNode bvh_node(uint i) {
    uint first = BVH_NODE_TEXELS * i;
    return bvh_node_from_texels(
        texelFetch(bvh_nodes, texel_place(first), 0),
        texelFetch(bvh_nodes, texel_place(first + 1u), 0),
        texelFetch(bvh_nodes, texel_place(first + 2u), 0),
        texelFetch(bvh_nodes, texel_place(first + 3u), 0),
        texelFetch(bvh_nodes, texel_place(first + 4u), 0));
}

// Tests the children of a node up to a distance.
NodeHits visit_node(uint index, SlabRay ray, float t_max) {
    BvhNode node = bvh_node(index);
    // Lower planes of the eight children in xy, upper ones in zw; turned so that the nearer ones are in xy.
    uvec4 qx = ray.negative.x ? node.x.zwxy : node.x;
    uvec4 qy = ray.negative.y ? node.y.zwxy : node.y;
    uvec4 qz = ray.negative.z ? node.z.zwxy : node.z;
    vec3 extent = uintBitsToFloat(((uvec3(node.exponents_and_inner) >> uvec3(0u, 8u, 16u)) & 0xffu) << 23u);
    vec3 scale = extent * ray.inverse_direction;
    vec3 start = (node.origin - ray.origin) * ray.inverse_direction;
    uint octant4 = ray.octant * 0x01010101u;
    uint hits = 0u;
    for (uint half_node = 0u; half_node < 2u; ++half_node) {
        bool second = half_node == 1u;
        uint meta4 = second ? node.meta.y : node.meta.x;
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
        bvec4 inside = lessThanEqual(max(near, vec4(0.0)), min(far, vec4(t_max)));
        uvec4 bits = ((uvec4(child_bits4) >> SHIFT) & 0xffu) << ((uvec4(bit_index4) >> SHIFT) & 0xffu);
        bits = mix(uvec4(0u), bits, inside);
        hits |= bits.x | bits.y | bits.z | bits.w;
    }
    uint inner = node.exponents_and_inner >> 24u;
    return NodeHits(uvec2(node.first_child, (hits & 0xff000000u) | inner), node.first_triangle, hits & 0xffffffu);
}

// What is done at every node that a ray visits: a test counts them.
#ifndef ON_VISIT
#define ON_VISIT
#endif

// Nearest hit, or the first hit of any kind when `any_hit`. Cut-out texels are holes. Returns false on a miss.
// Ylitie et al. 2017, algorithm 1, arranged for drivers that run the body of every `if` and only leave loops: a pass
// through the inner loop visits at most one node and tests at most one triangle, so rays side by side do not wait for
// each other's triangles, and the alpha test, by far the dearest part, waits until no ray has anything else to do.
bool traverse(vec3 origin, vec3 direction, float t_max, bool any_hit, out Hit hit) {
    // NaN passes every test of a box where the smaller of NaN and a number is the number: such a ray would visit all nodes.
    t_max = is_finite_ray(origin, direction, t_max) ? t_max : -1.0;
    SlabRay ray = slab_ray(origin, direction);
    uvec2 stack[MAX_WIDE_DEPTH];
    uint depth = 0u;
    hit = Hit(t_max, vec2(0.0), 0u);
    bool found = false;
    bool done = false;
    NodeHits pending = NodeHits(uvec2(0u, 0x80000000u), 0u, 0u);
    do {
        Hit candidate = hit;
        bool masked = false;
        do {
            if (pending.leaf_bits == 0u) {
                uvec2 group = pending.group;
                uint child = uint(findMSB(group.y));
                uint siblings = group.y & ~(1u << child);
                if ((siblings & 0xff000000u) != 0u && depth < MAX_WIDE_DEPTH) {
                    stack[depth++] = uvec2(group.x, siblings);
                }
                uint slot = (child - 24u) ^ ray.octant;
                uint node = group.x + uint(bitCount(group.y & ~(0xffffffffu << slot)));
                pending = visit_node(node, ray, hit.t);
                ON_VISIT;
                if ((pending.group.y & 0xff000000u) == 0u && depth > 0u) {
                    pending.group = stack[--depth];
                }
            }
            if (pending.leaf_bits != 0u) {
                uint i = pending.first_triangle + uint(findLSB(pending.leaf_bits));
                pending.leaf_bits &= pending.leaf_bits - 1u;
                BvhTriangle tri = bvh_triangle(i);
                vec2 barycentric;
                float t = intersect_triangle(origin, direction, tri, barycentric);
                if (t > 0.0 && t < hit.t) {
                    candidate = Hit(t, barycentric, i);
                    masked = (tri.flags & TRIANGLE_ALPHA_MASKED) != 0u;
                    found = found || !masked;
                    if (!masked) {
                        hit = candidate;
                    }
                }
            }
            done = (found && any_hit) || (pending.leaf_bits == 0u && (pending.group.y & 0xff000000u) == 0u);
        } while (!done && !masked);
        if (masked && !is_hole(candidate)) {
            hit = candidate;
            found = true;
            done = done || any_hit;
        }
    } while (!done);
    return found;
}
