//! Frames that a window shows: camera, lights and settings change while they run, and only what has another shape is
//! compiled anew.

use super::shape::{base_shape, check_lights, is_measured, measured_shape};
use super::{Renderer, frame_data};
use crate::error::Result;
use crate::gpu::{FrameResult, FrameTicket, Shown};
use crate::job::Job;
use crate::passes::FrameShape;
use crate::passes::present::{Part, WindowFormat};
use crate::settings::Settings;
use crate::shared::{InspectedPixel, PunctualLight};

/// What a window wants of its frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Showing {
    /// Format of the window's images.
    pub format: WindowFormat,
    /// Which part of the window they fill.
    pub part: Part,
    /// Whether they tell everything about one pixel.
    pub inspect: bool,
}

/// What a completed frame of a window has told.
#[derive(Clone, Debug, PartialEq)]
pub struct Told {
    /// Exposure, or the upper end of a view's scale.
    pub exposure: f32,
    /// Rays of light paths and of shadow samples.
    pub rays: [u32; 2],
    /// Virtual point lights, where there is a hierarchy.
    pub vpls: Option<u32>,
    /// Lights of level 1, 2, ...
    pub levels: Vec<u32>,
    /// The pixel asked for.
    pub inspected: Option<InspectedPixel>,
}

impl Renderer {
    /// A frame for a window. What `before` measured of the same scene is used again where the settings leave it as it
    /// was; `measured_with` are the settings that it was measured with.
    ///
    /// # Errors
    /// Those of [`Renderer::new`].
    pub fn for_window(job: &Job<'_>, showing: Showing, before: Option<(&Self, &Settings)>) -> Result<Self> {
        let settings = job.settings;
        let known = before.filter(|(_, measured_with)| same_lights(settings, measured_with));
        let mut shape = match known {
            Some((before, _)) if is_measured(settings) => {
                settings.validate_view()?;
                check_lights(job)?;
                with_measures(&base_shape(job)?, &before.shape)
            }
            _ => measured_shape(job)?,
        };
        shape.inspect = showing.inspect;
        Self::compile(job, shape, Some(showing))
    }

    /// Whether frames of the job's settings are the ones compiled, but for their constants. `measured_with` are the
    /// settings that the renderer was made with.
    ///
    /// # Errors
    /// [`crate::Error::Usage`] when the settings do not fit the device.
    pub fn fits(&self, job: &Job<'_>, measured_with: &Settings, showing: Showing) -> Result<bool> {
        let settings = job.settings;
        let base = FrameShape { inspect: showing.inspect, ..base_shape(job)? };
        let shape = if is_measured(settings) { with_measures(&base, &self.shape) } else { base };
        let same_window = self.shown.is_some_and(|(shown, _)| shown == showing);
        let same_kind =
            self.technique == settings.render.technique && is_measured(settings) == is_measured(measured_with);
        Ok(same_window
            && same_kind
            && shape == self.shape
            && (!is_measured(settings) || same_lights(settings, measured_with)))
    }

    /// Takes over the camera and whatever of the settings are constants of the frame.
    pub fn update(&mut self, job: &Job<'_>) {
        self.camera = job.camera.clone();
        self.seed = job.settings.tracing.seed;
        self.data = frame_data(job, &self.shape);
    }

    /// Replaces the scene's directional and spot lights with the next frame.
    pub fn update_lights(&mut self, lights: &[PunctualLight]) {
        self.executor.update_lights(bytemuck::cast_slice(lights).to_vec());
    }

    /// Which pixel the next frames tell about, when they do.
    pub fn inspect_pixel(&mut self, pixel: [u32; 2]) {
        self.data.accumulation[2..].copy_from_slice(&pixel);
    }

    /// Submits one frame into an image of the window.
    ///
    /// # Errors
    /// When the device is lost, and those of the overlay.
    pub fn submit_to(&mut self, shown: &mut Shown<'_>) -> Result<FrameTicket> {
        self.executor.submit_to(bytemuck::bytes_of(&self.data), shown)
    }

    /// What a completed frame has told; `None` for frames without a window.
    #[must_use]
    pub fn told(&self, result: &FrameResult) -> Option<Told> {
        let (_, layout) = self.shown?;
        let words = |offset: usize, count: usize| -> Option<Vec<u32>> {
            result.readback.get(offset..offset + 4 * count).map(bytemuck::pod_collect_to_vec)
        };
        let rays = words(layout.ray_count, 2)?;
        let top = self.shape.levels.top as usize;
        let table = layout.level_table.and_then(|offset| words(offset, 2 * top + 2));
        let inspected = layout.inspected.and_then(|offset| result.readback.get(offset..));
        Some(Told {
            exposure: f32::from_bits(words(layout.exposure, 1)?[0]),
            rays: [rays[0], rays[1]],
            vpls: layout.light_counts.and_then(|offset| Some(words(offset, 2)?[1])),
            levels: table.map_or_else(Vec::new, |table| (1..=top).map(|l| table[2 * l + 1]).collect()),
            inspected: inspected
                .and_then(|bytes| Some(bytemuck::pod_read_unaligned(bytes.get(..size_of::<InspectedPixel>())?))),
        })
    }
}

/// Whether two settings trace the same lights and build the same levels over them.
fn same_lights(a: &Settings, b: &Settings) -> bool {
    is_measured(a) == is_measured(b)
        && a.many_lights.traced() == b.many_lights.traced()
        && a.lgh.measured() == b.lgh.measured()
}

/// A shape with what another of the same lights was measured to need.
fn with_measures(shape: &FrameShape, measured: &FrameShape) -> FrameShape {
    FrameShape {
        levels: measured.levels,
        path_count: measured.path_count,
        vpl_capacity: measured.vpl_capacity,
        grid_capacity: measured.grid_capacity,
        upper_capacity: measured.upper_capacity,
        scatter: measured.scatter,
        ..shape.clone()
    }
}
