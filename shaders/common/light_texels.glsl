// The merged lights once more as texels of an image, for shaders that read very many of them: software devices fetch
// four words of a texel at once, but the words of a storage buffer one by one. LIGHT_TEXELS per light: centre and
// blending radius (alpha times the cell of its level), mean normal and luminance, flux and weight.
ivec2 light_texel(uint light, uint texel) {
    return ivec2((light % LIGHTS_PER_ROW) * LIGHT_TEXELS + texel, light / LIGHTS_PER_ROW);
}
