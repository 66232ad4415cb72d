//! What the reference techniques share in dumps.

use crate::dump::{Entry, LIGHTING, RGBA, image};

/// Resources of `passes::reference`.
pub(super) const DUMP: &[Entry] = &[
    image("reference_sum", LIGHTING, RGBA, "Running sum of a reference technique; A is the share of its samples."),
    image(
        "reference_lighting",
        LIGHTING,
        RGBA,
        "Indirect light of a reference technique; A is the share of its samples that was taken.",
    ),
];
