// What is kept from the frame before: for each primary point its number there, NOT_KEPT for one that was not there, or stood
// elsewhere. Rust: passes::point_reuse.
const uint NOT_KEPT = 0xffffffffu;
