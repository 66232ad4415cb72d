// k independent reservoirs per pixel (section 3.3): a light is kept with probability f / sum of f.
// Needs frame.glsl and random.glsl. One of RESERVOIR_{NONE,RACE,LOCK,EXACT} is defined.

#if defined(RESERVOIR_EXACT)
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_shader_atomic_int64 : require
// Order-independent: per pixel k words of (key, light); the smallest key wins.
layout(set = 0, binding = RESERVOIR_BINDING, std430) buffer Reservoirs { uint64_t reservoirs[]; };
#elif !defined(RESERVOIR_NONE)
// Per pixel: lock, running total of f, k light indices.
layout(set = 0, binding = RESERVOIR_BINDING, std430) coherent buffer Reservoirs { uint reservoirs[]; };
#endif

#if defined(RESERVOIR_RACE) || defined(RESERVOIR_LOCK)
void stream_into(uint base, uint light, float f, uint stream) {
    float total = uintBitsToFloat(reservoirs[base + 1u]) + f;
    reservoirs[base + 1u] = floatBitsToUint(total);
    for (uint i = 0u; i < shadow_sample_count(); ++i) {
        if (unit_float(hash(stream + i * 0x9e3779b9u)) * total < f) {
            reservoirs[base + 2u + i] = light;
        }
    }
}
#endif

// Offers a light with weight f > 0 to every reservoir of a pixel.
void update_reservoirs(uint pixel_index, uint light, float f) {
    uint stream = hash(light, pixel_index, sampling_seed());
#if defined(RESERVOIR_EXACT)
    uint base = pixel_index * shadow_sample_count();
    for (uint i = 0u; i < shadow_sample_count(); ++i) {
        atomicMin(reservoirs[base + i], (uint64_t(floatBitsToUint(race_key(stream, i, f))) << 32) | uint64_t(light));
    }
#elif defined(RESERVOIR_RACE)
    stream_into(pixel_index * (shadow_sample_count() + 2u), light, f, stream);
#elif defined(RESERVOIR_LOCK)
    uint base = pixel_index * (shadow_sample_count() + 2u);
    for (bool done = false; !done;) {
        if (atomicCompSwap(reservoirs[base], 0u, 1u) == 0u) {
            stream_into(base, light, f, stream);
            memoryBarrierBuffer();
            atomicExchange(reservoirs[base], 0u);
            done = true;
        }
    }
#endif
}
