// Adds the moments of one light to its eight surrounding vertices of a level, by atomic additions. The includer declares `moments`;
// needs occupancy.glsl and moments.glsl.

void add_moment(uint record, uint moment, float value) {
    uvec2 words = fixed_from_float(value);
    uint index = record * MOMENT_WORDS + 2u * moment;
    uint carry = 0u;
    if (words.x != 0u) {
        uint before = atomicAdd(moments[index], words.x);
        carry = before + words.x < before ? 1u : 0u;
    }
    if (words.y + carry != 0u) {
        atomicAdd(moments[index + 1u], words.y + carry);
    }
}

// `sign` is -1 where the light was added before and is to be taken away. Vertices that there are none of are left out.
void add_light(uvec4 position_normal, vec4 flux, uint level, float sign) {
    ScaledLight light = scaled_light(position_normal, flux, level);
    uvec3 cell = cell_of(light.cells, level);
    vec3 fraction = light.cells - vec3(cell);
    for (uint i = 0u; i < 8u; ++i) {
        uvec3 corner = uvec3(i & 1u, (i >> 1u) & 1u, i >> 2u);
        float weight = vertex_share(fraction, corner);
        uint record = grid_light_at(cell + corner, level);
        if (record != NO_LIGHT && weight > 0.0) {
            float[MOMENTS] terms = moments_of(light, weight, fraction - vec3(corner));
            for (uint moment = 0u; moment < MOMENTS; ++moment) {
                add_moment(record, moment, sign * terms[moment]);
            }
        }
    }
}
