// One level of the sides that have light below, for whoever sees them although no primary point does: those that are lit or
// follow from their children lend their light, and what is left takes the mean of any child that lends. The last level has
// all those of word 0. One thread per word of the level.
#include "constants.glsl"
#include "common/dispatch.glsl"
layout(local_size_x = WORKGROUP_SIZE) in;

layout(set = 0, binding = 1, std430) readonly buffer TurnedBits { uint turned_bits[]; };
layout(set = 0, binding = 2, std430) readonly buffer UnderBits { uint under_bits[]; };
layout(set = 0, binding = 3, std430) readonly buffer PrimaryBits { uint primary_bits[]; };
layout(set = 0, binding = 4, std430) readonly buffer DerivedBits { uint derived_bits[]; };
layout(set = 0, binding = 5, std430) readonly buffer NeededBits { uint needed_bits[]; };
layout(set = 0, binding = 6, std430) readonly buffer BorrowedBits { uint borrowed_bits[]; };
// Sides that have light before it is copied downwards.
layout(set = 0, binding = 7, std430) buffer LendingBits { uint lending_bits[]; };
// Those of them whose light is the mean of those of their children that lend it.
layout(set = 0, binding = 8, std430) writeonly buffer AveragedBits { uint averaged_bits[]; };
layout(push_constant) uniform Push { uint first_word; uint word_count; uint is_leaf_level; };

#include "point_selection/side_bits.glsl"

uint lending_children(uint word) {
    uint turned = turned_bits[word];
    return sides_of_either(lending_bits[2u * word], turned & 0xffffu) |
           sides_of_either(lending_bits[2u * word + 1u], turned >> 16u) << 16u;
}

// Sides of a word that lend, by those of which a child does.
uint lending_sides(uint word, uint children) {
    uint own = primary_bits[word] | needed_bits[word] | derived_bits[word];
    return own | (children & ~(under_bits[word] | borrowed_bits[word]));
}

void write_word(uint word, uint lending) {
    lending_bits[word] = lending;
    averaged_bits[word] = lending & ~(primary_bits[word] | needed_bits[word]);
}

// Word 0, from the lowest of its levels up.
void write_first_levels() {
    uint children = 0u;
    uint lending = lending_sides(0u, children);
    for (uint key = 31u; key >= 2u; --key) {
        uint first_child = key >> 1u << 1u;
        for (uint child = first_child; child < first_child + 2u; ++child) {
            uint child_key = child << 1u | ((key & 1u) ^ (turned_bits[0] >> child & 1u));
            uint bits = child_key < 32u ? lending : lending_bits[1];
            children |= (bits >> (child_key & 31u) & 1u) << key;
        }
        lending = lending_sides(0u, children);
    }
    write_word(0u, lending);
}

void main() {
    uint thread = linear_thread();
    if (thread >= word_count) {
        return;
    }
    uint word = first_word + thread;
    if (word == 0u) {
        write_first_levels();
    } else {
        write_word(word, lending_sides(word, is_leaf_level == 0u ? lending_children(word) : 0u));
    }
}
