// One level of the sides that lend their light to those above, because they lie under a primary point, because they are seen
// and will be lit, or because both children do; and of those that need a micro-buffer of their own, because they are seen and
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
layout(set = 0, binding = 8, std430) readonly buffer BorrowedBits { uint borrowed_bits[]; };
layout(push_constant) uniform Push { uint first_word; uint word_count; uint is_leaf_level; };
// With 0 what lies under primary points does not help the levels above, as in the paper, which looks upwards first.
layout(constant_id = 0) const uint UNDER_IS_KNOWN = 1u;
// With 1 sides that are seen, and of which one child lends its light, borrow that.
layout(constant_id = 1) const uint BORROWS = 1u;

#include "point_selection/side_bits.glsl"

// Sides of which both children are known, and those of which either is and neither borrows from them.
struct Children {
    uint both;
    uint either;
};

Children children_of(uint word) {
    uint turned = turned_bits[word];
    uint low = turned & 0xffffu;
    uint high = turned >> 16u;
    uvec2 known = uvec2(known_bits[2u * word], known_bits[2u * word + 1u]);
    uvec2 borrowed = uvec2(borrowed_bits[2u * word], borrowed_bits[2u * word + 1u]);
    uint lending = sides_of_either(borrowed.x, low) | sides_of_either(borrowed.y, high) << 16u;
    return Children(
        sides_of_both(known.x, low) | sides_of_both(known.y, high) << 16u,
        (sides_of_either(known.x, low) | sides_of_either(known.y, high) << 16u) & ~lending);
}

// What follows for a word.
struct Found {
    // Light that those above can take.
    uint known;
    // Light that follows from the children's.
    uint derived;
    uint needed;
};

Found decide(uint word, Children children) {
    uint under = under_bits[word];
    uint seen = seen_bits[word];
    uint borrowed = borrowed_bits[word];
    uint borrowing = BORROWS != 0u ? seen & children.either & ~(under | borrowed | children.both) : 0u;
    uint following = children.both | borrowing;
    return Found(
        (seen & ~(borrowed | borrowing)) | children.both | (UNDER_IS_KNOWN != 0u ? under : 0u),
        following & ~under,
        seen & ~(under | following | borrowed));
}

void write_word(uint word, Found found) {
    known_bits[word] = found.known;
    derived_bits[word] = found.derived;
    needed_bits[word] = found.needed;
    uint seen = seen_bits[word];
    if (seen != 0u) {
        atomicAdd(counts.seen_count, uint(bitCount(seen)));
    }
}

// Word 0, from the lowest of its levels up.
void write_first_levels() {
    Children children = Children(0u, 0u);
    Found found = decide(0u, children);
    for (uint key = 31u; key >= 2u; --key) {
        uint first_child = key >> 1u << 1u;
        uint known_count = 0u;
        uint borrowed_count = 0u;
        for (uint child = first_child; child < first_child + 2u; ++child) {
            uint child_key = child << 1u | ((key & 1u) ^ (turned_bits[0] >> child & 1u));
            uint word = child_key >> 5u;
            known_count += (word == 0u ? found.known : known_bits[word]) >> (child_key & 31u) & 1u;
            borrowed_count += borrowed_bits[word] >> (child_key & 31u) & 1u;
        }
        children.both |= known_count == 2u ? 1u << key : 0u;
        children.either |= known_count > 0u && borrowed_count == 0u ? 1u << key : 0u;
        found = decide(0u, children);
    }
    write_word(0u, found);
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
        write_word(word, decide(word, is_leaf_level == 0u ? children_of(word) : Children(0u, 0u)));
    }
}
