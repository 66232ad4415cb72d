// Writes what points.glsl and its companions say of every node, and which leaves hits find. One thread per node and hit.
#include "common/frame.glsl"
#include "common/octahedral.glsl"
layout(local_size_x = WORKGROUP_SIZE) in;

layout(set = 0, binding = 1) uniform utexture2D point_nodes;
layout(set = 0, binding = 2, std430) readonly buffer PointAlbedos { uint point_albedos[]; };
layout(set = 0, binding = 3, std430) readonly buffer TriangleCells { uvec2 triangle_cells[]; };
layout(set = 0, binding = 4, std430) readonly buffer LeafCells { uint leaf_cells[]; };
// Second and third corner's weight, triangle, unused.
layout(set = 0, binding = 5, std430) readonly buffer Hits { vec4 hits[]; };
layout(set = 0, binding = 6, std430) writeonly buffer Seen { vec4 seen[]; };
layout(set = 0, binding = 7, std430) writeonly buffer Keys { uvec4 keys[]; };
layout(set = 0, binding = 8, std430) writeonly buffer HitLeaves { uint hit_leaves[]; };
layout(push_constant) uniform Push { uint hit_count; };

#include "common/points.glsl"
#include "common/point_albedos.glsl"
#include "common/point_hits.glsl"

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < hit_count) {
        hit_leaves[i] = leaf_of_hit(uint(hits[i].z), hits[i].xy);
    }
    if (i == 0u || i >= 2u * frame.point_leaf_count) {
        return;
    }
    PointNode node = point_node(i);
    seen[5u * i] = vec4(node.centroid_ws, node.radius);
    seen[5u * i + 1u] = vec4(node.normal, node.area);
    seen[5u * i + 2u] = vec4(node.normal_length, node.cone_cos, node.half_thickness, node.is_solid ? 1.0 : 0.0);
    seen[5u * i + 3u] = vec4(point_position(node), node.is_turned ? 1.0 : 0.0);
    seen[5u * i + 4u] = vec4(point_albedo(i), float(node_level(i)));
    bool leaf = is_leaf(i);
    keys[i] = uvec4(parent_key(2u * i + 1u), leaf ? 0u : child_key(2u * i, 0u), leaf ? 0u : child_key(2u * i, 1u),
        after_subtree(i));
}
