//! What the panel shows of everything else.

use super::history::History;
use crate::Result;
use crate::gpu::MemoryUse;
use crate::renderer::Renderer;
use crate::settings::{Settings, Size};

/// What is known when a frame begins.
pub struct Facts<'a> {
    /// Settings in use.
    pub settings: &'a Settings,
    /// Size of the picture.
    pub picture: Size,
    /// Size of the window.
    pub window_px: [u32; 2],
    /// Times.
    pub history: &'a History,
    /// Names that the times belong to.
    pub pass_names: Vec<String>,
    /// Memory of the frame.
    pub memory: MemoryUse,
    /// Memory reserved from the driver.
    pub reserved_bytes: u64,
    /// Name of the device.
    pub device: &'a str,
    /// Names of the scene's cameras.
    pub cameras: Vec<&'a str>,
    /// How far a scene is loaded.
    pub loading: Option<String>,
    /// Frames accumulated.
    pub accumulated: u32,
    /// Time stands still.
    pub paused: bool,
    /// Azimuth and elevation of the sun.
    pub sun_deg: Option<[f32; 2]>,
    /// Degrees in a second.
    pub sun_speed: f32,
    /// The picture's size follows the time that frames take.
    pub scale_is_chosen: bool,
}

/// What a frame counted.
pub struct Counts {
    /// Virtual point lights.
    pub vpls: u32,
    /// Lights of level 1, 2, ...
    pub levels: Vec<u32>,
    /// Rays of light paths and of shadows.
    pub rays: [u32; 2],
}

impl Counts {
    /// Reads what the last frame counted; waits.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn read(renderer: &Renderer) -> Result<Self> {
        let words = |buffer| -> Result<Vec<u32>> {
            Ok(bytemuck::pod_collect_to_vec(&renderer.executor().read_buffer(buffer)?))
        };
        let rays = words(renderer.outputs().ray_count)?;
        let mut counts = Self { vpls: 0, levels: Vec::new(), rays: [rays[0], rays[1]] };
        if let Some(hierarchy) = &renderer.outputs().hierarchy {
            counts.vpls = words(hierarchy.lights.counts)?[1];
            let table = words(hierarchy.grid.level_table)?;
            counts.levels = (1..=renderer.shape().levels.top as usize).map(|l| table[2 * l + 1]).collect();
        }
        Ok(counts)
    }
}
