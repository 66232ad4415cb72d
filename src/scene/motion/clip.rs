//! Animations of a file: what moves while they play.

use super::sampler::Sampler;

/// What of a node an animation changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::scene) enum Property {
    /// Where it is.
    Translation,
    /// How it is turned.
    Rotation,
    /// How it is stretched.
    Scale,
    /// Weights of its mesh's morph targets.
    Weights,
}

/// One property of one node in a clip.
#[derive(Clone, Debug)]
pub(in crate::scene) struct Channel {
    /// The node's index in the file.
    pub node: usize,
    /// What of it changes.
    pub property: Property,
    /// Its values.
    pub sampler: Sampler,
}

/// An animation of the file.
#[derive(Clone, Debug)]
pub(in crate::scene) struct Clip {
    /// Its name in the file, or `animation N`.
    pub name: String,
    /// What it changes.
    pub channels: Vec<Channel>,
    /// When it begins anew, in seconds: its last key.
    pub duration_s: f64,
}

impl Clip {
    /// A clip of these channels.
    pub fn new(name: String, channels: Vec<Channel>) -> Self {
        let last = channels.iter().filter_map(|channel| channel.sampler.times_s().last());
        let duration_s = f64::from(last.fold(0.0_f32, |latest, time_s| latest.max(*time_s)));
        Self { name, channels, duration_s }
    }

    /// The moment within the clip, which repeats; one of a single moment stands still.
    pub fn local_time_s(&self, time_s: f64) -> f32 {
        if self.duration_s > 0.0 { time_s.rem_euclid(self.duration_s) as f32 } else { 0.0 }
    }
}
