// The sides whose light is known, those whose light follows from both children, and those that need a micro-buffer of their
// own, all in one dispatch (Harada 2014). One thread per leaf, which climbs for as long as it is the second to arrive at a
// node: both children are settled then. Nothing waits for anything, so no order of execution is assumed.
#include "common/frame.glsl"
#include "common/dispatch.glsl"
#include "shared/PointCounts.glsl"
layout(local_size_x = WORKGROUP_SIZE) in;

layout(set = 0, binding = 1, std430) readonly buffer TurnedBits { uint turned_bits[]; };
layout(set = 0, binding = 2, std430) readonly buffer UnderBits { uint under_bits[]; };
layout(set = 0, binding = 3, std430) readonly buffer SeenBits { uint seen_bits[]; };
layout(set = 0, binding = 4, std430) coherent buffer KnownBits { uint known_bits[]; };
layout(set = 0, binding = 5, std430) buffer DerivedBits { uint derived_bits[]; };
layout(set = 0, binding = 6, std430) buffer NeededBits { uint needed_bits[]; };
layout(set = 0, binding = 7, std430) buffer Counts { PointCounts counts; };
// Children of each inner node that are settled.
layout(set = 0, binding = 8, std430) coherent buffer Arrivals { uint arrivals[]; };

// A node has two sides, 16 nodes a word.
uint word_of(uint node) { return node >> 4u; }
uint shift_of(uint node) { return 2u * (node & 15u); }

uint swapped_if(bool turned, uint sides) { return turned ? (sides & 1u) << 1u | sides >> 1u : sides; }

// Sides of a node of which both children are known, as they were left by whoever settled them.
uint both_known(uint node) {
    // Two children begin at an even node: their turns lie in one word, and so do their sides.
    uint first = 2u * node;
    uint known = known_bits[word_of(first)] >> shift_of(first);
    uint turned = turned_bits[first >> 5u] >> (first & 31u);
    return swapped_if((turned & 1u) != 0u, known & 3u) & swapped_if((turned & 2u) != 0u, known >> 2u & 3u);
}

// Decides about a node, of which these sides have both children known.
void settle(uint node, uint both) {
    uint word = word_of(node);
    uint shift = shift_of(node);
    uint under = under_bits[word] >> shift & 3u;
    uint seen = seen_bits[word] >> shift & 3u;
    // Other threads write to the same words.
    atomicOr(known_bits[word], (seen | both | under) << shift);
    atomicOr(derived_bits[word], (both & ~under) << shift);
    atomicOr(needed_bits[word], (seen & ~(under | both)) << shift);
    if (seen != 0u) {
        atomicAdd(counts.seen_count, uint(bitCount(seen)));
    }
}

void main() {
    uint leaf = linear_thread();
    uint node = frame.point_leaf_count + leaf;
    bool is_climbing = leaf < frame.point_leaf_count;
    if (is_climbing) {
        settle(node, 0u);
    }
    // All threads take part in every round. lavapipe of Mesa 22.3 treats a memory barrier as one of the workgroup, and ends
    // those that wait there when others have left.
    for (uint above = frame.point_leaf_count >> 1u; above > 0u; above >>= 1u) {
        node >>= 1u;
        // What this thread has settled is there before its arrival counts, and what the first one has before it is read.
        memoryBarrierBuffer();
        if (is_climbing) {
            is_climbing = atomicAdd(arrivals[node], 1u) == 1u;
        }
        memoryBarrierBuffer();
        if (is_climbing) {
            settle(node, both_known(node));
        }
    }
}
