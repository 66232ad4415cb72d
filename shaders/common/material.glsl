// A material as shaders read it, and how its base colour's texture is read. Needs constants.glsl.
#include "shared/Material.glsl"

// Bits of the flags by which the texture is read otherwise than filtered and repeating.
const uint MATERIAL_SAMPLING = MATERIAL_NEAREST | (15u << MATERIAL_WRAP_SHIFT);

// The place in 0 to 1 that a coordinate is, beyond the edges of the texture too.
float wrapped(uint mode, float c) {
    return mode == WRAP_CLAMP ? clamp(c, 0.0, 1.0) : mode == WRAP_MIRROR ? 1.0 - abs(2.0 * fract(0.5 * c) - 1.0) : fract(c);
}

vec2 wrapped_place(uint flags, vec2 uv) {
    uint modes = flags >> MATERIAL_WRAP_SHIFT;
    return vec2(wrapped(modes & 3u, uv.x), wrapped(modes >> 2u & 3u, uv.y));
}

// Where a layer of `size` texels, read by a sampler that filters and repeats, has what the material's own sampler would find.
vec2 place_in_layer(uint flags, vec2 uv, float size) {
    vec2 place = wrapped_place(flags, uv);
    if ((flags & MATERIAL_NEAREST) != 0u) {
        place = (min(floor(place * size), size - 1.0) + 0.5) / size;
    }
    // The texels at the other edge have no part in what is clamped or mirrored.
    uint modes = flags >> MATERIAL_WRAP_SHIFT;
    bvec2 repeats = equal(uvec2(modes & 3u, modes >> 2u & 3u), uvec2(WRAP_REPEAT));
    vec2 inside = clamp(place, 0.5 / size, 1.0 - 0.5 / size);
    return mix(inside, place, repeats);
}
