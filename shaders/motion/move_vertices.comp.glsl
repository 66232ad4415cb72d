// Puts the vertices that move where they are at a moment: morphed, then bent by a skin or carried by a node. One thread per vertex.
// CPU twin: scene::motion::Body::pose, in the same order of operations.
#include "constants.glsl"
#include "common/dispatch.glsl"
#include "common/octahedral.glsl"
#include "shared/MovingBody.glsl"
#include "shared/RestVertex.glsl"
#include "shared/JointWeight.glsl"
#include "shared/MorphOffset.glsl"

layout(local_size_x = WORKGROUP_SIZE) in;
layout(set = 0, binding = 0, std430) readonly buffer MovingBodies { MovingBody moving_bodies[]; };
layout(set = 0, binding = 1, std430) readonly buffer RestVertices { RestVertex rest_vertices[]; };
layout(set = 0, binding = 2, std430) readonly buffer JointWeights { JointWeight joint_weights[]; };
layout(set = 0, binding = 3, std430) readonly buffer MorphOffsets { MorphOffset morph_offsets[]; };
// Whether each body is shown, then weights of morph targets and matrices where the bodies say.
layout(set = 0, binding = 4, std430) readonly buffer Pose { uint pose[]; };
layout(set = 0, binding = 5, std430) buffer SceneVertices { uint scene_vertices[]; };
layout(set = 0, binding = 6, std430) buffer SceneTangents { uint scene_tangents[]; };
layout(push_constant) uniform Push { uint vertex_count; };

struct Placed {
    vec3 position;
    // Zero marks one that cannot be used.
    vec3 normal;
    vec4 tangent;
    bool is_mirrored;
};

float pose_number(uint word) { return uintBitsToFloat(pose[word]); }

vec3 pose_column(uint word) { return vec3(pose_number(word), pose_number(word + 1u), pose_number(word + 2u)); }

mat4x3 pose_matrix(uint word) {
    return mat4x3(pose_column(word), pose_column(word + 3u), pose_column(word + 6u), pose_column(word + 9u));
}

// Squared lengths that can be divided by.
const float LEAST_SQUARE = 1e-37;
const float MOST_SQUARE = 3e38;

vec3 unit_or_zero(vec3 v) {
    float square = dot(v, v);
    return square > LEAST_SQUARE && square < MOST_SQUARE ? v * (1.0 / sqrt(square)) : vec3(0.0);
}

// Bits tell, as drivers need not know numbers that are none.
bvec3 is_no_number(vec3 v) {
    return greaterThan(floatBitsToUint(v) & 0x7fffffffu, uvec3(0x7f800000u));
}

// With entries of at most 1, or the products of tiny or huge scales would leave the range of floats.
mat3 scaled_to_one(mat3 m) {
    vec3 most = max(max(abs(m[0]), abs(m[1])), abs(m[2]));
    float size = max(max(most.x, most.y), most.z);
    return size > 0.0 ? m * (1.0 / size) : m;
}

Placed morphed(uint vertex, MovingBody body) {
    RestVertex rest = rest_vertices[vertex];
    precise vec3 position = rest.position;
    precise vec3 normal = rest.normal;
    precise vec3 tangent = rest.tangent.xyz;
    for (uint i = rest.first_offset; i < rest_vertices[vertex + 1u].first_offset; ++i) {
        MorphOffset offset = morph_offsets[i];
        float weight = pose_number(body.first_weight + offset.target);
        position += offset.position * weight;
        normal += offset.normal * weight;
        tangent += offset.tangent * weight;
    }
    return Placed(position, normal, vec4(tangent, rest.tangent.w), false);
}

// From mesh to world space at a vertex.
mat4x3 world_at(uint vertex, MovingBody body) {
    if (body.joints_per_vertex == 0u) {
        return pose_matrix(body.first_matrix);
    }
    uint first = rest_vertices[vertex].first_joint;
    precise mat4x3 world = mat4x3(0.0);
    for (uint i = first; i < first + body.joints_per_vertex; ++i) {
        JointWeight joint = joint_weights[i];
        world += pose_matrix(body.first_matrix + POSE_MATRIX_WORDS * joint.joint) * joint.weight;
    }
    return world;
}

Placed placed(uint vertex, MovingBody body) {
    Placed rest = morphed(vertex, body);
    mat4x3 world = world_at(vertex, body);
    precise vec3 position = world[0] * rest.position.x;
    position = world[1] * rest.position.y + position;
    position = world[2] * rest.position.z + position;
    position = world[3] + position;
    mat3 linear = mat3(world);
    bool is_mirrored = determinant(linear) < 0.0;
    mat3 scaled = scaled_to_one(linear);
    // The inverse transpose up to a positive factor.
    mat3 cofactors = mat3(cross(scaled[1], scaled[2]), cross(scaled[2], scaled[0]), cross(scaled[0], scaled[1]));
    float side = is_mirrored ? -1.0 : 1.0;
    vec3 normal = unit_or_zero(side * (cofactors * unit_or_zero(rest.normal)));
    vec3 tangent = unit_or_zero(scaled * rest.tangent.xyz);
    return Placed(position, normal, vec4(tangent, side * rest.tangent.w), is_mirrored && body.joints_per_vertex == 0u);
}

vec3 face_normal(uvec3 corners, MovingBody body) {
    vec3 a = placed(corners.x, body).position;
    vec3 normal = unit_or_zero(cross(placed(corners.y, body).position - a, placed(corners.z, body).position - a));
    return normal == vec3(0.0) ? vec3(0.0, 0.0, 1.0) : normal;
}

// Zero where it has no direction.
uint pack_tangent(vec4 tangent) {
    if (tangent.xyz == vec3(0.0)) {
        return NO_TANGENT;
    }
    vec2 place = octahedral_place(tangent.xyz);
    uint x = uint(int(round(place.x * float(MOST_TANGENT_X)))) & (TANGENT_SIDE - 1u);
    return x | (tangent.w < 0.0 ? TANGENT_SIDE : 0u) | (packSnorm2x16(place) & 0xffff0000u);
}

void main() {
    uint vertex = linear_thread();
    if (vertex >= vertex_count) {
        return;
    }
    uint body_index = rest_vertices[vertex].body;
    MovingBody body = moving_bodies[body_index];
    Placed own = placed(vertex, body);
    // Triangles without area are in no picture, and no ray hits them.
    bool is_shown = pose[body_index] != 0u;
    vec3 position = is_shown ? own.position : placed(body.first_rest, body).position;
    position = mix(clamp(position, -float(MOST_METRES), float(MOST_METRES)), vec3(0.0), is_no_number(position));
    vec3 normal = own.normal;
    if (normal == vec3(0.0)) {
        bool is_flat = (body.flags & BODY_IS_FLAT) != 0u;
        bool is_turned = (body.flags & BODY_IS_TURNED) != 0u;
        normal = is_shown ? face_normal(rest_vertices[vertex].corners, body) : vec3(0.0, 0.0, 1.0);
        normal *= is_flat && own.is_mirrored != is_turned ? -1.0 : 1.0;
    }
    uint scene_vertex = body.first_vertex + vertex - body.first_rest;
    uint first = VERTEX_WORDS * scene_vertex;
    scene_vertices[first] = floatBitsToUint(position.x);
    scene_vertices[first + 1u] = floatBitsToUint(position.y);
    scene_vertices[first + 2u] = floatBitsToUint(position.z);
    scene_vertices[first + 3u] = pack_octahedral(normal);
    if ((body.flags & BODY_HAS_TANGENTS) != 0u) {
        scene_tangents[scene_vertex] = pack_tangent(own.tangent);
    }
}
