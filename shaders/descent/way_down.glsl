// From a grid light down to one of the lights S0 that it is made of, and what that counts for in its place. Needs lights.glsl,
// original_lights.glsl, level_table.glsl, descent/tables.glsl and descent/representatives.glsl; the includer declares `descent`,
// `representatives`, `light_positions`, `light_fluxes` and `index_bits`.

// Bounds what one sample may count for: a finer light can lie much nearer than the light it stands for.
const float MAX_RESPONSE_RATIO = 16.0;

// The S1 light that grid light `index` hands a ray to: at every level a part with a probability proportional to
// its luminance. NO_LIGHT where there are more lights than tables, whose number was measured under another sun.
uint descend(uint index, uint level, inout uint random_state) {
    for (; level > 1u; --level) {
        uint table = descent_table(index, level_first(2u));
        if (table + DESCENT_STRIDE > uint(descent.length())) {
            return NO_LIGHT;
        }
        uint parts = min(descent[table], DESCENT_PARTS);
        if (parts == 0u) {
            return NO_LIGHT;
        }
        float target = random(random_state) * uintBitsToFloat(descent[table + 2u * parts]);
        uint part = 0u;
        // The first part whose cumulative luminance is above the target, by halving what it may be among.
        for (uint last = parts - 1u; part < last;) {
            uint middle = (part + last) / 2u;
            if (uintBitsToFloat(descent[table + 2u + 2u * middle]) > target) {
                last = middle;
            } else {
                part = middle + 1u;
            }
        }
        index = descent[table + 3u + 2u * part];
    }
    return index;
}

// Where a ray ends: a point that sends light.
struct Sender {
    vec3 position_ws;
    vec3 lobe;
    vec3 flux;
    uint level;
};

// The representative that a list of them has at a place.
uint representative_at(uint index) {
#ifdef ROUND
    if (frame.history_is_valid == 0u) {
        return round_representatives[index];
    }
#endif
    return representatives[index];
}

// A light of S0 that grid light `index` is made of, or NO_LIGHT where the way down to one is lost. Level 0 has the lights
// themselves.
uint original_below(uint index, uint level, inout uint random_state) {
    if (level == 0u) {
        return index;
    }
    uint s1 = descend(index, level, random_state);
    if (s1 == NO_LIGHT) {
        return NO_LIGHT;
    }
    uint r = min(uint(random(random_state) * float(REPRESENTATIVES)), REPRESENTATIVES - 1u);
    uint representative = representative_at(s1 * REPRESENTATIVES + r);
    return representative == NO_LIGHT ? NO_LIGHT : representative & index_mask(index_bits);
}

Sender original_sender(uint light) {
    uvec4 position_normal = light_positions[light];
    vec4 flux = light_fluxes[light];
    vec3 lobe = original_lobe(position_normal, flux);
    return Sender(uintBitsToFloat(position_normal.xyz), lobe, flux.rgb, 0u);
}

// What a sender sends to a surface per unit of flux.
float sent_response(Sender sender, vec3 position_ws, vec3 normal) {
    vec3 offset = sender.position_ws - position_ws;
    return light_response(offset, length(offset), normal, sender.lobe, sender.level, luminance(sender.flux));
}

// What the light was chosen for that a sender stands for.
float expected_response(GridLight chosen, vec3 position_ws, vec3 normal) {
    vec3 offset = chosen.position_ws - position_ws;
    return light_response(offset, length(offset), normal, chosen.lobe, chosen.level, own_luminance(chosen));
}

// What a sample counts for, whose light was expected to send something else.
float stand_in_ratio(float response, float expected) { return min(response / max(expected, 1e-30), MAX_RESPONSE_RATIO); }
