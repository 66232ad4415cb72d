// What the picture makes of the shadow samples. Rust: settings::ShadowEstimate.
// The unshadowed lighting times S/U.
const uint ESTIMATE_RATIO = 0u;
// S, where samples that stand out from all around them are cut.
const uint ESTIMATE_CORRECTED = 1u;
// S.
const uint ESTIMATE_UNBIASED = 2u;
layout(constant_id = 4) const uint ESTIMATE = ESTIMATE_RATIO;
