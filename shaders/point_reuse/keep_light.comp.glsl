// Of the sides that need a micro-buffer of their own, which had theirs in the frame before, at the same places: they keep
// its light. One thread per word of bits.
#include "common/frame.glsl"
#include "common/dispatch.glsl"
#ifndef MICRO_POINTS
#include "common/random.glsl"
#include "common/octahedral.glsl"
#include "common/micro_buffer.glsl"
#include "common/point_leaves.glsl"
#include "common/seen_places.glsl"
#endif
#include "common/kept_slots.glsl"
#include "shared/PointCounts.glsl"

layout(local_size_x = WORKGROUP_SIZE) in;
layout(set = 0, binding = 3, std430) buffer Counts { PointCounts point_counts; };
layout(set = 0, binding = 4, std430) readonly buffer NeededBits { uint needed_bits[]; };
layout(set = 0, binding = 5, std430) readonly buffer PreviousLitBits { uint previous_lit_bits[]; };
// What has light of its own after this frame.
layout(set = 0, binding = 6, std430) writeonly buffer LitBits { uint lit_bits[]; };
// What of it must be computed.
layout(set = 0, binding = 7, std430) writeonly buffer UnlitBits { uint unlit_bits[]; };
layout(push_constant) uniform Push { uint word_count; };

#ifdef MICRO_POINTS
// Light depends on the side alone.
bool stands(uint key) { return true; }
#else
layout(set = 0, binding = 8, std430) readonly buffer SeenTexels { uvec4 seen_texels[]; };
layout(set = 0, binding = 9, std430) readonly buffer PreviousSeenTexels { uvec4 previous_seen_texels[]; };
layout(set = 0, binding = 11, std430) readonly buffer KeptSlots { uint kept_slots[]; };

// A texel as the frame before had it; of a point that was not there another one than any.
uint previous_word(uint word) {
    if (word == NO_LEAF) {
        return NO_LEAF;
    }
    uint texel = unpack_texel(word);
    uint kept = kept_slots[texel / PRIMARY_TEXELS];
    return kept == NOT_KEPT ? NO_LEAF - 1u : word - texel + PRIMARY_TEXELS * kept + texel % PRIMARY_TEXELS;
}

// Whether the places that it is lit at are those of the frame before.
bool stands(uint key) {
    uvec4 now = seen_texels[key];
    uvec4 before = previous_seen_texels[key];
    bool is_same = true;
    for (uint i = 0u; i < POINT_LEAVES; ++i) {
        is_same = is_same && previous_word(now[i]) == before[i];
    }
    return is_same;
}
#endif

void main() {
    uint word = linear_thread();
    if (word >= word_count) {
        return;
    }
    uint needed = needed_bits[word];
    uint kept = 0u;
    for (uint left = frame.scene_stands != 0u ? needed & previous_lit_bits[word] : 0u; left != 0u; left &= left - 1u) {
        uint bit = uint(findLSB(left));
        kept |= stands(32u * word + bit) ? 1u << bit : 0u;
    }
    lit_bits[word] = needed;
    unlit_bits[word] = needed & ~kept;
    if (kept != 0u) {
        atomicAdd(point_counts.needed_kept, uint(bitCount(kept)));
    }
}
