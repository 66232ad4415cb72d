// What the picture makes of the shadow samples. Rust: settings::ShadowEstimate.
// The unshadowed lighting times S/U.
const uint ESTIMATE_RATIO = 0u;
// That, with U in place of the lighting: filtered more widely than S/U, since it is smooth.
const uint ESTIMATE_CORRECTED = 1u;
// S.
const uint ESTIMATE_UNBIASED = 2u;
layout(constant_id = 4) const uint ESTIMATE = ESTIMATE_RATIO;
