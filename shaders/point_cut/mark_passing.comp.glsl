// Marks the nodes that are small enough in the picture, and flat enough, to be primary points. One thread per node.
#include "common/frame.glsl"
#include "common/octahedral.glsl"
#include "common/dispatch.glsl"
layout(local_size_x = WORKGROUP_SIZE) in;

layout(set = 0, binding = 1) uniform utexture2D point_nodes;
layout(set = 0, binding = 2, std430) writeonly buffer PassingBits { uint passing_bits[]; };

#include "common/points.glsl"

// Those of the nodes of a workgroup, which starts at a multiple of its size.
const uint WORDS = WORKGROUP_SIZE / 32u;
shared uint words[WORDS];

bool passes(PointNode node) {
    float distance = length(node.centroid_ws - frame.eye_ws);
    float pixels_at_1 = float(frame.size_px.y) / (2.0 * length(frame.up_ws));
    bool is_small = distance > node.radius && node.radius * pixels_at_1 <= frame.primary_radius_px * distance;
    return is_small && node.cone_cos >= frame.primary_cone_cos;
}

void main() {
    uint node = linear_thread();
    uint lane = gl_LocalInvocationID.x;
    uint node_count = 2u * frame.point_leaf_count;
    if (lane < WORDS) {
        words[lane] = 0u;
    }
    barrier();
    if (node > 0u && node < node_count && passes(point_node(node))) {
        atomicOr(words[lane / 32u], 1u << (lane % 32u));
    }
    barrier();
    uint word = (node - lane) / 32u + lane;
    if (lane < WORDS && word < (node_count + 31u) / 32u) {
        passing_bits[word] = words[lane];
    }
}
