// Marks the sides of the cut that are seen: of nodes that pass or are leaves, with no node above that passes. One thread
// per node. Every leaf has exactly one such node on its path to the root, whatever passes.
#include "common/frame.glsl"
#include "common/octahedral.glsl"
#include "common/dispatch.glsl"
#include "common/gbuffer.glsl"
layout(local_size_x = WORKGROUP_SIZE) in;

layout(set = 0, binding = 1) uniform utexture2D point_nodes;
layout(set = 0, binding = 2) uniform texture2D depth_image;
layout(set = 0, binding = 3, std430) readonly buffer PassingBits { uint passing_bits[]; };
layout(set = 0, binding = 4, std430) buffer PrimaryBits { uint primary_bits[]; };

#include "common/points.glsl"

bool is_passing(uint node) { return (passing_bits[node >> 5u] >> (node & 31u) & 1u) != 0u; }

bool is_in_cut(uint node) {
    if (!is_leaf(node) && !is_passing(node)) {
        return false;
    }
    for (uint above = node >> 1u; above > 0u; above >>= 1u) {
        if (is_passing(above)) {
            return false;
        }
    }
    return true;
}

// Whether a sphere meets the view.
bool meets_view(vec3 offset, float radius) {
    float ahead = dot(offset, frame.forward_ws);
    vec2 half_size = vec2(length(frame.right_ws), length(frame.up_ws));
    vec2 across = abs(vec2(dot(offset, frame.right_ws), dot(offset, frame.up_ws))) / half_size;
    vec2 outside = (across - ahead * half_size) / sqrt(1.0 + half_size * half_size);
    return ahead + radius > frame.near && max(outside.x, outside.y) < radius;
}

// Whether the surface at the pixel of a position is no nearer to the eye than `least`.
bool is_open(vec3 offset, float least) {
    float ahead = dot(offset, frame.forward_ws);
    if (ahead <= frame.near) {
        return true;
    }
    vec2 half_size_squared = vec2(dot(frame.right_ws, frame.right_ws), dot(frame.up_ws, frame.up_ws));
    vec2 ndc = vec2(dot(offset, frame.right_ws), -dot(offset, frame.up_ws)) / (half_size_squared * ahead);
    vec2 place = (ndc * 0.5 + 0.5) * vec2(image_size()) - pixel_jitter();
    uvec2 pixel = uvec2(clamp(place, vec2(0.0), vec2(image_size() - 1u)));
    float depth = texelFetch(depth_image, ivec2(pixel), 0).r;
    return depth <= 0.0 || length(view_ray(pixel)) * frame.near >= least * depth;
}

bool is_visible(PointNode node) {
    vec3 offset = node.centroid_ws - frame.eye_ws;
    if (!meets_view(offset, node.radius)) {
        return false;
    }
    float least = length(offset) - node.radius - frame.point_leaf_radius;
    float step = node.radius * inversesqrt(2.0);
    vec3 right = normalize(frame.right_ws) * step;
    vec3 up = normalize(frame.up_ws) * step;
    return is_open(offset, least) || is_open(offset - right, least) || is_open(offset + right, least)
        || is_open(offset - up, least) || is_open(offset + up, least);
}

// The side that faces the eye. Of a solid, which has only one to be seen, the outer one as long as any leaf may show it.
uint visible_side(PointNode node) {
    vec3 towards_eye = frame.eye_ws - node.centroid_ws;
    float facing = dot(node.normal, towards_eye);
    float cone_sin = sqrt(max(1.0 - node.cone_cos * node.cone_cos, 0.0));
    float least = node.is_solid && node.cone_cos > 0.0 ? -cone_sin * length(towards_eye) : 0.0;
    return facing < least ? 1u : 0u;
}

void main() {
    uint node = linear_thread();
    if (node == 0u || node >= 2u * frame.point_leaf_count || !is_in_cut(node)) {
        return;
    }
    PointNode point = point_node(node);
    if (is_visible(point)) {
        uint key = 2u * node + visible_side(point);
        atomicOr(primary_bits[key >> 5u], 1u << (key & 31u));
    }
}
