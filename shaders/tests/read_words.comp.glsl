// Copies the first texels of an image of words into a buffer. One thread per texel.
#include "constants.glsl"
#extension GL_EXT_samplerless_texture_functions : require
layout(local_size_x = WORKGROUP_SIZE) in;

layout(set = 0, binding = 0) uniform utexture2D words;
layout(set = 0, binding = 1, std430) writeonly buffer Seen { uvec4 seen[]; };
layout(push_constant) uniform Push { uint count; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < count) {
        seen[i] = texelFetch(words, ivec2(i % WORD_ROW_TEXELS, i / WORD_ROW_TEXELS), 0);
    }
}
