// Reading the reservoirs. Needs frame.glsl; RESERVOIR_BINDING is defined by the includer.
layout(set = 0, binding = RESERVOIR_BINDING, std430) readonly buffer Reservoirs { uint reservoirs[]; };
// 1: light and key per sample, two words each; 0: per pixel lock, total, and the light of each sample.
layout(constant_id = 2) const uint EXACT = 1u;

// The merged light in reservoir `i` of a pixel, or NO_LIGHT where it has stayed empty.
uint selected_light(uint pixel_index, uint i) {
    if (EXACT != 0u) {
        return reservoirs[2u * (pixel_index * shadow_sample_count() + i)];
    }
    uint base = pixel_index * (shadow_sample_count() + 2u);
    return reservoirs[base + 1u] == 0u ? NO_LIGHT : reservoirs[base + 2u + i];
}
