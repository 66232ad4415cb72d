//! What is rendered while something moves, and what at rest: the settings in use, made cheaper in steps where the device needs
//! that. `--render-scale F` renders the settings as they are, at that scale.

use crate::settings::{IndirectSize, RenderScale, Settings, Size, Switch, Technique, Temporal, TextureFilter, View};
use crate::techniques;

/// While something moves pictures have no more lights than this, on a device that is too slow for those asked for.
const MOVING_VPLS: u32 = 2_000;
/// Interleaving of such pictures: a seventh of the frame's time, for a third more error of blocks.
const MOVING_INTERLEAVE: u32 = 2;
/// The same for points that stand for surfaces.
const MOVING_POINTS: u32 = 16_384;
/// Frames whose mean a window at rest shows, unless more are asked for.
pub const REST_FRAMES: u32 = 128;
/// Shadow samples of each of them, and rays towards the environment. In the time of a frame with four there are two with one,
/// whose mean is as good, has more points in each pixel and is there sooner.
const REST_SAMPLES: u32 = 1;
/// Interleaving of each of them: it costs a mean nothing, for every frame deals other lights to the pixels.
const REST_INTERLEAVE: u32 = 2;
/// Smallest picture while something moves.
const SMALLEST: Size = Size { width: 240, height: 135 };
/// A picture whose scale is below this has one of half the window's size between it and the whole.
const NEEDS_HALF: f32 = 0.4;

/// How good a picture is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quality {
    /// As good as it can be ten times a second.
    Moving,
    /// One frame of the mean, at half the window's size.
    Half,
    /// The settings in use, of the window's size: the mean of several frames.
    Full,
}

impl Quality {
    /// How many there are.
    pub const COUNT: usize = 3;

    /// Position among them.
    pub fn index(self) -> usize {
        self as usize
    }
}

/// A cheaper way to render.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rung {
    /// Edge of the picture as a fraction of the window's.
    pub scale: f32,
    /// Fewer lights, one shadow sample, indirect light at a quarter of the pixels.
    pub is_cheap: bool,
}

/// How the settings in use are rendered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Way {
    /// Like this while something moves, and as they are at rest.
    Adapts(Rung),
    /// As they are, at this scale.
    AsAsked(f32),
}

/// What a window is to show.
#[derive(Clone, Copy)]
pub struct Plan {
    /// Size of the window.
    pub window_px: [u32; 2],
    /// How that is rendered.
    pub way: Way,
    /// Frames of the mean that are asked for, on either side of a split view.
    pub accumulate: u32,
    /// Shadow samples of a pixel that are asked for, on either side.
    pub samples: u32,
    /// Whether the finished picture is shown, on either side: views are not accumulated.
    pub is_picture: bool,
    /// Whether a reference technique renders it, on either side.
    pub is_reference: bool,
}

impl Plan {
    /// The qualities to go through, from the first picture to the best.
    pub fn steps(&self) -> &'static [Quality] {
        match self.way {
            Way::AsAsked(_) => &[Quality::Full],
            Way::Adapts(rung) if rung.scale < NEEDS_HALF && !self.is_reference => {
                &[Quality::Moving, Quality::Half, Quality::Full]
            }
            Way::Adapts(_) => &[Quality::Moving, Quality::Full],
        }
    }

    /// Frames of the mean that the best picture is.
    pub fn goal(&self) -> u32 {
        match self.way {
            _ if !self.is_picture => 1,
            Way::AsAsked(_) => self.accumulate,
            Way::Adapts(_) => self.accumulate.max(REST_FRAMES),
        }
    }

    /// Frames of the mean that together have the samples asked for.
    pub fn frames_of_settings(&self) -> u32 {
        match self.way {
            Way::Adapts(_) if !self.is_reference => self.samples.div_ceil(REST_SAMPLES).clamp(1, self.goal()),
            _ => 1,
        }
    }

    /// The settings for pictures of a quality.
    pub fn settings(&self, quality: Quality, settings: &Settings) -> Settings {
        let scale = match (quality, self.way) {
            (Quality::Moving, Way::Adapts(rung)) => rung.scale,
            (Quality::Half, _) => 0.5,
            (Quality::Full, Way::Adapts(_)) => 1.0,
            (_, Way::AsAsked(scale)) => scale,
        };
        let mut new = settings.clone();
        if let (Quality::Moving, Way::Adapts(Rung { is_cheap: true, .. })) = (quality, self.way) {
            new = changed_if_valid(cheaper(new), |s| {
                s.lgh.indirect_size = IndirectSize::Half;
                interleave(s, MOVING_INTERLEAVE);
            });
        } else if let Way::Adapts(_) = self.way {
            new = for_mean(new);
        }
        if let (Quality::Moving, Way::Adapts(_)) = (quality, self.way) {
            new = changed_if_valid(new, |s| s.lgh.temporal = s.lgh.temporal.or(Some(Temporal::Shadows)));
        }
        new.render.accumulate = if quality == Quality::Full { self.goal() } else { 1 };
        if new.render.accumulate > 1 {
            // The frames of a mean are independent.
            (new.lgh.temporal, new.render.taa) = (None, Switch::Off);
        }
        new.picture.size = picture_size(self.window_px, scale, new.lgh.interleave);
        new
    }
}

/// The same picture for less. A reference is stood in for by the hierarchy where that has the view.
fn cheaper(settings: Settings) -> Settings {
    let is_reference = is_reference(&settings);
    changed_if_valid(settings, |s| {
        if is_reference && s.render.view == View::Final {
            s.render.technique = Technique::Lgh;
        }
        s.many_lights.vpls = s.many_lights.vpls.min(MOVING_VPLS);
        s.many_lights.shadow_samples = s.many_lights.shadow_samples.min(1);
        s.picture.texture_filter = TextureFilter::Trilinear;
        s.environment.samples = s.environment.samples.min(1);
        if s.render.technique == Technique::Pbgi {
            s.pbgi.points = s.pbgi.points.min(MOVING_POINTS);
            s.pbgi.reuse = Switch::On;
        }
    })
}

/// One frame of a mean with fresh samples. Views are not accumulated, and references have rounds of their own.
fn for_mean(settings: Settings) -> Settings {
    if is_reference(&settings) || settings.render.view != View::Final {
        return settings;
    }
    changed_if_valid(settings, |s| {
        s.many_lights.shadow_samples = s.many_lights.shadow_samples.min(REST_SAMPLES);
        s.environment.samples = s.environment.samples.min(REST_SAMPLES);
        interleave(s, REST_INTERLEAVE);
    })
}

/// Interleaved frames have one round of samples.
fn interleave(settings: &mut Settings, least: u32) {
    settings.lgh.interleave = settings.lgh.interleave.max(least);
    if settings.lgh.interleave > 1 {
        settings.lgh.temporal_rounds = None;
    }
}

fn is_reference(settings: &Settings) -> bool {
    techniques::of(settings).is_ok_and(techniques::Technique::is_reference)
}

/// Settings may exclude each other: they then stay as they are.
fn changed_if_valid(settings: Settings, change: impl FnOnce(&mut Settings)) -> Settings {
    let new = settings.clone().changed(change);
    let fits = new.validate().and_then(|()| techniques::check(&new)).is_ok();
    if fits { new } else { settings }
}

/// The scale below which a window's picture would be smaller than while anything moves.
pub fn smallest_scale(window_px: [u32; 2]) -> f32 {
    let of = |smallest: u32, edge: u32| smallest as f32 / edge.max(1) as f32;
    of(SMALLEST.width, window_px[0]).max(of(SMALLEST.height, window_px[1])).min(1.0)
}

/// Size of the picture in a window: whole pixels, and at least as many as an interleaving pattern has.
pub fn picture_size(window_px: [u32; 2], scale: f32, interleave: u32) -> Size {
    let edge = |px: u32| ((px as f32 * scale).round() as u32).max(interleave.max(1));
    Size { width: edge(window_px[0]), height: edge(window_px[1]) }
}

/// The scale that the settings ask for, when it is not chosen by the frame's time.
pub fn fixed_scale(setting: RenderScale) -> Option<f32> {
    match setting {
        RenderScale::Fixed(scale) => Some(scale),
        RenderScale::Auto => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Antilag;

    const WINDOW: [u32; 2] = [1280, 720];

    fn plan(way: Way) -> Plan {
        Plan { window_px: WINDOW, way, accumulate: 1, samples: 4, is_picture: true, is_reference: false }
    }

    #[test]
    fn a_window_at_rest_has_the_settings_and_all_pixels() {
        let asked = Settings::default();
        let full = plan(Way::Adapts(Rung { scale: 0.1875, is_cheap: true })).settings(Quality::Full, &asked);
        assert_eq!(full.picture.size, Size { width: 1280, height: 720 });
        assert_eq!(full.render.accumulate, REST_FRAMES);
        assert_eq!((full.many_lights.vpls, full.lgh.first_level), (asked.many_lights.vpls, asked.lgh.first_level));
    }

    #[test]
    fn frames_of_a_mean_share_the_samples() {
        let plan = plan(Way::Adapts(Rung { scale: 0.1875, is_cheap: true }));
        let asked = Settings::default().changed(|s| (s.many_lights.shadow_samples, s.environment.samples) = (4, 8));
        let full = plan.settings(Quality::Full, &asked);
        let cheap = (full.many_lights.shadow_samples, full.environment.samples, full.lgh.interleave);
        assert_eq!(cheap, (1, 1, REST_INTERLEAVE));
        assert_eq!(plan.frames_of_settings(), 4);
        // A view is one frame, and a scale that is asked for leaves the samples together.
        let as_asked = Plan { way: Way::AsAsked(1.0), ..plan };
        let view = Plan { is_picture: false, ..plan };
        let of_view = asked.clone().changed(|s| s.render.view = View::ShadowRatio);
        assert_eq!(view.settings(Quality::Full, &of_view).many_lights.shadow_samples, 4);
        assert_eq!((view.frames_of_settings(), as_asked.frames_of_settings()), (1, 1));
        let reference = asked.changed(|s| s.render.technique = Technique::BruteForce);
        assert_eq!(Plan { is_reference: true, ..plan }.frames_of_settings(), 1);
        assert_eq!(plan.settings(Quality::Full, &reference).many_lights, reference.many_lights);
    }

    #[test]
    fn a_moving_picture_is_cheaper() {
        let plan = plan(Way::Adapts(Rung { scale: 0.1875, is_cheap: true }));
        let moving = plan.settings(Quality::Moving, &Settings::default());
        assert_eq!(moving.picture.size, Size { width: 240, height: 135 });
        assert_eq!((moving.many_lights.vpls, moving.many_lights.shadow_samples), (MOVING_VPLS, 1));
        assert_eq!((moving.lgh.indirect_size, moving.lgh.interleave), (IndirectSize::Half, MOVING_INTERLEAVE));
        assert_eq!(moving.render.accumulate, 1);
        assert_eq!(moving.lgh.temporal, Some(Temporal::Shadows));
        assert_eq!(moving.picture.texture_filter, TextureFilter::Trilinear);
        let of_view = Settings::default().changed(|s| s.render.view = View::ShadowRatio);
        assert_eq!(
            plan.settings(Quality::Moving, &of_view).lgh.indirect_size,
            IndirectSize::Full,
            "it is of every pixel"
        );
        let asked = Settings::default().changed(|s| s.lgh.temporal = Some(Temporal::Off));
        assert_eq!(plan.settings(Quality::Moving, &asked).lgh.temporal, Some(Temporal::Off));
        let asked = Settings::default().changed(|s| {
            (s.lgh.temporal, s.lgh.antilag, s.lgh.temporal_rounds) = (Some(Temporal::Shadows), Antilag::Tiles, Some(9));
        });
        let moving = plan.settings(Quality::Moving, &asked).lgh;
        assert_eq!((moving.interleave, moving.temporal_rounds_or_default()), (MOVING_INTERLEAVE, 1));
        let asked = Settings::default().changed(|s| s.lgh.temporal = Some(Temporal::Indirect));
        assert_eq!(plan.settings(Quality::Full, &asked).lgh.temporal, None, "a mean");
        let asked = Settings::default().changed(|s| s.render.taa = Switch::On);
        let taa = [Quality::Moving, Quality::Full].map(|quality| plan.settings(quality, &asked).render.taa);
        assert_eq!(taa, [Switch::On, Switch::Off], "means have none");
        let points = Settings::default().changed(|s| s.render.technique = Technique::Pbgi);
        let moving = plan.settings(Quality::Moving, &points);
        assert_eq!((moving.pbgi.points, moving.pbgi.reuse), (MOVING_POINTS, Switch::On));
        assert_eq!(plan.settings(Quality::Full, &points).pbgi, points.pbgi);
        let reference = Settings::default().changed(|s| s.render.technique = Technique::BruteForce);
        assert_eq!(plan.settings(Quality::Moving, &reference).render.technique, Technique::Lgh);
        assert_eq!(plan.settings(Quality::Full, &reference).render.technique, Technique::BruteForce);
    }

    #[test]
    fn a_scale_that_is_asked_for_changes_nothing_else() {
        let asked = Settings::default().changed(|s| s.render.accumulate = 3);
        let fixed = Plan { accumulate: 3, ..plan(Way::AsAsked(0.25)) };
        assert_eq!((fixed.steps(), fixed.goal()), (&[Quality::Full][..], 3));
        let expected = asked.clone().changed(|s| s.picture.size = Size { width: 320, height: 180 });
        assert_eq!(fixed.settings(Quality::Full, &asked), expected);
    }

    #[test]
    fn pictures_grow_in_steps_and_views_are_not_accumulated() {
        let slow = plan(Way::Adapts(Rung { scale: 0.1875, is_cheap: true }));
        assert_eq!(slow.steps(), [Quality::Moving, Quality::Half, Quality::Full]);
        assert_eq!(Plan { is_reference: true, ..slow }.steps(), [Quality::Moving, Quality::Full]);
        assert_eq!(plan(Way::Adapts(Rung { scale: 1.0, is_cheap: false })).steps(), [Quality::Moving, Quality::Full]);
        assert_eq!((slow.goal(), Plan { accumulate: 1024, ..slow }.goal()), (REST_FRAMES, 1024));
        assert_eq!(Plan { is_picture: false, ..slow }.goal(), 1);
    }

    #[test]
    fn tiny_windows_have_pixels() {
        assert_eq!(picture_size([1, 1], 0.05, 4), Size { width: 4, height: 4 });
        assert_eq!(picture_size(WINDOW, 0.25, 1), Size { width: 320, height: 180 });
        assert_eq!((smallest_scale(WINDOW), smallest_scale([100, 100])), (0.1875, 1.0));
    }
}
