//! `temporal`: what the frames before know of the surfaces in sight, blended with this frame (section 4.3; Schied et al.
//! 2017). Histories are of the estimates before the filter: nothing filtered is fed back.

use super::gbuffer::{GBuffer, MotionImages};
use super::shadow_rays::{FORMAT, ShadowEstimates};
use super::{Extent, Frame, shader};
use crate::gpu::ComputeWork;
use crate::graph::{Access, History, ImageHandle, ImageInfo};
use crate::settings::{Antilag, ShadowEstimate, Temporal};
use crate::shared::TILE_SIZE;

/// Noisy light of a frame, or the same with what the frames before know of it.
#[derive(Clone, Copy, Debug)]
pub struct Light {
    /// Shadow estimates.
    pub estimates: ShadowEstimates,
    /// Unshadowed lighting per unit albedo, in the picture's layout.
    pub lighting: ImageHandle,
}

/// Images that are kept, or what was reprojected of them.
#[derive(Clone, Copy)]
struct Histories<T> {
    /// S; in alpha the number of frames.
    shadowed: T,
    /// U; in alpha the variance of one frame's shadowed luminance.
    unshadowed: T,
    /// Unshadowed lighting, in alpha the unit of the estimates. Only with [`Temporal::Indirect`].
    lighting: Option<T>,
}

/// What is taken over, and how.
#[derive(Clone, Copy, Debug)]
pub struct Reuse {
    /// Of what.
    pub mode: Temporal,
    /// Least weight of the newest frame.
    pub least_weight: f32,
    /// What is done where it is outdated.
    pub antilag: Antilag,
    /// Distance of pixels that do not share samples.
    pub step_px: u32,
}

/// Adds the passes.
pub fn add(frame: &mut Frame, gbuffer: &GBuffer, motion: MotionImages, reuse: Reuse, light: Light) -> Light {
    let mut history = |name: &str| frame.history_image(&format!("temporal_{name}"), FORMAT);
    let histories = Histories {
        shadowed: history("shadowed"),
        unshadowed: history("unshadowed"),
        lighting: (reuse.mode == Temporal::Indirect).then(|| history("lighting")),
    };
    let before = reproject(frame, gbuffer, motion, &histories);
    let given_up = (reuse.antilag == Antilag::Tiles).then(|| compare_tiles(frame, motion, light, before));
    let estimates = blend(frame, gbuffer, reuse, light, &histories, (before, given_up));
    let frames = histories.shadowed.current;
    let lighting = histories
        .lighting
        .zip(before.lighting)
        .map(|(history, before)| blend_lighting(frame, light, frames, before, history.current));
    Light { estimates, lighting: lighting.unwrap_or(light.lighting) }
}

fn reproject(
    frame: &mut Frame,
    gbuffer: &GBuffer,
    motion: MotionImages,
    histories: &Histories<History<ImageHandle>>,
) -> Histories<ImageHandle> {
    let mut image = |name: &str| frame.image(&format!("reprojected_{name}"), FORMAT);
    let found = Histories {
        shadowed: image("shadowed"),
        unshadowed: image("unshadowed"),
        lighting: histories.lighting.map(|_| image("lighting")),
    };
    let variant = if histories.lighting.is_some() { "_lighting" } else { "" };
    let work = shader(&format!("temporal/reproject{variant}"), frame.per_pixel());
    let mut pass = frame
        .compute("temporal/reproject", work)
        .bind("normals_image", gbuffer.normals, Access::ComputeSampled)
        .bind("motion_image", motion.motion, Access::ComputeSampled)
        .bind("previous_depth", motion.previous_depth, Access::ComputeSampled)
        .bind("previous_normals", motion.previous_normals, Access::ComputeSampled)
        .bind("previous_shadowed", histories.shadowed.previous, Access::ComputeSampled)
        .bind("previous_unshadowed", histories.unshadowed.previous, Access::ComputeSampled)
        .bind("out_shadowed", found.shadowed, Access::ComputeWrite)
        .bind("out_unshadowed", found.unshadowed, Access::ComputeWrite);
    if let Some((history, found)) = histories.lighting.zip(found.lighting) {
        pass = pass.bind("previous_lighting", history.previous, Access::ComputeSampled).bind(
            "out_lighting",
            found,
            Access::ComputeWrite,
        );
    }
    frame.graph.add_pass(pass);
    found
}

/// Gives an image with a texel for each tile: how much of the history is given up, in red.
fn compare_tiles(frame: &mut Frame, motion: MotionImages, light: Light, before: Histories<ImageHandle>) -> ImageHandle {
    let tile_count = [frame.shape.width_px, frame.shape.height_px].map(|edge| edge.div_ceil(TILE_SIZE));
    let per_tile = ImageInfo::new(FORMAT, tile_count[0], tile_count[1]);
    let sums = frame.graph.transient_image("tile_sums", per_tile);
    let work = ComputeWork {
        constants: vec![("KEEPS_LIGHT", u32::from(before.lighting.is_some()))],
        ..shader("temporal/sum_tiles", frame.per_pixel())
    };
    let pass = frame
        .compute("temporal/sum_tiles", work)
        .bind("shadowed_image", light.estimates.shadowed, Access::ComputeSampled)
        .bind("unshadowed_image", light.estimates.unshadowed, Access::ComputeSampled)
        .bind("reprojected_shadowed", before.shadowed, Access::ComputeSampled)
        .bind("out_sums", sums, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    let tiles = frame.graph.history_image("temporal_tiles", per_tile);
    let given_up = frame.graph.transient_image("given_up", per_tile);
    let pass = frame
        .compute("temporal/compare_tiles", shader("temporal/compare_tiles", Extent::Pixels(tile_count)))
        .bind("tile_sums", sums, Access::ComputeSampled)
        .bind("motion_image", motion.motion, Access::ComputeSampled)
        .bind("previous_tiles", tiles.previous, Access::ComputeSampled)
        .bind("out_tiles", tiles.current, Access::ComputeWrite)
        .bind("out_given_up", given_up, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    given_up
}

fn blend(
    frame: &mut Frame,
    gbuffer: &GBuffer,
    reuse: Reuse,
    light: Light,
    histories: &Histories<History<ImageHandle>>,
    (before, given_up): (Histories<ImageHandle>, Option<ImageHandle>),
) -> ShadowEstimates {
    let ShadowEstimates { shadowed, unshadowed, estimate, .. } = light.estimates;
    let blended = ["shadowed_blended", "unshadowed_blended"].map(|name| frame.image(name, FORMAT));
    let work = ComputeWork {
        constants: vec![
            ("KEEPS_LIGHT", u32::from(before.lighting.is_some())),
            // What is cut is lost to the mean.
            ("CUTS", u32::from(estimate != ShadowEstimate::Unbiased)),
            ("HAS_TILES", u32::from(given_up.is_some())),
        ],
        push: vec![reuse.step_px, reuse.least_weight.to_bits()],
        ..shader("temporal/blend", frame.per_pixel())
    };
    let pass = frame
        .compute("temporal/blend", work)
        .bind("depth_image", gbuffer.depth, Access::ComputeSampled)
        .bind("shadowed_image", shadowed, Access::ComputeSampled)
        .bind("unshadowed_image", unshadowed, Access::ComputeSampled)
        .bind("reprojected_shadowed", before.shadowed, Access::ComputeSampled)
        .bind("reprojected_unshadowed", before.unshadowed, Access::ComputeSampled)
        // What is not there is not read, but a binding needs an image.
        .bind("reprojected_lighting", before.lighting.unwrap_or(before.shadowed), Access::ComputeSampled)
        .bind("given_up_image", given_up.unwrap_or(before.shadowed), Access::ComputeSampled)
        .bind("history_shadowed", histories.shadowed.current, Access::ComputeWrite)
        .bind("history_unshadowed", histories.unshadowed.current, Access::ComputeWrite)
        .bind("out_shadowed", blended[0], Access::ComputeWrite)
        .bind("out_unshadowed", blended[1], Access::ComputeWrite);
    frame.graph.add_pass(pass);
    ShadowEstimates { shadowed: blended[0], unshadowed: blended[1], has_deviations: true, ..light.estimates }
}

/// `frames` has their number in alpha.
fn blend_lighting(
    frame: &mut Frame,
    light: Light,
    frames: ImageHandle,
    before: ImageHandle,
    history: ImageHandle,
) -> ImageHandle {
    let pass = frame
        .compute("temporal/blend_lighting", shader("temporal/blend_lighting", frame.per_pixel()))
        .bind("lighting_image", light.lighting, Access::ComputeSampled)
        .bind("unshadowed_image", light.estimates.unshadowed, Access::ComputeSampled)
        .bind("reprojected_lighting", before, Access::ComputeSampled)
        .bind("history_shadowed", frames, Access::ComputeSampled)
        .bind("history_lighting", history, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    history
}
