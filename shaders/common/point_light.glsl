// Light of the scene's suns, lamps and surfaces that shine at points, averaged over the places that a point is lit at. Needs
// scene.glsl, punctual.glsl, emitters.glsl, point_leaves.glsl and `PointPlace place_of_word(uint)`: where a point is lit by a word that is kept of it.

// Where the point of this workgroup is lit, best known first.
shared PointPlace lit_places[POINT_LEAVES];

// Finds the places by words of which smaller ones are preferred, NO_LEAF for none, and gives how many there are; without any
// it is that of the representative leaf. Called by all lanes.
uint find_lit_places(uvec4 words, uint key, uint lane) {
    uvec4 is_known = uvec4(notEqual(words, uvec4(NO_LEAF)));
    uint count = is_known.x + is_known.y + is_known.z + is_known.w;
    // A loop, as CPU drivers jump over loops that no invocation is in, and not over branches.
    for (uint i = lane; i < POINT_LEAVES; i += POINT_LANES) {
        uint word = words[i];
        uvec4 is_before = uvec4(lessThan(words, uvec4(word)));
        if (word != NO_LEAF) {
            lit_places[is_before.x + is_before.y + is_before.z + is_before.w] = place_of_word(word);
        }
    }
    for (uint i = lane; i < 1u - min(count, 1u); i += POINT_LANES) {
        lit_places[0] = place_of_leaf_key(leaf_key_of(NO_LEAF, key));
    }
    barrier();
    return max(count, 1u);
}

// Share of one lane, of so many, of the irradiance from all lights, from this many places.
vec3 lamp_irradiance(uint place_count, uint lane, uint lanes) {
    uint count = min(place_count, frame.sun_leaves);
    // Those among the lights of a hierarchy come last.
    uint lamps = frame.direct_lights - frame.scene_lights;
    vec3 sum = vec3(0.0);
    for (uint i = lane; i < lamps * count; i += lanes) {
        PointPlace place = lit_places[i % count];
        PunctualLight light = punctual_lights[i / count];
        sum += irradiance_from(light, place.position_ws, place.normal_ws, place.normal_ws, place.position_ws);
    }
    return sum / float(count);
}

// Points on surfaces that shine that each place of a point is lit from.
const uint EMITTER_POINTS = 16u;

// Share of one lane, of so many, of the irradiance from surfaces that shine, from this many places.
vec3 emitter_light_at_places(uint key, uint place_count, uint lane, uint lanes) {
    if (!has_emitters()) {
        return vec3(0.0);
    }
    uint count = min(place_count, frame.sun_leaves);
    uint sequence_seed = hash(key, 0x3c6ef372u);
    vec3 sum = vec3(0.0);
    for (uint i = lane; i < EMITTER_POINTS * count; i += lanes) {
        PointPlace place = lit_places[i % count];
        vec2 u = r2_sequence(i, sequence_seed);
        sum += emitter_irradiance(place.position_ws, place.normal_ws, place.normal_ws, place.position_ws, u);
    }
    return sum / float(EMITTER_POINTS * count);
}
