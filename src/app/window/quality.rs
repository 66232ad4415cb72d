//! What is rendered while something moves, and what at rest: the settings in use, made cheaper in steps where the device needs
//! that. `--render-scale F` renders the settings as they are, at that scale.

use crate::settings::{RenderScale, Settings, Size, Technique, View};
use crate::techniques;

/// While something moves pictures have no more lights than this, on a device that is too slow for those asked for.
const MOVING_VPLS: u32 = 5_000;
/// Interleaving of such pictures.
const MOVING_INTERLEAVE: u32 = 2;
/// Frames whose mean a window at rest shows, unless more are asked for.
pub const REST_FRAMES: u32 = 64;
/// Smallest picture while something moves.
const SMALLEST: Size = Size { width: 240, height: 135 };
/// A picture whose scale is below this has one of half the window's size between it and the whole.
const NEEDS_HALF: f32 = 0.4;

/// How good a picture is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quality {
    /// As good as it can be ten times a second.
    Moving,
    /// The settings in use, at half the window's size.
    Half,
    /// The settings in use, of the window's size, and the mean of several frames.
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
    /// Fewer lights, one shadow sample, interleaving.
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
            new = cheaper(new);
        }
        new.render.accumulate = if quality == Quality::Full { self.goal() } else { 1 };
        new.picture.size = picture_size(self.window_px, scale, new.lgh.interleave);
        new
    }
}

/// The same picture for less. A reference is stood in for by the hierarchy where that has the view.
fn cheaper(settings: Settings) -> Settings {
    let is_reference = techniques::of(&settings).is_ok_and(techniques::Technique::is_reference);
    let cheap = settings.clone().changed(|s| {
        if is_reference && s.render.view == View::Final {
            s.render.technique = Technique::Lgh;
        }
        s.many_lights.vpls = s.many_lights.vpls.min(MOVING_VPLS);
        s.many_lights.shadow_samples = s.many_lights.shadow_samples.min(1);
        s.lgh.interleave = s.lgh.interleave.max(MOVING_INTERLEAVE);
        s.environment.samples = s.environment.samples.min(1);
    });
    // Settings may exclude each other.
    let fits = cheap.validate().and_then(|()| techniques::check(&cheap)).is_ok();
    if fits { cheap } else { settings }
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

    const WINDOW: [u32; 2] = [1280, 720];

    fn plan(way: Way) -> Plan {
        Plan { window_px: WINDOW, way, accumulate: 1, is_picture: true, is_reference: false }
    }

    #[test]
    fn a_window_at_rest_has_the_settings_and_all_pixels() {
        let asked = Settings::default();
        let full = plan(Way::Adapts(Rung { scale: 0.1875, is_cheap: true })).settings(Quality::Full, &asked);
        assert_eq!(full.picture.size, Size { width: 1280, height: 720 });
        assert_eq!(full.render.accumulate, REST_FRAMES);
        assert_eq!((full.many_lights, full.lgh), (asked.many_lights, asked.lgh));
    }

    #[test]
    fn a_moving_picture_is_cheaper() {
        let plan = plan(Way::Adapts(Rung { scale: 0.1875, is_cheap: true }));
        let moving = plan.settings(Quality::Moving, &Settings::default());
        assert_eq!(moving.picture.size, Size { width: 240, height: 135 });
        assert_eq!((moving.many_lights.vpls, moving.many_lights.shadow_samples), (MOVING_VPLS, 1));
        assert_eq!((moving.lgh.interleave, moving.render.accumulate), (MOVING_INTERLEAVE, 1));
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
