// Micro-buffers: texels that divide the hemisphere above a point. Needs frame.glsl, random.glsl and octahedral.glsl.
// Rust: micro_buffers.
layout(set = 0, binding = 10) uniform utexture2D point_nodes;
#include "common/points.glsl"
#include "shared/MicroTexel.glsl"

layout(set = 0, binding = 1, std430) readonly buffer MicroTable { MicroTexel micro_table[]; };

const uint PRIMARY_TEXELS = PRIMARY_EDGE * PRIMARY_EDGE;
const uint SECONDARY_TEXELS = SECONDARY_EDGE * SECONDARY_EDGE;
const uint LOBES = LOBE_EDGE * LOBE_EDGE;

// Whether any direction lies in a texel.
bool is_used(MicroTexel texel) { return texel.solid_angle > 0.0; }

// From the frame of a micro-buffer to world space: two tangents and the normal. Turned at random for each point: else
// neighbours would share their error, which shows as bands.
mat3 micro_frame(vec3 normal, uint key) {
    vec3 t, b;
    tangent_frame(normal, t, b);
    float angle = 2.0 * PI * unit_float(hash(key, frame_seed() ^ 0x7f4a7c15u));
    float c = cos(angle);
    float s = sin(angle);
    return mat3(c * t + s * b, c * b - s * t, normal);
}

// Where a point stands that light is gathered at.
struct PointPlace {
    vec3 position_ws;
    vec3 normal_ws;
};

// Off the surface by this share of a leaf's radius, where rays start.
const float POINT_OFFSET = 0.1;

// A point of a surface with this normal, as it is lit.
PointPlace place_above(vec3 position, vec3 normal) {
    float offset = max(POINT_OFFSET * frame.point_leaf_radius, ray_offset(position));
    return PointPlace(position + offset * normal, normal);
}

// A leaf as one of its sides is lit: 0 faces its normal.
PointPlace leaf_place(uint leaf_node, uint side) {
    PointNode leaf = point_node(leaf_node);
    return place_above(leaf.centroid_ws, side == 0u ? leaf.normal : -leaf.normal);
}

// A texel of a micro-buffer as it is kept: coverage in the uppermost 8 bits, then the key of what is seen, or 0.
uint pack_micro_texel(float coverage, uint key) { return uint(round(255.0 * coverage)) << 24u | key; }
float coverage_of(uint micro_texel) { return float(micro_texel >> 24u) / 255.0; }
uint key_of(uint micro_texel) { return micro_texel & 0xffffffu; }
