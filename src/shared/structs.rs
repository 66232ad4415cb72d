//! Structs that shaders read: `repr(C)`, no implicit padding, no bare `vec3` in GLSL. `tests/layout.rs`
//! compares every offset with the SPIR-V.

use bytemuck::{Pod, Zeroable};

use super::{MAX_LEVEL, MAX_SHADOW_SAMPLES};

/// Rows of [`FrameData::levels`].
pub const LEVEL_ROWS: usize = MAX_LEVEL as usize + 2;

/// The frame's constants, a uniform buffer (`common/frame.glsl`, std140).
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct FrameData {
    /// Reversed-Z, infinite far plane, column major.
    pub clip_from_world: [[f32; 4]; 4],
    /// Eye position; near plane distance.
    pub eye_near: [f32; 4],
    /// Viewing direction; horizontal offset of the sampling points from the pixel centres, in pixels.
    pub forward: [f32; 4],
    /// Right vector times tan(half horizontal field of view); the rasteriser's vertex step at distance 1.
    pub right: [f32; 4],
    /// Up vector times tan(half vertical field of view); vertical offset of the sampling points, downwards.
    pub up: [f32; 4],
    /// Scene centre; scene radius.
    pub scene_sphere: [f32; 4],
    /// Image size in pixels; size of one interleaved sub-image.
    pub size: [u32; 4],
    /// Interleave n; shadow samples k; first level for shadow samples; first level used for lighting.
    pub sampling: [u32; 4],
    /// Lmax; VPL capacity; path count; most bounces.
    pub counts: [u32; 4],
    /// Seed; lights in the direct pass; first scene light of the hierarchy; scene lights of the hierarchy.
    pub lights: [u32; 4],
    /// Alpha; squared singularity clamp; exposure (0 = automatic); ray offset.
    pub tuning: [f32; 4],
    /// Number of the frame among those accumulated, from 0; seed of the shadow samples; the pixel that is
    /// inspected.
    pub accumulation: [u32; 4],
    /// Per level 0..=MAX_LEVEL+1: vertices per axis; words per row; first word; first word of the next level.
    pub levels: [[u32; 4]; LEVEL_ROWS],
}

/// A material as traced rays see it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct GpuMaterial {
    /// Linear base-colour factor.
    pub base_color: [f32; 4],
    /// Layer of the albedo array or `NO_LAYER`.
    pub albedo_layer: u32,
    /// Holes below this alpha; negative when opaque.
    pub alpha_cutoff: f32,
    /// glTF normal scale.
    pub normal_scale: f32,
    /// 1 when the material has a normal map.
    pub has_normal_map: u32,
}

/// A light of the scene file.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct PunctualLight {
    /// Position (unused for directional lights).
    pub position_ws: [f32; 3],
    /// `LIGHT_DIRECTIONAL`, `LIGHT_POINT` or `LIGHT_SPOT`.
    pub kind: u32,
    /// Unit direction of travel.
    pub direction_ws: [f32; 3],
    /// Cosine of the inner cone.
    pub inner_cos: f32,
    /// Irradiance (directional) or radiant intensity.
    pub intensity: [f32; 3],
    /// Cosine of the outer cone.
    pub outer_cos: f32,
    /// Light paths up to this fraction of all start at this light or one before it.
    pub path_cdf: f32,
    /// Fraction of the paths that start here.
    pub path_probability: f32,
    /// Unused.
    pub padding: [f32; 2],
}

/// A light of the hierarchy: S0 (VPLs and scene lights), S1 and up. Radiant intensity towards the unit
/// direction w is `flux / pi * ((1 - |lobe|) / 4 + max(dot(lobe, w), 0))`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct GridLight {
    /// Illumination centre.
    pub position_ws: [f32; 3],
    /// Sum of luminance weights (linear, unnormalised): Σ w·m.
    pub luminance: f32,
    /// Position variance per axis.
    pub variance: [f32; 3],
    /// Level, 0..=Lmax.
    pub level: u32,
    /// Luminance-weighted mean normal, length 0 (isotropic) to 1 (one direction).
    pub lobe: [f32; 3],
    /// Sum of trilinear weights.
    pub weight: f32,
    /// Flux, RGB.
    pub flux: [f32; 3],
    /// Index of the grid vertex within its level.
    pub vertex: u32,
}

/// The grid's placement, computed on the GPU from the lights' bounds.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct GridPlacement {
    /// Corner of vertex (0, 0, 0) of every level.
    pub origin_ws: [f32; 3],
    /// Edge of the top level's cell.
    pub h_top: f32,
    /// `1 / h_top`.
    pub inverse_h_top: f32,
    /// Largest component of any light's flux: the unit of the fixed-point sums.
    pub flux_scale: f32,
    /// Lights in S0.
    pub light_count: u32,
    /// Unused.
    pub padding: u32,
}

/// What the lights of one level send to an inspected pixel.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct InspectedLevel {
    /// Lights that contribute.
    pub count: u32,
    /// Those of them whose blending weight is below 1.
    pub blended: u32,
    /// Sum of the blending weights.
    pub weight: f32,
    /// Luminance of the unshadowed lighting per unit albedo.
    pub lighting: f32,
    /// Merged light that contributes most, or `NO_LIGHT`.
    pub strongest: u32,
    /// What it contributes.
    pub strongest_lighting: f32,
    /// How far away it is.
    pub strongest_distance: f32,
    /// Its blending weight.
    pub strongest_weight: f32,
}

/// A shadow sample of an inspected pixel.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct InspectedSample {
    /// Where the shadow ray ends.
    pub position_ws: [f32; 3],
    /// Merged light in the reservoir, or `NO_LIGHT`.
    pub light: u32,
    /// Luminance of the estimate of the unshadowed lighting, relative to the sum over all lights.
    pub estimate: f32,
    /// Level of the light.
    pub level: u32,
    /// One of `SAMPLE_*`.
    pub state: u32,
    /// Length of the ray.
    pub distance: f32,
}

/// Everything about one pixel (pass `inspect`). Only `pixel`, `found` and `radiance` where there is no surface.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct InspectedPixel {
    /// The pixel, row 0 at the top.
    pub pixel: [u32; 2],
    /// 1 when there is a surface.
    pub found: u32,
    /// Shadow samples.
    pub sample_count: u32,
    /// Position.
    pub position_ws: [f32; 3],
    /// Distance along the viewing direction.
    pub depth: f32,
    /// Shading normal.
    pub normal: [f32; 3],
    /// Levels of the hierarchy, level 0 included; 0 without one.
    pub level_count: u32,
    /// Normal of the triangle.
    pub geometric_normal: [f32; 3],
    /// Sum of f over all lights that samples are picked from.
    pub total: f32,
    /// Linear base colour.
    pub albedo: [f32; 3],
    /// Unused.
    pub padding: f32,
    /// Linear radiance, or the values of a view.
    pub radiance: [f32; 4],
    /// Direct light in it.
    pub direct: [f32; 4],
    /// Unshadowed indirect lighting per unit albedo.
    pub lighting: [f32; 4],
    /// Filtered shadow ratio S / U.
    pub shadow_ratio: [f32; 4],
    /// By level.
    pub levels: [InspectedLevel; MAX_LEVEL as usize + 1],
    /// By reservoir.
    pub samples: [InspectedSample; MAX_SHADOW_SAMPLES as usize],
}

const _: () = {
    assert!(size_of::<InspectedPixel>() == 144 + 32 * (MAX_LEVEL + 1 + MAX_SHADOW_SAMPLES) as usize);
    assert!(size_of::<GpuMaterial>() == 32);
    assert!(size_of::<PunctualLight>() == 64);
    assert!(size_of::<GridLight>() == 64);
    assert!(size_of::<GridPlacement>() == 32);
    assert!(size_of::<FrameData>() == 64 + 16 * 11 + 16 * LEVEL_ROWS);
};
