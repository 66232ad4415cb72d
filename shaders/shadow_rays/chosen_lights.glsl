// Reading the reservoirs that light_volumes has filled. Needs frame.glsl; RESERVOIR_BINDING and, for packed 64-bit
// keys, RESERVOIR_EXACT are defined by the includer.
#ifdef RESERVOIR_EXACT
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
layout(set = 0, binding = RESERVOIR_BINDING, std430) readonly buffer Reservoirs { uint64_t reservoirs[]; };
#else
layout(set = 0, binding = RESERVOIR_BINDING, std430) readonly buffer Reservoirs { uint reservoirs[]; };
#endif

// The merged light in reservoir `i` of a pixel, or NO_LIGHT where it has stayed empty.
uint selected_light(uint pixel_index, uint i) {
#ifdef RESERVOIR_EXACT
    return uint(reservoirs[pixel_index * shadow_sample_count() + i] & 0xfffffffful);
#else
    uint base = pixel_index * (shadow_sample_count() + 2u);
    return reservoirs[base + 1u] == 0u ? NO_LIGHT : reservoirs[base + 2u + i];
#endif
}
