// Third step: ranks[word] = number of set bits before that word in the scanned range. One workgroup per block.
#include "constants.glsl"
#include "common/dispatch.glsl"
#include "exclusive_scan/workgroup_scan.glsl"
layout(local_size_x = WORKGROUP_SIZE) in;
layout(set = 0, binding = 1, std430) readonly buffer Bits { uint bits[]; };
layout(set = 0, binding = 2, std430) readonly buffer BlockSums { uint block_sums[]; };
layout(set = 0, binding = 3, std430) writeonly buffer Ranks { uint ranks[]; };
#include "exclusive_scan/value.glsl"

layout(push_constant) uniform Push { uint first_word; uint word_count; };

const uint WORDS_PER_LANE = SCAN_BLOCK / WORKGROUP_SIZE;

void main() {
    uint lane = gl_LocalInvocationID.x;
    uint first = linear_group() * SCAN_BLOCK + lane * WORDS_PER_LANE;
    uint words[WORDS_PER_LANE];
    uint sum = 0u;
    for (uint i = 0u; i < WORDS_PER_LANE; ++i) {
        words[i] = first + i < word_count ? value_of(first_word + first + i) : 0u;
        sum += words[i];
    }
    uint total;
    uint block = min(linear_group(), (word_count - 1u) / SCAN_BLOCK);
    uint rank = block_sums[block] + workgroup_exclusive_scan(lane, sum, total);
    for (uint i = 0u; i < WORDS_PER_LANE; ++i) {
        if (first + i < word_count) {
            ranks[first_word + first + i] = rank;
        }
        rank += words[i];
    }
}
