// Order-independent sums: 64-bit two's complement with 40 fractional bits, in two words, added with
// carry, by 32-bit atomics too. Works on every device, and the result is the same whatever the order of the additions.
const float FIXED_HIGH = 256.0;
const float FIXED_LOW = 4294967296.0;

uvec2 negated(uvec2 words) { return uvec2(~words.x + 1u, ~words.y + (words.x == 0u ? 1u : 0u)); }

// Splits a value in [-1, 1] into the two words. By magnitude, so that small negative values keep their bits.
uvec2 fixed_from_float(float value) {
    precise float scaled = abs(value) * FIXED_HIGH;
    precise float high = floor(scaled);
    precise float low = (scaled - high) * FIXED_LOW;
    uvec2 words = uvec2(uint(low), uint(high));
    return value < 0.0 ? negated(words) : words;
}

// Sum of two numbers in two words.
uvec2 fixed_sum(uvec2 a, uvec2 b) {
    uint low = a.x + b.x;
    return uvec2(low, a.y + b.y + (low < a.x ? 1u : 0u));
}

float float_from_fixed(uvec2 words) {
    bool negative = int(words.y) < 0;
    uvec2 magnitude = negative ? negated(words) : words;
    float value = float(magnitude.y) / FIXED_HIGH + float(magnitude.x) / (FIXED_HIGH * FIXED_LOW);
    return negative ? -value : value;
}
