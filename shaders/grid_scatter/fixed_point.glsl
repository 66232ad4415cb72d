// Order-independent sums: 64-bit two's complement with 40 fractional bits, in two words added by 32-bit atomics
// with carry. Works on every device, and the result is the same whatever the order of the additions.
const float FIXED_HIGH = 256.0;
const float FIXED_LOW = 4294967296.0;

// Splits a value in [-1, 1] into the two words.
uvec2 fixed_from_float(float value) {
    float scaled = value * FIXED_HIGH;
    float high = floor(scaled);
    float low = min(scaled - high, 0.99999994);
    return uvec2(uint(low * FIXED_LOW), uint(int(high)));
}

float float_from_fixed(uvec2 words) {
    return float(int(words.y)) / FIXED_HIGH + float(words.x) / (FIXED_HIGH * FIXED_LOW);
}
