//! `temporal`: what the frames before know of the surfaces in sight, blended with this frame (section 4.3; Schied et al.
//! 2017). Histories are of the estimates before the filter: nothing filtered is fed back.

use super::gbuffer::{GBuffer, MotionImages};
use super::rounds::{self, Round};
use super::shadow_rays::{FORMAT, ShadowEstimates};
use super::{Extent, Frame, shader};
use crate::gpu::ComputeWork;
use crate::graph::{Access, BufferHandle, History, ImageHandle, ImageInfo};
use crate::settings::{Antilag, ShadowEstimate};
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
    /// Unshadowed lighting, in alpha the unit of the estimates. Only with [`Estimated::Light`].
    lighting: Option<T>,
}

/// What estimates are of, and with them the histories.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Estimated {
    /// Shadows, per unit of the frame's own unshadowed light.
    Shadows,
    /// The same, but histories are of light itself, that of the frames before.
    Light,
    /// Light that is not known but by these estimates; their unit is 1.
    Radiance,
}

impl Estimated {
    fn constants(self) -> Vec<(&'static str, u32)> {
        vec![("KEEPS_LIGHT", u32::from(self == Self::Light)), ("IS_RADIANCE", u32::from(self == Self::Radiance))]
    }
}

/// What is taken over, and how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reuse {
    /// Of what.
    pub of: Estimated,
    /// Least weight of the newest frame.
    pub least_weight: f32,
    /// What is done where it is outdated.
    pub antilag: Antilag,
    /// Distance of pixels that do not share samples.
    pub step_px: u32,
    /// Rounds of shadow samples in a frame without history; in others further ones are for pixels whose history is short.
    pub rounds: u32,
}

impl Reuse {
    /// Frames that rounds make up at most. No history grows beyond what its weights allow.
    #[must_use]
    pub fn enough_frames(&self) -> f32 {
        (self.rounds as f32).min(1.0 / self.least_weight)
    }

    /// The number of the last round.
    #[must_use]
    pub fn last_round(&self) -> u32 {
        self.enough_frames().ceil() as u32
    }
}

/// What a frame and those before it know.
#[derive(Clone, Debug)]
pub struct Blended {
    /// The same for the filter.
    pub light: Light,
    /// The means, with the number of frames in alpha of the first.
    pub histories: [ImageHandle; 2],
    /// Tiles that take part in each further round of samples.
    pub round_tiles: Vec<BufferHandle>,
}

/// Adds the passes for shadows of lighting.
pub fn add(frame: &mut Frame, gbuffer: &GBuffer, motion: MotionImages, reuse: Reuse, light: Light) -> Blended {
    let round_tiles = rounds::declare_tiles(frame, reuse);
    let first_tiles = round_tiles.first().copied();
    let (estimates, histories, before) = blend_estimates(frame, gbuffer, motion, reuse, light.estimates, first_tiles);
    let frames = histories.shadowed.current;
    let lighting = histories
        .lighting
        .zip(before.lighting)
        .map(|(history, before)| blend_lighting(frame, light, frames, before, history.current));
    Blended {
        light: Light { estimates, lighting: lighting.unwrap_or(light.lighting) },
        histories: [frames, histories.unshadowed.current],
        round_tiles,
    }
}

/// Adds the pass that blends the estimates of a further round of samples into what is known, where these are short of frames.
pub fn add_round(
    frame: &mut Frame,
    gbuffer: &GBuffer,
    reuse: Reuse,
    estimates: ShadowEstimates,
    blended: &Blended,
    round: Round,
) {
    let [shadowed, unshadowed] = blended.histories;
    let variant = if round.next_tiles.is_some() { "round" } else { "last_round" };
    let work = ComputeWork {
        constants: blend_constants(reuse, estimates),
        push: vec![reuse.step_px, reuse.least_weight.to_bits(), round.enough_frames.to_bits()],
        ..shader(&format!("temporal/blend_{variant}"), round.dispatch())
    };
    let mut pass = frame
        .compute(&format!("temporal/blend/{}", round.number), work)
        .bind("depth_image", gbuffer.depth, Access::ComputeSampled)
        .bind("shadowed_image", estimates.shadowed, Access::ComputeSampled)
        .bind("unshadowed_image", estimates.unshadowed, Access::ComputeSampled)
        .bind("history_shadowed", shadowed, Access::ComputeReadWrite)
        .bind("history_unshadowed", unshadowed, Access::ComputeReadWrite)
        // Written in part.
        .bind("out_shadowed", blended.light.estimates.shadowed, Access::ComputeReadWrite)
        .bind("out_unshadowed", blended.light.estimates.unshadowed, Access::ComputeReadWrite);
    if let Some(tiles) = round.next_tiles {
        pass = pass.bind("next_tiles", tiles, Access::ComputeReadWrite);
    }
    frame.graph.add_pass(round.listed(pass));
}

fn blend_constants(reuse: Reuse, estimates: ShadowEstimates) -> Vec<(&'static str, u32)> {
    let mut constants = reuse.of.constants();
    // What is cut is lost to the mean.
    constants.push(("CUTS", u32::from(estimates.estimate != ShadowEstimate::Unbiased)));
    constants
}

/// Adds the passes for estimates that are light by themselves.
pub fn add_radiance(
    frame: &mut Frame,
    gbuffer: &GBuffer,
    motion: MotionImages,
    reuse: Reuse,
    estimates: ShadowEstimates,
) -> ShadowEstimates {
    let reuse = Reuse { of: Estimated::Radiance, step_px: 1, rounds: 1, ..reuse };
    blend_estimates(frame, gbuffer, motion, reuse, estimates, None).0
}

/// Gives the estimates for the filter, the histories, and what was reprojected of them.
fn blend_estimates(
    frame: &mut Frame,
    gbuffer: &GBuffer,
    motion: MotionImages,
    reuse: Reuse,
    estimates: ShadowEstimates,
    round_tiles: Option<BufferHandle>,
) -> (ShadowEstimates, Histories<History<ImageHandle>>, Histories<ImageHandle>) {
    let label = estimates.label;
    let mut history = |name: &str| frame.history_image(&format!("{label}temporal_{name}"), FORMAT);
    let histories = Histories {
        shadowed: history("shadowed"),
        unshadowed: history("unshadowed"),
        lighting: (reuse.of == Estimated::Light).then(|| history("lighting")),
    };
    let before = reproject(frame, gbuffer, motion, label, &histories);
    let has_tiles = reuse.antilag == Antilag::Tiles;
    let given_up = has_tiles.then(|| compare_tiles(frame, motion, reuse.of, estimates, before));
    let blended = blend(frame, gbuffer, (reuse, round_tiles), estimates, &histories, (before, given_up));
    (blended, histories, before)
}

fn reproject(
    frame: &mut Frame,
    gbuffer: &GBuffer,
    motion: MotionImages,
    label: &str,
    histories: &Histories<History<ImageHandle>>,
) -> Histories<ImageHandle> {
    let mut image = |name: &str| frame.image(&format!("{label}reprojected_{name}"), FORMAT);
    let found = Histories {
        shadowed: image("shadowed"),
        unshadowed: image("unshadowed"),
        lighting: histories.lighting.map(|_| image("lighting")),
    };
    let variant = if histories.lighting.is_some() { "_lighting" } else { "" };
    let work = shader(&format!("temporal/reproject{variant}"), frame.per_pixel());
    let mut pass = frame
        .compute(&format!("temporal/{label}reproject"), work)
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
fn compare_tiles(
    frame: &mut Frame,
    motion: MotionImages,
    of: Estimated,
    estimates: ShadowEstimates,
    before: Histories<ImageHandle>,
) -> ImageHandle {
    let label = estimates.label;
    let tile_count = [frame.shape.width_px, frame.shape.height_px].map(|edge| edge.div_ceil(TILE_SIZE));
    let per_tile = ImageInfo::new(FORMAT, tile_count[0], tile_count[1]);
    let sums = frame.graph.transient_image(&format!("{label}tile_sums"), per_tile);
    let work = ComputeWork { constants: of.constants(), ..shader("temporal/sum_tiles", frame.per_pixel()) };
    let pass = frame
        .compute(&format!("temporal/{label}sum_tiles"), work)
        .bind("shadowed_image", estimates.shadowed, Access::ComputeSampled)
        .bind("unshadowed_image", estimates.unshadowed, Access::ComputeSampled)
        .bind("reprojected_shadowed", before.shadowed, Access::ComputeSampled)
        .bind("reprojected_unshadowed", before.unshadowed, Access::ComputeSampled)
        .bind("out_sums", sums, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    let tiles = frame.graph.history_image(&format!("{label}temporal_tiles"), per_tile);
    let given_up = frame.graph.transient_image(&format!("{label}given_up"), per_tile);
    let pass = frame
        .compute(
            &format!("temporal/{label}compare_tiles"),
            shader("temporal/compare_tiles", Extent::Pixels(tile_count)),
        )
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
    (reuse, round_tiles): (Reuse, Option<BufferHandle>),
    estimates: ShadowEstimates,
    histories: &Histories<History<ImageHandle>>,
    (before, given_up): (Histories<ImageHandle>, Option<ImageHandle>),
) -> ShadowEstimates {
    let ShadowEstimates { shadowed, unshadowed, label, .. } = estimates;
    let blended = ["shadowed", "unshadowed"].map(|name| frame.image(&format!("{label}{name}_blended"), FORMAT));
    let mut constants = blend_constants(reuse, estimates);
    constants.push(("HAS_TILES", u32::from(given_up.is_some())));
    let mut push = vec![reuse.step_px, reuse.least_weight.to_bits()];
    push.extend(round_tiles.map(|_| reuse.enough_frames().to_bits()));
    let variant = if round_tiles.is_some() { "_rounds" } else { "" };
    let work = ComputeWork { constants, push, ..shader(&format!("temporal/blend{variant}"), frame.per_pixel()) };
    let mut pass = frame
        .compute(&format!("temporal/{label}blend"), work)
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
    if let Some(tiles) = round_tiles {
        pass = pass.bind("next_tiles", tiles, Access::ComputeReadWrite);
    }
    frame.graph.add_pass(pass);
    ShadowEstimates { shadowed: blended[0], unshadowed: blended[1], has_deviations: true, ..estimates }
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
