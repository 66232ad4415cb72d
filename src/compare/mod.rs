//! How far a picture, or the timings of a run, are from a reference: the measures behind `gridlight compare`.
//!
//! Pictures are compared as linear RGB radiance and as they would be shown; see [`ImageMetrics`] for every measure.
//! Pixels that are not finite in either picture are counted and left out of every mean.

pub mod false_color;
pub mod flip;
mod image;
pub mod limits;
mod metrics;
mod pair;
pub mod sequence;
mod ssim;
pub mod table;
pub mod timings;
mod tone;

pub use false_color::{diverging_color, false_color, heatmap};
pub use flip::flip_map;
pub use image::Image;
pub use limits::ImageLimits;
pub use metrics::{Comparison, ImageMetrics, IndirectMetrics, compare_images, metrics};
pub use sequence::{SequenceLimits, SequenceMeter, SequenceMetrics};
pub use timings::{TimingComparison, TimingsFile};
pub use tone::{LogAverage, Tone, auto_exposure, tone_map};

#[cfg(test)]
pub(crate) mod testing;
