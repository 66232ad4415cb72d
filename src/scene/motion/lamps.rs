//! Lights and lenses that change while animations play.

use std::collections::{BTreeMap, BTreeSet};

use glam::Vec3;

use super::clip::{Channel, LightProperty, Property, Target};
use super::nodes::Posed;
use super::{Carried, Motion};
use crate::scene::Light;
use crate::scene::gltf_lights::LightParts;

/// The least and the largest vertical field of view, in radians.
const FIELDS_OF_VIEW_RAD: [f32; 2] = [1e-3, 3.1];

impl Motion {
    /// Lights of the file of which anything changes.
    pub(super) fn changing_lamps(&self) -> BTreeSet<usize> {
        self.playing_channels().filter_map(|(_, channel)| light_of(channel)).collect()
    }

    fn playing_channels(&self) -> impl Iterator<Item = (&super::Clip, &Channel)> {
        self.playing_clips().flat_map(|clip| clip.channels.iter().map(move |channel| (clip, channel)))
    }

    /// The lights of the file at a moment.
    pub(super) fn lamps_at(&self, time_s: f64) -> Vec<LightParts> {
        let mut lamps = self.lamps.clone();
        for (clip, channel) in self.playing_channels() {
            let Target::Light { light, property } = channel.target else { continue };
            let (value, lamp) = (channel.sampler.at(clip.local_time_s(time_s)), &mut lamps[light]);
            // A spline may go below what its keys are.
            match property {
                LightProperty::Intensity => lamp.intensity = value[0].max(0.0),
                LightProperty::Color => lamp.color = Vec3::from_slice(&value).max(Vec3::ZERO),
                LightProperty::InnerConeAngle => lamp.inner_cone_angle_rad = value[0],
                LightProperty::OuterConeAngle => lamp.outer_cone_angle_rad = value[0],
            }
        }
        lamps
    }

    /// Vertical fields of view in radians of those cameras of the file whose changes, at a moment.
    pub(super) fn fields_of_view_at(&self, time_s: f64) -> BTreeMap<usize, f32> {
        let [least, largest] = FIELDS_OF_VIEW_RAD;
        let of = |(clip, channel): (&super::Clip, &Channel)| match channel.target {
            Target::FieldOfView { camera } => {
                Some((camera, channel.sampler.at(clip.local_time_s(time_s))[0].clamp(least, largest)))
            }
            _ => None,
        };
        self.playing_channels().filter_map(of).collect()
    }

    /// A light of the scene at a moment.
    pub(super) fn light_at(&self, carried: &Carried<Light>, posed: &Posed, lamps: &[LightParts]) -> Light {
        let light = carried.at_rest.carried_to(&posed.worlds[carried.node]).with(&lamps[carried.index]);
        if posed.visible[carried.node] { light } else { light.off() }
    }

    /// Each light while it emits most, or more; empty where none changes. What changes is taken at its greatest by itself,
    /// as several clips may play at once.
    pub(super) fn brightest_lights(&self) -> Vec<Light> {
        let switched: Vec<usize> = self
            .playing_channels()
            .filter(|(_, channel)| is_visibility(channel))
            .filter_map(|(_, c)| c.node())
            .collect();
        if switched.is_empty() && self.changing_lamps().is_empty() {
            return Vec::new();
        }
        let (lamps, rest) = (self.greatest_lamps(), self.rest());
        let switched = self.hierarchy.with_descendants(switched.into_iter());
        let brightest = |carried: &Carried<Light>| {
            let light = carried.at_rest.with(&lamps[carried.index]);
            if rest.visible[carried.node] || switched[carried.node] { light } else { light.off() }
        };
        self.lights.iter().map(brightest).collect()
    }

    /// The lights of the file with everything that changes at its greatest.
    fn greatest_lamps(&self) -> Vec<LightParts> {
        let mut lamps = self.lamps.clone();
        let channels = || {
            self.playing_channels().filter_map(|(clip, channel)| match channel.target {
                Target::Light { light, property } => Some((clip, &channel.sampler, light, property)),
                _ => None,
            })
        };
        // What changes is never as it is at rest.
        for (.., light, property) in channels() {
            match property {
                LightProperty::Intensity => lamps[light].intensity = 0.0,
                LightProperty::Color => lamps[light].color = Vec3::ZERO,
                LightProperty::OuterConeAngle => lamps[light].outer_cone_angle_rad = 0.0,
                LightProperty::InnerConeAngle => {}
            }
        }
        for (clip, sampler, light, property) in channels() {
            let lamp = &mut lamps[light];
            for time_s in sampler.times_s().iter().copied().chain(clip.even_moments_s()) {
                let value = sampler.at(time_s);
                match property {
                    LightProperty::Intensity => lamp.intensity = lamp.intensity.max(value[0]),
                    LightProperty::Color => lamp.color = lamp.color.max(Vec3::from_slice(&value)),
                    LightProperty::OuterConeAngle => {
                        lamp.outer_cone_angle_rad = lamp.outer_cone_angle_rad.max(value[0]);
                    }
                    LightProperty::InnerConeAngle => {}
                }
            }
        }
        lamps
    }

    /// For each light of a scene, the same while it emits most. Those beyond the file's own shine evenly.
    pub(crate) fn brightest_of<'a>(&'a self, lights: &'a [Light]) -> impl Iterator<Item = &'a Light> {
        lights.iter().enumerate().map(|(index, light)| self.brightest.get(index).unwrap_or(light))
    }
}

fn light_of(channel: &Channel) -> Option<usize> {
    match channel.target {
        Target::Light { light, .. } => Some(light),
        _ => None,
    }
}

fn is_visibility(channel: &Channel) -> bool {
    matches!(channel.target, Target::Node { property: Property::Visibility, .. })
}
