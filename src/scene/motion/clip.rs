//! Animations of a file: what moves while they play.

use super::sampler::Sampler;

/// Moments of a clip, evenly spaced, at which what it changes is looked at.
pub(in crate::scene) const MOMENTS_PER_CLIP: u32 = 64;

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
    /// Whether it and what is below it are there (`KHR_node_visibility`).
    Visibility,
}

/// What of a light an animation changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::scene) enum LightProperty {
    /// Candela or lux.
    Intensity,
    /// Linear RGB.
    Color,
    /// In radians.
    InnerConeAngle,
    /// In radians.
    OuterConeAngle,
}

/// What a channel changes, by indices in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::scene) enum Target {
    /// A property of a node.
    Node {
        /// The node.
        node: usize,
        /// What of it.
        property: Property,
    },
    /// A property of a light, which several nodes may carry.
    Light {
        /// The light.
        light: usize,
        /// What of it.
        property: LightProperty,
    },
    /// The vertical field of view of a camera, in radians.
    FieldOfView {
        /// The camera.
        camera: usize,
    },
}

/// One thing that a clip changes.
#[derive(Clone, Debug)]
pub(in crate::scene) struct Channel {
    /// What changes.
    pub target: Target,
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

impl Channel {
    /// The node, where the channel moves, shows or hides one.
    pub fn node(&self) -> Option<usize> {
        match self.target {
            Target::Node { node, .. } => Some(node),
            _ => None,
        }
    }
}

impl Clip {
    /// A clip of these channels.
    pub fn new(name: String, channels: Vec<Channel>) -> Self {
        let last = channels.iter().filter_map(|channel| channel.sampler.times_s().last());
        let duration_s = f64::from(last.fold(0.0_f32, |latest, time_s| latest.max(*time_s)));
        Self { name, channels, duration_s }
    }

    /// Moments within the clip, evenly spaced, that stand for what is between keys.
    pub fn even_moments_s(&self) -> impl Iterator<Item = f32> {
        let step_s = self.duration_s / f64::from(MOMENTS_PER_CLIP);
        (0..MOMENTS_PER_CLIP).map(move |moment| (f64::from(moment) * step_s) as f32)
    }

    /// The moment within the clip, which repeats; one of a single moment stands still.
    pub fn local_time_s(&self, time_s: f64) -> f32 {
        if self.duration_s > 0.0 { time_s.rem_euclid(self.duration_s) as f32 } else { 0.0 }
    }
}
