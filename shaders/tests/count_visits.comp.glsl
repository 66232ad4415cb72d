// Casts rays and counts the nodes of the BVH that each visits. One thread per ray. A test's shader.
#include "constants.glsl"
#include "common/octahedral.glsl"

uint visits = 0u;
#define ON_VISIT ++visits
#include "common/scene.glsl"

layout(local_size_x = 1) in;
struct TestRay {
    vec3 origin;
    float t_max;
    vec3 direction;
    uint any_hit;
};
layout(set = 0, binding = 0, std430) readonly buffer Rays { TestRay rays[]; };
// Visits, and 1 where the ray has hit.
layout(set = 0, binding = 1, std430) writeonly buffer Results { uvec2 results[]; };

void main() {
    uint index = gl_WorkGroupID.x;
    TestRay ray = rays[index];
    Hit hit;
    bool found = traverse(ray.origin, ray.direction, ray.t_max, ray.any_hit != 0u, hit);
    results[index] = uvec2(visits, uint(found));
}
