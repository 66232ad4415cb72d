//! Makes the frames of a quality fit what is wanted: measures what they need to know of the scene, and compiles them anew.

use std::sync::Arc;

use super::super::measuring::Measuring;
use super::super::quality::Quality;
use super::{FrameSet, Side, Stage, Wanted};
use crate::Result;
use crate::passes::present::Part;
use crate::renderer::{Job, Renderer, Show, holds_for};
use crate::scene::Camera;
use crate::settings::Settings;
use crate::techniques::{self, TechniqueShape};

/// Measures that are kept beside those of the compiled frames: one for each side of a split view.
const KEPT_MEASURES: usize = 2;

/// What became of frames that were to fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Adapted {
    /// They fit already.
    No,
    /// They have been compiled anew.
    Yes,
    /// What they need to know of the scene is being measured: ask again.
    Later,
}

/// Whether [`Stage::adapt`] waits for what must be measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Patience {
    /// It waits.
    Waits,
    /// It comes back.
    Returns,
}

impl Stage {
    /// Compiles the frames of a quality anew when they have another shape with these settings; the ones before stay when that
    /// fails.
    ///
    /// # Errors
    /// When the settings do not fit the device.
    pub fn adapt(&mut self, quality: Quality, wanted: &Wanted<'_>, patience: Patience) -> Result<Adapted> {
        let sides = || [Some(wanted.settings), wanted.held].into_iter().flatten();
        let mut has_points = true;
        for settings in sides() {
            has_points &= self.has_points(settings)?;
        }
        if let Some(set) = self.sets[quality.index()].as_ref().filter(|_| has_points)
            && self.fits(set, wanted)?
        {
            return Ok(Adapted::No);
        }
        for settings in sides() {
            if !self.measure(settings, wanted.camera, patience)? {
                return Ok(Adapted::Later);
            }
        }
        let part = if wanted.held.is_some() { Part::Right } else { Part::Whole };
        let held = wanted.held.map(|settings| self.compile(settings, wanted, Part::Left)).transpose()?;
        let set = FrameSet { main: self.compile(wanted.settings, wanted, part)?, held };
        self.replace(quality, set)?;
        Ok(Adapted::Yes)
    }

    /// Spreads the points and measures what frames of these settings need; false while that is under way.
    fn measure(&mut self, settings: &Settings, camera: &Camera, patience: Patience) -> Result<bool> {
        while !self.has_points(settings)? || self.measured_for(settings)?.is_none() {
            let measuring = match self.measuring.take() {
                Some(measuring) => measuring,
                None => {
                    self.pose_vertices_for(settings)?;
                    Measuring::start(&self.gpu, &self.scene, &self.uploaded, camera, settings)?
                }
            };
            if patience == Patience::Returns && !measuring.is_done() {
                self.measuring = Some(measuring);
                return Ok(false);
            }
            let is_stale = measuring.is_stale();
            let Some(measured) = measuring.finish(settings)? else { continue };
            self.uploaded.keep_points(measured.points.clone());
            if !is_stale {
                self.measured.insert(0, measured);
                self.measured.truncate(KEPT_MEASURES);
            }
        }
        Ok(true)
    }

    /// Points are spread over the scene as the host has it.
    fn pose_vertices_for(&mut self, settings: &Settings) -> Result<()> {
        if techniques::of(settings)?.point_count_log2(settings).is_some()
            && let Some(scene) = Arc::get_mut(&mut self.scene)
        {
            scene.pose_vertices();
        }
        Ok(())
    }

    /// Whether the points that frames of these settings need have been spread.
    fn has_points(&self, settings: &Settings) -> Result<bool> {
        let wanted = techniques::of(settings)?.point_count_log2(settings);
        Ok(wanted.is_none_or(|count_log2| self.uploaded.points(count_log2).is_ok()))
    }

    /// Whether the frames of a quality are those that are wanted; points are there.
    fn fits(&self, set: &FrameSet, wanted: &Wanted<'_>) -> Result<bool> {
        let fits = |side: &Side, settings| {
            let job = Job::new(&self.gpu, &self.uploaded, wanted.camera, settings);
            let measured = side.measured_with.as_ref();
            measured.map_or(Ok(false), |measured_with| side.renderer.fits(&job, measured_with, wanted.inspects))
        };
        Ok(match (&set.held, wanted.held) {
            (None, None) => true,
            (Some(side), Some(settings)) => fits(side, settings)?,
            _ => false,
        } && fits(&set.main, wanted.settings)?)
    }

    fn compile(&self, settings: &Settings, wanted: &Wanted<'_>, part: Part) -> Result<Side> {
        let job = Job::new(&self.gpu, &self.uploaded, wanted.camera, settings);
        let renderer = Renderer::for_window(&job, wanted.inspects, self.measured_for(settings)?)?;
        let show = Show::new(&self.gpu, renderer.shown_picture(), self.window, part)?;
        Ok(Side { renderer, show, measured_with: Some(settings.clone()), next_round: None, frames: 0 })
    }

    /// What was measured of the scene for settings like these.
    fn measured_for(&self, settings: &Settings) -> Result<Option<&dyn TechniqueShape>> {
        // An outgoing frame may be of another scene.
        let sides = self.sets.iter().flatten().flat_map(|set| set.held.iter().chain([&set.main]));
        for Side { renderer, measured_with, .. } in sides {
            let shape = &*renderer.shapes().technique;
            if let Some(measured_with) = measured_with
                && holds_for(shape, settings, measured_with)?
            {
                return Ok(Some(shape));
            }
        }
        for measured in &self.measured {
            if measured.holds_for(settings)? {
                return Ok(Some(&*measured.shape));
            }
        }
        Ok(None)
    }

    /// Frames take the place of others, which stay in sight if they are shown.
    fn replace(&mut self, quality: Quality, set: FrameSet) -> Result<()> {
        if self.running.as_ref().is_some_and(|running| running.quality == quality) {
            self.abandon()?;
        }
        let before = self.sets[quality.index()].replace(set);
        if self.shown == Some(quality) {
            (self.outgoing, self.shown) = (before, None);
        }
        Ok(())
    }

    /// What was measured of the lights counts no longer, as after the sun has moved far.
    pub fn forget_measures(&mut self) {
        for set in self.sets.iter_mut().flatten() {
            set.held.iter_mut().chain([&mut set.main]).for_each(|side| side.measured_with = None);
        }
        self.measured.clear();
        self.measuring.iter_mut().for_each(Measuring::disregard);
    }

    /// Compiles the frames of a quality with the shaders in use, whatever was there before; the others when they are next
    /// needed.
    ///
    /// # Errors
    /// Those of [`Self::adapt`].
    #[cfg(feature = "shader-compiler")]
    pub fn compile_again(&mut self, quality: Quality, wanted: &Wanted<'_>) -> Result<()> {
        self.abandon()?;
        let others = [Quality::Moving, Quality::Half, Quality::Full].into_iter().filter(|other| *other != quality);
        let before = self.sets[quality.index()].take();
        match self.adapt(quality, wanted, Patience::Waits) {
            Ok(_) => {
                let mut before = before;
                for other in others {
                    let set = self.sets[other.index()].take();
                    if self.shown == Some(other) {
                        before = set;
                    }
                }
                (self.outgoing, self.shown) = (before.or_else(|| self.outgoing.take()), None);
                Ok(())
            }
            Err(error) => {
                self.sets[quality.index()] = before;
                Err(error)
            }
        }
    }
}
