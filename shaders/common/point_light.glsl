// Light of the scene's suns and lamps at points, averaged over their leaves. Needs scene.glsl, punctual.glsl and
// point_leaves.glsl.

// Whether a leaf is one of the first `frame.sun_leaves` of a point's.
bool is_asked(uvec4 leaves, uint leaf) {
    uvec4 before = uvec4(lessThan(leaves, uvec4(leaf)));
    return leaf != NO_LEAF && before.x + before.y + before.z + before.w < frame.sun_leaves;
}

// Share of one lane, of so many, of the irradiance from all lights. A point without leaves has its representative.
vec3 lamp_irradiance(uint key, uvec4 leaves, uint lane, uint lanes) {
    if (all(equal(leaves, uvec4(NO_LEAF)))) {
        leaves.x = leaf_key_of(NO_LEAF, key) - 2u * frame.point_leaf_count;
    }
    uint count = 0u;
    for (uint i = 0u; i < POINT_LEAVES; ++i) {
        count += is_asked(leaves, leaves[i]) ? 1u : 0u;
    }
    vec3 sum = vec3(0.0);
    for (uint i = lane; i < frame.direct_lights * POINT_LEAVES; i += lanes) {
        uint leaf = leaves[i % POINT_LEAVES];
        if (is_asked(leaves, leaf)) {
            PointPlace place = place_of_leaf_key(unpack_leaf(leaf));
            vec3 normal = place.normal_ws;
            PunctualLight light = punctual_lights[i / POINT_LEAVES];
            sum += irradiance_from(light, place.position_ws, normal, normal, place.position_ws);
        }
    }
    return sum / float(count);
}
