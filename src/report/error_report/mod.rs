//! The error report: how each approximation of the renderer changes the picture, stage by stage, as data, as Markdown,
//! and as one HTML file that needs no network.

mod html;
mod markdown;
mod pictures;

use serde::Serialize;

use super::machine::Machine;
use super::timings::{Device, Program, SceneInfo};
use crate::Result;
use crate::compare::{Image, ImageMetrics, Tone, compare_images};
use crate::settings::Settings;

/// The version of the JSON layout.
pub const SCHEMA: &str = "gridlight-error-report/1";

/// The whole report.
#[derive(Clone, Debug, Serialize)]
pub struct ErrorReport {
    /// Always [`SCHEMA`].
    pub schema: &'static str,
    /// The program that ran.
    pub program: Program,
    /// The device it ran on.
    pub device: Device,
    /// The computer it ran on.
    pub machine: Machine,
    /// The scene it rendered.
    pub scene: SceneInfo,
    /// The settings that the stages vary.
    pub settings: Settings,
    /// Paths per pixel of the path-traced reference.
    pub reference_samples: u32,
    /// Frames that stages with shadow samples are the mean of.
    pub frames_per_stage: u32,
    /// Factor on the radiance of every picture before tone mapping.
    pub exposure: f64,
    /// Whether the run was stopped before its last stage.
    pub interrupted: bool,
    /// The stages, in the order of the renderer's approximations.
    pub stages: Vec<Stage>,
}

/// One approximation: a picture with it against a picture without it.
#[derive(Clone, Debug, Serialize)]
pub struct Stage {
    /// Name of the stage.
    pub name: String,
    /// What makes the two pictures differ, one sentence.
    pub cause: String,
    /// The picture without the approximation.
    pub reference: Side,
    /// The picture with it.
    pub test: Side,
    /// How far they are apart.
    pub metrics: ImageMetrics,
    /// What limits the comparison, one sentence each.
    pub notes: Vec<String>,
    /// Both pictures; not in the JSON.
    #[serde(skip)]
    pub images: StageImages,
}

/// Where one of the two pictures comes from.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Side {
    /// How it was rendered, a few words.
    pub label: String,
    /// Milliseconds it took; `None` where that is unknown.
    pub ms: Option<f64>,
    /// What a reader should know about it.
    pub note: Option<String>,
}

/// The pictures of a stage.
#[derive(Clone, Debug)]
pub struct StageImages {
    /// The picture without the approximation, linear radiance.
    pub reference: Image,
    /// The picture with it, linear radiance, of the same size.
    pub test: Image,
    /// The FLIP error of each pixel, 0 to 1.
    pub flip_map: Vec<f32>,
}

impl Stage {
    /// Measures a stage from its two pictures (linear radiance), shown with `exposure`; `direct` is the reference's
    /// direct light alone. The stage has no notes yet.
    ///
    /// # Errors
    /// Those of [`compare_images`].
    pub fn measure(
        (name, cause): (&str, &str),
        (reference, reference_image): (Side, Image),
        (test, test_image): (Side, Image),
        exposure: f64,
        direct: Option<&Image>,
    ) -> Result<Self> {
        let found = compare_images(&reference_image, &test_image, Tone::Reinhard { exposure }, direct)?;
        let images = StageImages { reference: reference_image, test: test_image, flip_map: found.flip_map };
        let (name, cause) = (name.to_owned(), cause.to_owned());
        Ok(Self { name, cause, reference, test, metrics: found.metrics, notes: Vec::new(), images })
    }
}

impl ErrorReport {
    /// The numbers as an indented JSON document, without the pictures.
    ///
    /// # Errors
    /// [`crate::Error::Failure`] when a value cannot be expressed.
    pub fn to_json(&self) -> Result<Vec<u8>> {
        super::to_json(self)
    }

    /// The numbers as a Markdown table, below what was rendered where.
    #[must_use]
    pub fn to_markdown(&self) -> String {
        markdown::page(self)
    }

    /// Everything as one HTML page with its pictures inside.
    ///
    /// # Errors
    /// [`crate::Error::Failure`] when a picture cannot be encoded.
    pub fn to_html(&self) -> Result<String> {
        html::page(self)
    }

    /// What was rendered where: names and values.
    fn facts(&self) -> Vec<(&'static str, String)> {
        let Self { program, device, machine, scene, settings, .. } = self;
        let camera = if scene.camera.is_empty() { String::new() } else { format!(", camera {}", scene.camera) };
        vec![
            ("Scene", format!("{}, {} triangles{camera}", scene.name, scene.triangles)),
            ("Size", format!("{} pixels", settings.picture.size)),
            ("Exposure", crate::compare::table::number(self.exposure)),
            ("Device", format!("{} ({})", device.name, device.driver)),
            ("Machine", format!("{}, {} threads, {}", machine.cpu, machine.cores, machine.os)),
            ("Program", format!("{} {} ({})", program.name, program.version, program.commit)),
        ]
    }
}

impl Stage {
    /// What limits the comparison: the notes, those of both sides, and what the measures themselves have to say.
    fn remarks(&self) -> Vec<String> {
        let side = |side: &Side| side.note.as_ref().map(|note| format!("{}: {note}", side.label));
        let sides = [side(&self.reference), side(&self.test)];
        let measured = crate::compare::table::remarks(&self.metrics);
        self.notes.iter().cloned().chain(sides.into_iter().flatten()).chain(measured).collect()
    }
}

/// A time for reading: seconds from ten of them on.
fn time(ms: Option<f64>) -> String {
    match ms {
        None => "-".to_owned(),
        Some(ms) if ms >= 10_000.0 => format!("{:.1} s", ms / 1000.0),
        Some(ms) if ms >= 10.0 => format!("{ms:.0} ms"),
        Some(ms) => format!("{ms:.2} ms"),
    }
}

/// A measure for reading.
fn measure(value: Option<f64>) -> String {
    match value {
        None => "undefined".to_owned(),
        Some(0.0) => "0".to_owned(),
        Some(value) if (0.01..1000.0).contains(&value.abs()) => format!("{value:.4}"),
        Some(value) => format!("{value:.2e}"),
    }
}

const INTERRUPTED: &str = "The run was interrupted: the stages that would follow are missing.";

#[cfg(test)]
mod tests;
