// Makes a mip level from the one before: each texel the sum of four.
#extension GL_EXT_samplerless_texture_functions : require
layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0) uniform utexture2D finer_level;
layout(set = 0, binding = 1, r32ui) uniform writeonly uimage2D out_level;

void main() {
    ivec2 place = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(place, imageSize(out_level)))) {
        return;
    }
    ivec2 last = textureSize(finer_level, 0) - 1;
    uint sum = 0u;
    for (int i = 0; i < 4; i++) {
        sum += texelFetch(finer_level, min(2 * place + ivec2(i & 1, i >> 1), last), 0).x;
    }
    imageStore(out_level, place, uvec4(sum));
}
