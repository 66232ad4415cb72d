// Surfaces that shine by themselves as lights: points on them, drawn by how much their triangles shine. Needs frame.glsl,
// random.glsl (PI) and scene.glsl. Rust: scene::emitters.
#include "common/light_rays.glsl"
#include "common/search.glsl"
#include "shared/Emitter.glsl"

// frame.emitter_count of them; first comes the probability of those before each.
layout(set = 1, binding = 11, std430) readonly buffer Emitters { Emitter emitters[]; };

bool has_emitters() { return frame.emitter_count > 0u; }

float emitter_start(uint i) { return emitters[i].first; }

DEFINE_INTERVAL_SEARCH(emitter_interval, emitter_start)

// A point on a surface that shines.
struct EmitterPoint {
    vec3 position_ws;
    // Of the front, which alone shines unless the surface has two sides.
    vec3 normal;
    float sides;
    vec3 radiance;
    // Probability per square metre with which it is drawn.
    float density;
};

vec3 vertex_position(uint vertex) {
    uint first = VERTEX_WORDS * vertex;
    return vec3(
        uintBitsToFloat(scene_vertices[first]),
        uintBitsToFloat(scene_vertices[first + 1u]),
        uintBitsToFloat(scene_vertices[first + 2u]));
}

// The point of two numbers: the first says on which triangle, and both where on it, any place as likely as another. Where
// triangles move, their area is that of the moment.
EmitterPoint sample_emitter(vec2 u) {
    Emitter emitter = emitters[emitter_interval(0u, frame.emitter_count, u.x)];
    float root = sqrt(clamp((u.x - emitter.first) / emitter.probability, 0.0, 1.0));
    vec2 barycentric = vec2(root * (1.0 - u.y), root * u.y);
    uint corner = 3u * emitter.triangle;
    vec3 origin = vertex_position(scene_indices[corner]);
    vec3 edge1 = vertex_position(scene_indices[corner + 1u]) - origin;
    vec3 edge2 = vertex_position(scene_indices[corner + 2u]) - origin;
    vec3 across = cross(edge1, edge2);
    float twice_area = max(length(across), 1e-30);
    vec3 position_ws = origin + edge1 * barycentric.x + edge2 * barycentric.y;
    vec3 radiance = emission_at(emitter.material, emitter.triangle, barycentric);
    float sides = (materials[emitter.material].flags & MATERIAL_SINGLE_SIDED) != 0u ? 1.0 : 2.0;
    return EmitterPoint(position_ws, across / twice_area, sides, radiance, 2.0 * emitter.probability / twice_area);
}

// What a point on a surface that shines sends to a receiver without anything between, as an estimate of what all of them send:
// irradiance.
vec3 unshadowed_irradiance_from(EmitterPoint point, vec3 position, vec3 normal, vec3 geometric) {
    vec3 offset = point.position_ws - position;
    float distance_squared = max(dot(offset, offset), 1e-30);
    vec3 direction = offset * inversesqrt(distance_squared);
    float leaves = -dot(point.normal, direction);
    leaves = point.sides > 1.0 ? abs(leaves) : max(leaves, 0.0);
    float arrives = dot(geometric, direction) > 0.0 ? max(dot(normal, direction), 0.0) : 0.0;
    return point.radiance * (leaves * arrives / (distance_squared * point.density));
}

// Whether something stands between a point on a surface that shines and where rays leave the receiver.
bool is_emitter_blocked(EmitterPoint point, vec3 origin) {
    vec3 shining_side = dot(origin - point.position_ws, point.normal) < 0.0 ? -point.normal : point.normal;
    return is_light_blocked(origin, point.position_ws, shining_side);
}

// An estimate of the irradiance from all surfaces that shine, by the point of two numbers and a shadow ray.
vec3 emitter_irradiance(vec3 position, vec3 normal, vec3 geometric, vec3 origin, vec2 u) {
    EmitterPoint point = sample_emitter(u);
    vec3 irradiance = unshadowed_irradiance_from(point, position, normal, geometric);
    return any(greaterThan(irradiance, vec3(0.0))) && !is_emitter_blocked(point, origin) ? irradiance : vec3(0.0);
}
