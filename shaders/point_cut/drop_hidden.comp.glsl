// Takes sides of which the eye sees no leaf out of the cut: their spheres meet the picture, and yet what they hold lies
// behind other surfaces. One thread per side.
#include "common/frame.glsl"
#include "common/dispatch.glsl"
#include "common/random.glsl"
#include "common/octahedral.glsl"
#include "common/scene.glsl"
#include "common/eye_rays.glsl"
#include "common/micro_buffer.glsl"
#include "common/point_leaves.glsl"
#include "common/leaf_sight.glsl"

layout(local_size_x = WORKGROUP_SIZE) in;
layout(set = 0, binding = 3, std430) buffer PrimaryBits { uint primary_bits[]; };

bool shows_a_leaf(uint key) {
    for (uint i = 0u; i < LEAF_CANDIDATES; ++i) {
        if (is_in_sight(place_of_leaf_key(leaf_candidate(key, i)))) {
            return true;
        }
    }
    return false;
}

void main() {
    uint key = linear_thread();
    if (key >= 4u * frame.point_leaf_count) {
        return;
    }
    uint bit = 1u << (key & 31u);
    if ((primary_bits[key >> 5u] & bit) != 0u && !shows_a_leaf(key)) {
        atomicAnd(primary_bits[key >> 5u], ~bit);
    }
}
