// Writes four words into each of the first texels of an image of words. One thread per texel.
#include "constants.glsl"
layout(local_size_x = WORKGROUP_SIZE) in;

layout(set = 0, binding = 0, rgba32ui) uniform writeonly uimage2D words;
layout(push_constant) uniform Push { uint count; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < count) {
        imageStore(words, ivec2(i % WORD_ROW_TEXELS, i / WORD_ROW_TEXELS), uvec4(4u * i) + uvec4(0u, 1u, 2u, 3u));
    }
}
