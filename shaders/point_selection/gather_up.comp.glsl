// One level of the sides whose light is known, because they lie under a primary point, because they are seen and will be
// lit, or because that of both children is; and of those that need a micro-buffer of their own, because they are seen and
// nothing else leads to their light. The last level has all those of word 0. One thread per word of the level.
#include "constants.glsl"
#include "common/dispatch.glsl"
#include "shared/PointCounts.glsl"
layout(local_size_x = WORKGROUP_SIZE) in;

layout(set = 0, binding = 1, std430) readonly buffer TurnedBits { uint turned_bits[]; };
layout(set = 0, binding = 2, std430) readonly buffer UnderBits { uint under_bits[]; };
layout(set = 0, binding = 3, std430) readonly buffer SeenBits { uint seen_bits[]; };
layout(set = 0, binding = 4, std430) buffer KnownBits { uint known_bits[]; };
layout(set = 0, binding = 5, std430) writeonly buffer DerivedBits { uint derived_bits[]; };
layout(set = 0, binding = 6, std430) writeonly buffer NeededBits { uint needed_bits[]; };
layout(set = 0, binding = 7, std430) buffer Counts { PointCounts counts; };
layout(push_constant) uniform Push { uint first_word; uint word_count; uint is_leaf_level; };
// With 0 what lies under primary points does not help the levels above, as in the paper, which looks upwards first.
layout(constant_id = 0) const uint UNDER_IS_KNOWN = 1u;

#include "point_selection/side_bits.glsl"

// Of a word, the sides both of whose children are known.
uint both_known(uint word) {
    uint turned = turned_bits[word];
    return sides_of_both(known_bits[2u * word], turned & 0xffffu) | sides_of_both(known_bits[2u * word + 1u], turned >> 16u) << 16u;
}

// Writes a word, of which these sides have both children known.
void write_word(uint word, uint both) {
    uint under = under_bits[word];
    uint seen = seen_bits[word];
    uint known = seen | both | (UNDER_IS_KNOWN != 0u ? under : 0u);
    known_bits[word] = known;
    derived_bits[word] = both & ~under;
    needed_bits[word] = seen & ~(under | both);
    if (seen != 0u) {
        atomicAdd(counts.seen_count, uint(bitCount(seen)));
    }
}

// Word 0: its sides of which both children are known, from the lowest level up.
uint both_known_of_first_levels() {
    uint known = seen_bits[0] | (UNDER_IS_KNOWN != 0u ? under_bits[0] : 0u);
    uint below = known_bits[1];
    uint turned = turned_bits[0];
    uint both = 0u;
    for (uint key = 31u; key >= 2u; --key) {
        uint first_child = key >> 1u << 1u;
        bool all = true;
        for (uint child = first_child; child < first_child + 2u; ++child) {
            uint child_key = child << 1u | ((key & 1u) ^ (turned >> child & 1u));
            uint word = child_key < 32u ? known : below;
            all = all && (word >> (child_key & 31u) & 1u) != 0u;
        }
        both |= all ? 1u << key : 0u;
        known |= both;
    }
    return both;
}

void main() {
    uint thread = linear_thread();
    if (thread >= word_count) {
        return;
    }
    uint word = first_word + thread;
    uint both = 0u;
    if (word == 0u) {
        both = both_known_of_first_levels();
    } else if (is_leaf_level == 0u) {
        both = both_known(word);
    }
    write_word(word, both);
}
