// Where words lie in an image of them, four in a texel. Needs constants.glsl.
#ifndef WORDS_GLSL
#define WORDS_GLSL
#extension GL_EXT_samplerless_texture_functions : require

ivec2 texel_place(uint i) {
    return ivec2(i % WORD_ROW_TEXELS, i / WORD_ROW_TEXELS);
}
#endif
