// First of two steps of the exclusive prefix sum of set bits: the sum of each block of block_chunk_count * SCAN_CHUNK
// words. One workgroup per block. Reduce-then-scan, which needs no forward-progress guarantee.
#include "constants.glsl"
#include "common/dispatch.glsl"
layout(local_size_x = WORKGROUP_SIZE) in;
layout(set = 0, binding = 1, std430) readonly buffer Bits { uint bits[]; };
layout(set = 0, binding = 2, std430) writeonly buffer BlockSums { uint block_sums[]; };
// The words [first_word, first_word + word_count) are scanned.
#include "exclusive_scan/value.glsl"

layout(push_constant) uniform Push { uint first_word; uint word_count; uint block_chunk_count; };

shared uint partial[WORKGROUP_SIZE];

void main() {
    uint lane = gl_LocalInvocationID.x;
    uint block_words = block_chunk_count * SCAN_CHUNK;
    uint first = linear_group() * block_words;
    uint sum = 0u;
    for (uint i = lane; i < block_words; i += WORKGROUP_SIZE) {
        sum += first + i < word_count ? value_of(first_word + first + i) : 0u;
    }
    partial[lane] = sum;
    barrier();
    for (uint stride = WORKGROUP_SIZE / 2u; stride > 0u; stride /= 2u) {
        if (lane < stride) {
            partial[lane] += partial[lane + stride];
        }
        barrier();
    }
    if (lane == 0u && first < word_count) {
        block_sums[linear_group()] = partial[0];
    }
}
