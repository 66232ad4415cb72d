// Second step: ranks[word] = number of set bits before that word in the scanned range. One workgroup per block, which
// adds up the sums of the blocks before its own: there are at most SCAN_MAX_BLOCKS.
#include "constants.glsl"
#include "common/dispatch.glsl"
#include "exclusive_scan/workgroup_scan.glsl"
layout(local_size_x = WORKGROUP_SIZE) in;
layout(set = 0, binding = 1, std430) readonly buffer Bits { uint bits[]; };
layout(set = 0, binding = 2, std430) readonly buffer BlockSums { uint block_sums[]; };
layout(set = 0, binding = 3, std430) writeonly buffer Ranks { uint ranks[]; };
#include "exclusive_scan/value.glsl"

layout(push_constant) uniform Push { uint first_word; uint word_count; uint block_chunk_count; };

const uint WORDS_PER_LANE = SCAN_CHUNK / WORKGROUP_SIZE;

uint sum_of_blocks_before(uint block, uint lane) {
    uint sum = 0u;
    for (uint i = lane; i < block; i += WORKGROUP_SIZE) {
        sum += block_sums[i];
    }
    uint total;
    workgroup_exclusive_scan(lane, sum, total);
    return total;
}

void main() {
    uint lane = gl_LocalInvocationID.x;
    uint block_words = block_chunk_count * SCAN_CHUNK;
    uint block_count = (word_count + block_words - 1u) / block_words;
    uint block = min(linear_group(), block_count);
    uint before = sum_of_blocks_before(block, lane);
    for (uint chunk = 0u; chunk < block_chunk_count; ++chunk) {
        uint first = block * block_words + chunk * SCAN_CHUNK + lane * WORDS_PER_LANE;
        uint words[WORDS_PER_LANE];
        uint sum = 0u;
        for (uint i = 0u; i < WORDS_PER_LANE; ++i) {
            words[i] = first + i < word_count ? value_of(first_word + first + i) : 0u;
            sum += words[i];
        }
        uint total;
        uint rank = before + workgroup_exclusive_scan(lane, sum, total);
        for (uint i = 0u; i < WORDS_PER_LANE; ++i) {
            if (first + i < word_count) {
                ranks[first_word + first + i] = rank;
            }
            rank += words[i];
        }
        before += total;
    }
    // One past the last word: the number of all set bits.
    if (lane == 0u && block + 1u == max(block_count, 1u)) {
        ranks[first_word + word_count] = before;
    }
}
