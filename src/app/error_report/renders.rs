//! Renders the recipes of the error report, each once.

use std::rc::Rc;
use std::sync::Arc;

use super::super::frames::SUBDIVISION;
use super::stages::{Frames, Recipe};
use crate::compare::{Image, Tone, metrics};
use crate::gpu::Gpu;
use crate::progress::{Bar, Progress};
use crate::renderer::{Fresh, Job, Renderer, UploadedScene};
use crate::scene::Camera;
use crate::settings::Settings;
use crate::{Error, Result, interrupt, techniques};

/// A picture and what is known of it.
#[derive(Debug)]
pub struct Rendered {
    /// Linear radiance.
    pub image: Image,
    /// Milliseconds of all its frames on the GPU's clock.
    pub ms: f64,
    /// An estimate of its own noise; `None` where there is none or it cannot be told.
    pub noise: Option<Noise>,
}

/// How far a picture is from what it converges to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Relative mean squared error.
    pub relmse: f64,
    /// The same of 8x8 blocks; `None` where there are none.
    pub smooth_relmse: Option<f64>,
}

/// Where pictures are taken.
pub struct Studio<'a> {
    gpu: &'a Arc<Gpu>,
    scene: &'a UploadedScene,
    camera: &'a Camera,
    progress: Progress,
    taken: Vec<(Recipe, Rc<Rendered>)>,
}

impl<'a> Studio<'a> {
    /// A studio without pictures.
    pub fn new(gpu: &'a Arc<Gpu>, scene: &'a UploadedScene, camera: &'a Camera, progress: Progress) -> Self {
        Self { gpu, scene, camera, progress, taken: Vec::new() }
    }

    /// The picture of a recipe, rendered when it is asked for the first time, under a progress bar of this name.
    ///
    /// # Errors
    /// [`Error::Interrupted`] when the user stops the run before the picture is finished; device errors.
    pub fn picture(&mut self, recipe: &Recipe, name: &str) -> Result<Rc<Rendered>> {
        if let Some((_, rendered)) = self.taken.iter().find(|(known, _)| known == recipe) {
            return Ok(Rc::clone(rendered));
        }
        let bar = self.progress.bar(name, SUBDIVISION);
        let rendered = match techniques::of(&recipe.settings)?.halves(&recipe.settings) {
            Some(halves) => self.halves(&halves, &bar),
            None => self.frames(&recipe.settings, recipe.frames, &|done| bar.set(done)),
        };
        bar.finish();
        let rendered = Rc::new(rendered?);
        self.taken.push((recipe.clone(), Rc::clone(&rendered)));
        Ok(rendered)
    }

    /// Two parts of the samples with seeds of their own: their difference tells the noise of their mean.
    fn halves(&self, settings: &[Settings; 2], bar: &Bar) -> Result<Rendered> {
        let half = |index: usize| {
            let before = index as u64 * SUBDIVISION / 2;
            self.frames(&settings[index], Frames::One, &|done| bar.set(before + done / 2))
        };
        let (first, second) = (half(0)?, half(1)?);
        let samples = settings.each_ref().map(|settings| settings.path_trace.samples);
        let share = samples[1] as f32 / (samples[0] + samples[1]) as f32;
        let mean = mix(&first.image, &second.image, share)?;
        // A half is as far from the mean of both as that mean is expected to be from the truth.
        let noise = metrics(&mean, &first.image, Tone::Srgb, None)?;
        let noise = noise.relmse.map(|relmse| Noise { relmse, smooth_relmse: noise.smooth_relmse });
        Ok(Rendered { image: mean, ms: first.ms + second.ms, noise })
    }

    /// Renders frames with the same light paths; `report` gets the part that is done, of [`SUBDIVISION`].
    fn frames(&self, settings: &Settings, frames: Frames, report: &dyn Fn(u64)) -> Result<Rendered> {
        check_interruption()?;
        let (first, count) = match frames {
            Frames::One => (0, 1),
            Frames::Mean(count) | Frames::MeanOfSingle(count) => (0, count),
            Frames::OneAfter(count) => (count, 1),
        };
        let stand_alone = matches!(frames, Frames::MeanOfSingle(_));
        let settings = settings.clone().changed(|s| s.render.accumulate = if stand_alone { 1 } else { count });
        let mut renderer = Renderer::new(&Job::new(self.gpu, self.scene, self.camera, &settings))?;
        if !techniques::of(&settings)?.is_reference() {
            // Some drivers compile shaders when they first run: that is no part of a frame of milliseconds.
            run_frame(&mut renderer, first, &settings, &|_| ())?;
        }
        let (mut ms, mut sum) = (0.0, Vec::new());
        for index in 0..count {
            check_interruption()?;
            let part = |done: f64| report((SUBDIVISION as f64 * (f64::from(index) + done) / f64::from(count)) as u64);
            ms += run_frame(&mut renderer, first + index, &settings, &part)?;
            if stand_alone {
                add(&mut sum, &renderer.read_radiance()?);
            }
            part(1.0);
        }
        if let Some(sentence) = renderer.complaint()? {
            log::warn!("{sentence}");
        }
        let size = settings.picture.size;
        let mean = |sum: Vec<f64>| sum.into_iter().map(|value| (value / f64::from(count)) as f32).collect();
        let radiance = if stand_alone { mean(sum) } else { renderer.read_radiance()? };
        let image = Image::new(size.width as usize, size.height as usize, radiance)?;
        Ok(Rendered { image, ms, noise: None })
    }
}

/// Milliseconds of one frame on the GPU's clock; `report` gets the part that is done, 0 to 1.
fn run_frame(renderer: &mut Renderer, number: u32, settings: &Settings, report: &dyn Fn(f64)) -> Result<f64> {
    renderer.set_accumulated_frame(number, Fresh::Shadows);
    let mut on_step = |done: u32, total: u32| {
        report(f64::from(done) / f64::from(total.max(1)));
        interrupt::control_flow()
    };
    let frame = renderer.run_in_steps(f64::from(settings.device.max_submit_ms), &mut on_step)?;
    if frame.rounds_done < frame.rounds { Err(interrupted()) } else { Ok(frame.times.gpu_ms()) }
}

/// Adds a picture to a sum, which is empty before the first.
fn add(sum: &mut Vec<f64>, picture: &[f32]) {
    sum.resize(picture.len(), 0.0);
    sum.iter_mut().zip(picture).for_each(|(sum, value)| *sum += f64::from(*value));
}

fn check_interruption() -> Result<()> {
    if interrupt::requested() { Err(interrupted()) } else { Ok(()) }
}

fn interrupted() -> Error {
    Error::Interrupted("interrupted while a picture was rendered".to_owned())
}

/// `(1 - share) * a + share * b`.
fn mix(a: &Image, b: &Image, share: f32) -> Result<Image> {
    combine(a, b, |a, b| a + (b - a) * share)
}

/// The sum of two pictures.
///
/// # Errors
/// [`Error::Failure`] when they have no pixels.
pub fn sum(a: &Image, b: &Image) -> Result<Image> {
    combine(a, b, |a, b| a + b)
}

fn combine(a: &Image, b: &Image, value: impl Fn(f32, f32) -> f32) -> Result<Image> {
    Image::new(a.width, a.height, a.rgb.iter().zip(&b.rgb).map(|(a, b)| value(*a, *b)).collect())
}
