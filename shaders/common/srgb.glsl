// The encoding of sRGB.

vec3 srgb_encode(vec3 linear) {
    vec3 low = 12.92 * linear;
    vec3 high = 1.055 * pow(max(linear, vec3(1e-12)), vec3(1.0 / 2.4)) - 0.055;
    return mix(high, low, lessThanEqual(linear, vec3(0.0031308)));
}

// Inverse of srgb_encode.
vec3 srgb_decode(vec3 encoded) {
    vec3 high = pow((encoded + 0.055) / 1.055, vec3(2.4));
    return mix(high, encoded / 12.92, lessThanEqual(encoded, vec3(0.04045)));
}

// Of a colour 0xRRGGBB.
vec3 unpack_color(uint packed_color) { return unpackUnorm4x8(packed_color).zyx; }
