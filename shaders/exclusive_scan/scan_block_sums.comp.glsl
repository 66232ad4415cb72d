// Second step: exclusive prefix sum of the block sums, in place. One workgroup, any number of blocks.
#include "constants.glsl"
#include "exclusive_scan/workgroup_scan.glsl"
layout(local_size_x = WORKGROUP_SIZE) in;
layout(set = 0, binding = 1, std430) buffer BlockSums { uint block_sums[]; };
layout(set = 0, binding = 2, std430) writeonly buffer Ranks { uint ranks[]; };
layout(push_constant) uniform Push { uint first_word; uint word_count; };

void main() {
    uint lane = gl_LocalInvocationID.x;
    uint block_count = (word_count + SCAN_BLOCK - 1u) / SCAN_BLOCK;
    uint carry = 0u;
    for (uint first = 0u; first < block_count; first += WORKGROUP_SIZE) {
        uint block = first + lane;
        uint value = block < block_count ? block_sums[block] : 0u;
        uint total;
        uint before = workgroup_exclusive_scan(lane, value, total);
        if (block < block_count) {
            block_sums[block] = carry + before;
        }
        carry += total;
    }
    // One past the last word: the number of all set bits.
    if (lane == 0u) {
        ranks[first_word + word_count] = carry;
    }
}
