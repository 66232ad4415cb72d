// From exposed linear radiance, Rec. 709, to linear display values. Twins: cpu::tone_map.
#include "common/srgb.glsl"

vec3 reinhard(vec3 color) { return color / (1.0 + color); }

// AgX by Troy Sobotka, as Filament has it after Blender: the primaries of Rec. 2020 drawn towards white (inset), a
// sigmoid over 16.5 stops of log2 about middle grey, and the inset undone. The polynomial is Benjamin Wrensch's fit of
// the sigmoid (https://iolite-engine.com/blog_posts/minimal_agx_implementation), matrices and order those of
// three.js and Filament (https://github.com/google/filament/pull/7236). Matrices are written by columns.
const mat3 REC2020_FROM_REC709 =
    mat3(0.6274, 0.0691, 0.0164, 0.3293, 0.9195, 0.0880, 0.0433, 0.0113, 0.8956);
const mat3 REC709_FROM_REC2020 =
    mat3(1.6605, -0.1246, -0.0182, -0.5876, 1.1329, -0.1006, -0.0728, -0.0083, 1.1187);
const mat3 AGX_INSET = mat3(
    0.856627153315983, 0.137318972929847, 0.11189821299995,
    0.0951212405381588, 0.761241990602591, 0.0767994186031903,
    0.0482516061458583, 0.101439036467562, 0.811302368396859);
const mat3 AGX_OUTSET = mat3(
    1.1271005818144368, -0.1413297634984383, -0.14132976349843826,
    -0.11060664309660323, 1.157823702216272, -0.11060664309660294,
    -0.016493938717834573, -0.016493938717834257, 1.2519364065950405);
// log2 of middle grey 10 stops down and 6.5 stops up.
const float AGX_LOWEST = -12.47393;
const float AGX_HIGHEST = 4.026069;

vec3 agx_sigmoid(vec3 x) {
    return -0.00232 + x * (0.1191 + x * (0.4298 + x * (-6.868 + x * (31.96 + x * (-40.14 + x * 15.5)))));
}

vec3 agx(vec3 color) {
    vec3 inset = AGX_INSET * (REC2020_FROM_REC709 * color);
    vec3 stops = (log2(max(inset, vec3(1e-10))) - AGX_LOWEST) / (AGX_HIGHEST - AGX_LOWEST);
    vec3 encoded = AGX_OUTSET * agx_sigmoid(clamp(stops, vec3(0.0), vec3(1.0)));
    return REC709_FROM_REC2020 * pow(max(encoded, vec3(0.0)), vec3(2.2));
}

// Khronos PBR Neutral, as published (https://github.com/KhronosGroup/ToneMapping): what a surface of 4 % specular
// reflection adds is taken off, and from 0.76 on the largest channel is compressed below 1, fading to white.
vec3 neutral(vec3 color) {
    const float START = 0.8 - 0.04;
    const float DESATURATION = 0.15;
    float least = min(color.r, min(color.g, color.b));
    color -= least < 0.08 ? least - 6.25 * least * least : 0.04;
    float peak = max(color.r, max(color.g, color.b));
    if (peak < START) {
        return color;
    }
    float rest = 1.0 - START;
    float compressed = 1.0 - rest * rest / (peak + rest - START);
    float kept = 1.0 / (DESATURATION * (peak - compressed) + 1.0);
    return mix(vec3(compressed), color * (compressed / peak), kept);
}

// The most that is told apart: beyond, a sum of channels could overflow. Every curve is white far below.
const float BRIGHTEST = 1e30;

// Radiance as a display shows it: exposed, by one of TONE_MAP_*, sRGB-encoded.
vec3 tone_mapped(vec3 radiance, float exposure_factor, uint tone_map) {
    vec3 exposed = clamp(radiance * exposure_factor, vec3(0.0), vec3(BRIGHTEST));
    vec3 shown = tone_map == TONE_MAP_AGX ? agx(exposed) : tone_map == TONE_MAP_NEUTRAL ? neutral(exposed) : reinhard(exposed);
    return srgb_encode(clamp(shown, vec3(0.0), vec3(1.0)));
}
