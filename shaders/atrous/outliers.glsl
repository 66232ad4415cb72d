// Samples that stand out from all around them. Needs frame.glsl, color.glsl and is_inside(); the including shader declares
// `unshadowed_image` and `step_px`, the distance of neighbours that do not share samples.

// A pixel's samples carry, per unit, at most this many times the unshadowed light of those around it.
const float MAX_OUTLIER = 64.0;

// The most that a pixel of this neighbourhood may carry: a multiple of the mean without the brightest, which may be the
// one that is too bright, and without the pixels that see no light at all.
float greatest_plausible(ivec2 pixel) {
    float sum = 0.0;
    float brightest = 0.0;
    float count = 0.0;
    for (int y = -2; y <= 2; ++y) {
        for (int x = -2; x <= 2; ++x) {
            ivec2 p = pixel + ivec2(x, y) * step_px;
            if (is_inside(p)) {
                vec4 unshadowed = texelFetch(unshadowed_image, p, 0);
                float carried = luminance(unshadowed.rgb);
                sum += carried;
                brightest = max(brightest, carried);
                count += unshadowed.a > 0.0 ? 1.0 : 0.0;
            }
        }
    }
    float others = sum - brightest;
    return others > 0.0 ? MAX_OUTLIER * others / max(count - 1.0, 1.0) : uintBitsToFloat(0x7f800000u);
}
