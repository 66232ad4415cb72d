// One level of the sides that are primary points or lie under one; the first level has all those of word 0. One thread per
// word of the level.
#include "constants.glsl"
#include "common/dispatch.glsl"
layout(local_size_x = WORKGROUP_SIZE) in;

layout(set = 0, binding = 1, std430) readonly buffer TurnedBits { uint turned_bits[]; };
layout(set = 0, binding = 2, std430) readonly buffer PrimaryBits { uint primary_bits[]; };
layout(set = 0, binding = 3, std430) buffer UnderBits { uint under_bits[]; };
layout(push_constant) uniform Push { uint first_word; uint word_count; };

#include "point_selection/side_bits.glsl"

// Word 0, from the root down.
uint first_levels() {
    uint under = primary_bits[0];
    for (uint key = 4u; key < 32u; ++key) {
        uint turned = turned_bits[0] >> (key >> 1u) & 1u;
        uint parent = (key >> 2u) << 1u | ((key & 1u) ^ turned);
        under |= (under >> parent & 1u) << key;
    }
    return under;
}

void main() {
    uint thread = linear_thread();
    if (thread >= word_count) {
        return;
    }
    uint word = first_word + thread;
    if (word == 0u) {
        under_bits[0] = first_levels();
        return;
    }
    uint parents = under_bits[word >> 1u] >> (16u * (word & 1u)) & 0xffffu;
    under_bits[word] = primary_bits[word] | sides_of_children(parents, turned_of_word(word));
}
