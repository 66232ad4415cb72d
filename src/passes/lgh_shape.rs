//! What sizes the passes of the lighting grid hierarchy.

use ash::vk;

use super::light_shape::LightShape;
use super::temporal::Reuse;
use crate::light_grid::Levels;
use crate::light_grid::anchor::GridAnchor;
use crate::settings::{
    CenterWeight, FirstLevelBuild, GridUpdate, IndirectSize, LevelBuild, LightingMode, Lobe, Reservoir, ShadowEstimate,
    ShadowFilter, ShadowPoints,
};

/// Sizes, capacities and modes of the hierarchy and of what is lit by it.
#[derive(Clone, Debug, PartialEq)]
pub struct LghShape {
    /// The lights S0, and the reservoirs per pixel.
    pub lights: LightShape,
    /// Width and height of the picture, or of the half one that indirect light is found for.
    pub picture_px: [u32; 2],
    /// How many pixels indirect light is found for.
    pub indirect_size: IndirectSize,
    /// Interleaved sampling: n x n sub-images.
    pub interleave: u32,
    /// Levels of the hierarchy.
    pub levels: Levels,
    /// Where the grids stand; `None` is around the lights of each frame.
    pub anchor: Option<GridAnchor>,
    /// How grid lights send out their flux.
    pub lobe: Lobe,
    /// Where grid lights are.
    pub center: CenterWeight,
    /// First level used for lighting, 0 or 1.
    pub first_level: u32,
    /// Grid lights that fit, all levels together.
    pub grid_capacity: u32,
    /// Grid lights above S1 that fit.
    pub upper_capacity: u32,
    /// Where shadow rays end.
    pub shadow_points: ShadowPoints,
    /// What is made of the shadow samples.
    pub shadow_estimate: ShadowEstimate,
    /// How lights reach the pixels.
    pub lighting: LightingMode,
    /// How reservoirs are updated; `Exact` where lights are gathered.
    pub reservoir: Reservoir,
    /// How levels above S1 are built.
    pub build: LevelBuild,
    /// How lights are summed into S1; `Atomic` with `LevelBuild::Scatter`.
    pub scatter: FirstLevelBuild,
    /// Whether S1 may go on from the last one (`Auto`), with lights `Sorted` alone.
    pub grid_update: GridUpdate,
    /// Filter of the shadow estimates.
    pub filter: ShadowFilter,
    /// What is taken over from the frames before, if anything.
    pub reuse: Option<Reuse>,
    /// Format of the additively blended lighting.
    pub lighting_format: vk::Format,
    /// Count the lights that each pixel tests (slower; for statistics frames).
    pub count_lights_tested: bool,
}

impl LghShape {
    /// Whether there are passes that update S1.
    #[must_use]
    pub fn is_updated(&self) -> bool {
        self.grid_update != GridUpdate::Full
            && self.scatter == FirstLevelBuild::Sorted
            && self.build != LevelBuild::Scatter
    }

    /// The specialization constant that says how lights weigh where a grid light is.
    #[must_use]
    pub fn center_constant(&self) -> (&'static str, u32) {
        ("UNIFORM_CENTER", (self.center == CenterWeight::Uniform).into())
    }

    /// Size of one interleaved sub-image.
    #[must_use]
    pub fn sub_image_px(&self) -> [u32; 2] {
        self.picture_px.map(|edge| edge.div_ceil(self.interleave))
    }

    /// Size of the interleaved layout: all sub-images side by side.
    #[must_use]
    pub fn interleaved_px(&self) -> [u32; 2] {
        self.sub_image_px().map(|edge| edge * self.interleave)
    }
}
