// The bins of the exposure's histogram: EXPOSURE_BINS equal parts of EXPOSURE_STOPS stops about luminance 1.
const float LOWEST_STOP = -0.5 * float(EXPOSURE_STOPS);
const float STOPS_PER_BIN = float(EXPOSURE_STOPS) / float(EXPOSURE_BINS);

// The bin of a luminance above the lowest stop; what is brighter than the last bin counts there.
uint bin_of(float value) {
    return uint(clamp((log2(value) - LOWEST_STOP) / STOPS_PER_BIN, 0.0, float(EXPOSURE_BINS - 1u)));
}

// log2 of the luminance at a place in the histogram, in bins from the left.
float stops_at(float place) { return LOWEST_STOP + STOPS_PER_BIN * place; }
