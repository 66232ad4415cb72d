// Counts frames: adds one to what the frame before left, in a buffer and in the texel of an image.
#extension GL_EXT_samplerless_texture_functions : require
layout(local_size_x = 1) in;

layout(set = 0, binding = 0, std140) uniform Constants { uint history_valid; } constants;
layout(set = 0, binding = 1, std430) readonly buffer PreviousCount { uint frames; } previous_count;
layout(set = 0, binding = 2, std430) buffer Count { uint frames; } count;
layout(set = 0, binding = 3) uniform utexture2D previous_count_image;
layout(set = 0, binding = 4, r32ui) uniform writeonly uimage2D count_image;

void main() {
    bool valid = constants.history_valid != 0u;
    uint previous_texel = texelFetch(previous_count_image, ivec2(0), 0).x;
    count.frames = (valid ? previous_count.frames : 0u) + 1u;
    imageStore(count_image, ivec2(0), uvec4((valid ? previous_texel : 0u) + 1u));
}
