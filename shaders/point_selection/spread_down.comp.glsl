// One level of the sides that are primary points or lie under one, and of those that are seen and borrow the light of their
// parent or of its parent, which is seen too and does not borrow itself; the first level has all those of word 0. One thread
// per word of the level.
#include "constants.glsl"
#include "common/dispatch.glsl"
layout(local_size_x = WORKGROUP_SIZE) in;

layout(set = 0, binding = 1, std430) readonly buffer TurnedBits { uint turned_bits[]; };
layout(set = 0, binding = 2, std430) readonly buffer PrimaryBits { uint primary_bits[]; };
layout(set = 0, binding = 3, std430) buffer UnderBits { uint under_bits[]; };
layout(set = 0, binding = 4, std430) readonly buffer SeenBits { uint seen_bits[]; };
layout(set = 0, binding = 5, std430) buffer BorrowedBits { uint borrowed_bits[]; };
layout(push_constant) uniform Push { uint first_word; uint word_count; };
layout(constant_id = 0) const uint BORROWS = 1u;

#include "point_selection/side_bits.glsl"

void write_word(uint word, uint under, uint borrowed) {
    under_bits[word] = under;
    borrowed_bits[word] = BORROWS != 0u ? borrowed : 0u;
}

// Word 0, from the root down.
void write_first_levels() {
    uint under = primary_bits[0];
    uint borrowed = 0u;
    for (uint key = 4u; key < 32u; ++key) {
        uint turned = turned_bits[0] >> (key >> 1u) & 1u;
        uint parent = (key >> 2u) << 1u | ((key & 1u) ^ turned);
        under |= (under >> parent & 1u) << key;
        uint turned_parent = turned_bits[0] >> (parent >> 1u) & 1u;
        uint above_parent = (parent >> 2u) << 1u | ((parent & 1u) ^ turned_parent);
        uint lends = seen_bits[0] & ~under & ~borrowed;
        borrowed |= ((lends >> parent | lends >> above_parent) & lends >> key & 1u) << key;
    }
    write_word(0u, under, borrowed);
}

// Sides whose light those below may borrow.
uint lending(uint word) { return seen_bits[word] & ~under_bits[word] & ~borrowed_bits[word]; }

// The half of a word that a word of the next level lies below.
uint half_above(uint sides, uint word) { return sides >> (16u * (word & 1u)) & 0xffffu; }

void main() {
    uint thread = linear_thread();
    if (thread >= word_count) {
        return;
    }
    uint word = first_word + thread;
    if (word == 0u) {
        write_first_levels();
        return;
    }
    uint above = word >> 1u;
    uint turned = turned_of_word(word);
    uint under = primary_bits[word] | sides_of_children(half_above(under_bits[above], word), turned);
    uint lends = lending(above) | sides_of_children(half_above(lending(above >> 1u), above), turned_of_word(above));
    write_word(word, under, seen_bits[word] & ~under & sides_of_children(half_above(lends, word), turned));
}
