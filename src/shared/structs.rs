//! Structs that shaders read, declared once: GLSL includes `shared/<name>.glsl`, which is generated from here. No implicit
//! padding: a `vec3` is followed by a scalar. `tests/layout.rs` compares every offset with the SPIR-V.

use std::mem::offset_of;

use bytemuck::{Pod, Zeroable};

use super::table::{FieldInfo, FieldType, SharedStruct, StructInfo, shared_structs};
use super::{MAX_LEVEL, MAX_SHADOW_SAMPLES, PRIMARY_EDGE};

/// Rows of [`FrameData::levels`].
pub const LEVEL_ROWS: usize = MAX_LEVEL as usize + 2;

shared_structs! {
    /// The frame's constants, a uniform buffer (`common/frame.glsl`, std140). Vectors and positions are in world space.
    pub struct FrameData as "FrameData" {
        /// Reversed-Z, infinite far plane, column major.
        pub clip_from_world: [[f32; 4]; 4],
        /// Eye position.
        pub eye_ws: [f32; 3],
        /// Near plane distance.
        pub near: f32,
        /// Viewing direction.
        pub forward_ws: [f32; 3],
        /// Horizontal offset of the sampling points from the pixel centres, in pixels.
        pub jitter_x_px: f32,
        /// Right vector times tan(half horizontal field of view).
        pub right_ws: [f32; 3],
        /// The rasteriser's vertex step at distance 1.
        pub rasteriser_step: f32,
        /// Up vector times tan(half vertical field of view).
        pub up_ws: [f32; 3],
        /// Vertical offset of the sampling points, downwards, in pixels.
        pub jitter_y_px: f32,
        /// Centre of the scene's bounds.
        pub scene_center_ws: [f32; 3],
        /// Radius of the scene's bounds.
        pub scene_radius: f32,
        /// Image size.
        pub size_px: [u32; 2],
        /// Size of one interleaved sub-image.
        pub sub_image_px: [u32; 2],
        /// Interleave n.
        pub interleave: u32,
        /// Shadow samples k.
        pub shadow_samples: u32,
        /// First level for shadow samples.
        pub shadow_from: u32,
        /// First level used for lighting.
        pub first_level: u32,
        /// Lmax.
        pub top_level: u32,
        /// VPLs that fit.
        pub vpl_capacity: u32,
        /// Light paths.
        pub path_count: u32,
        /// Most bounces of a path.
        pub bounces: u32,
        /// Seed of the light paths.
        pub seed: u32,
        /// Lights in the direct pass.
        pub direct_lights: u32,
        /// First scene light of the hierarchy.
        pub first_point_light: u32,
        /// Scene lights of the hierarchy.
        pub scene_lights: u32,
        /// Alpha: blending radius over cell edge.
        pub alpha: f32,
        /// Squared distance below which lights do not grow brighter, in square metres.
        pub clamp_squared: f32,
        /// Exposure without compensation. Below 0 it is automatic, and at most the negative of this; 0 is automatic
        /// without a bound.
        pub exposure: f32,
        /// Longest edge of any triangle's bounding box, in metres.
        pub largest_triangle: f32,
        /// Number of the frame among those accumulated, from 0.
        pub accumulated_frame: u32,
        /// Seed of the shadow samples.
        pub sampling_seed: u32,
        /// The pixel that is inspected.
        pub inspected_pixel: [u32; 2],
        /// Cells in a row of the environment's table, and rows; 0 where nothing comes from the environment.
        pub environment_cells: [u32; 2],
        /// Radiance of the environment over what its image holds.
        pub environment_scale: f32,
        /// How far the environment is turned about +y, counterclockwise seen from above, in turns.
        pub environment_turn: f32,
        /// Per level 0..=MAX_LEVEL+1: vertices per axis; words per row; first word; first word of the next level.
        pub levels: [[u32; 4]; LEVEL_ROWS],
        /// Of the frame before, `eye_ws`; this frame's own where the history is not valid.
        pub previous_eye_ws: [f32; 3],
        /// 1 when history resources hold what the frame before left, 0 in a first frame, after a cut,
        /// and where nothing is kept.
        pub history_is_valid: u32,
        /// Factor on whatever the exposure is: 2 to the power of the stops of compensation.
        pub exposure_compensation: f32,
        /// One of `TONE_MAP_*`.
        pub tone_map: u32,
        /// Share of the light paths that start at the environment.
        pub environment_share: f32,
        /// Leaves of the points' tree, a power of two; 0 without points.
        pub point_leaf_count: u32,
        /// Radius of a leaf's disc.
        pub point_leaf_radius: f32,
        /// A node is a primary point when its sphere has at most this radius in the picture, in pixels,
        pub primary_radius_px: f32,
        /// and the cosine of its cone of normals is at least this.
        pub primary_cone_cos: f32,
        /// A hit of a micro-buffer becomes a node that subtends at most so many of its texels,
        pub hit_texels: f32,
        /// and whose cone of normals has at least this cosine.
        pub hit_cone_cos: f32,
        /// Leaves of a node from which suns and lamps are looked for.
        pub sun_leaves: u32,
        /// Reach of a radiance cache over the radius of its point.
        pub cache_reach: f32,
        /// Cosine of the angle between normals beyond which a radiance cache says nothing.
        pub cache_cone_cos: f32,
        /// 1 when the camera looks through backs of single-sided surfaces.
        pub culls_back_faces: u32,
        /// Triangles that shine by themselves.
        pub emitter_count: u32,
        /// 1 when the frame before has left its history, and neither lights nor settings have changed since, whatever
        /// the camera does.
        pub scene_stands: u32,
        /// VPLs whose flux has more luminance than this stand for larger discs, and their `clamp_squared` is as much larger.
        pub large_vpl_luminance: f32,
        /// Of the frame before, `forward_ws`; like all of these this frame's own where the history is not valid.
        pub previous_forward_ws: [f32; 3],
        /// Of the frame before, `near`.
        pub previous_near: f32,
        /// Of the frame before, `right_ws`.
        pub previous_right_ws: [f32; 3],
        /// 1 when vertices of the scene have moved since the frame before, and `previous_vertices` has where they were.
        pub vertices_moved: u32,
        /// Of the frame before, `up_ws`.
        pub previous_up_ws: [f32; 3],
        /// Where light paths are renewed a few at a time, how many have been renewed so far, and `path_count` more; else 0.
        pub renewed_paths: u32,
        /// Of the frame before, `jitter_x_px` and `jitter_y_px`.
        pub previous_jitter_px: [f32; 2],
        /// 1 when the frame before has left its history, and lights and surfaces are as they were in it, whatever the camera
        /// does and the light paths.
        pub lighting_stands: u32,
        /// Unused.
        pub padding: u32,
    }

    /// A material as traced rays see it.
    pub struct GpuMaterial as "Material" {
        /// Linear base-colour factor.
        pub base_color: [f32; 4],
        /// Layer of the albedo array or `NO_LAYER`.
        pub albedo_layer: u32,
        /// Holes below this alpha; negative when opaque.
        pub alpha_cutoff: f32,
        /// glTF normal scale.
        pub normal_scale: f32,
        /// `MATERIAL_` bits.
        pub flags: u32,
        /// Radiance that it sends out by itself, a factor of the texture in `emission_layer`.
        pub emission: [f32; 3],
        /// Layer of the albedo array with the emission, or `NO_LAYER`.
        pub emission_layer: u32,
    }

    /// A triangle that shines by itself.
    pub struct Emitter as "Emitter" {
        /// Which triangle of the scene.
        pub triangle: u32,
        /// Its material.
        pub material: u32,
        /// Probability of those before it.
        pub first: f32,
        /// Probability with which a point on surfaces that shine is on it, above 0.
        pub probability: f32,
    }

    /// What a texel of a micro-buffer stands for (`micro_buffers::table`).
    pub struct MicroTexel as "MicroTexel" {
        /// Mean direction, unit, in the frame of the point: z is its normal.
        pub direction: [f32; 3],
        /// Solid angle in steradians; 0 where no direction lies in the texel.
        pub solid_angle: f32,
        /// Integral of the cosine over its directions.
        pub cosine_weight: f32,
        /// Level of the environment's means that has the size of the texel.
        pub environment_level: f32,
        /// Unused.
        pub padding: [f32; 2],
    }

    /// Where a cache of light stands.
    pub struct CachePlace as "CachePlace" {
        /// Off its surface.
        pub position_ws: [f32; 3],
        /// Radius of the sphere in which it lights, in metres.
        pub reach: f32,
        /// Unit normal.
        pub normal_ws: [f32; 3],
        /// The side of a node that it belongs to.
        pub key: u32,
        /// Unit tangent, the x axis of its lobes.
        pub tangent_ws: [f32; 3],
        /// Unused.
        pub padding: u32,
    }

    /// A point as views draw it.
    pub struct ShownPoint as "ShownPoint" {
        /// On its surface.
        pub position_ws: [f32; 3],
        /// Of a disc of its area, in metres.
        pub radius: f32,
        /// Unit normal of its side.
        pub normal: [f32; 3],
        /// What is told of it << 24 | key.
        pub number_and_key: u32,
    }

    /// What the caches were not enough for.
    pub struct CacheCounts as "CacheCounts" {
        /// Caches that tiles had no room for.
        pub lost_references: u32,
        /// Pixels without a cache within its reach.
        pub stretched_pixels: u32,
        /// Of these, pixels without one within twice its reach, which got the light of the nearest.
        pub nearest_pixels: u32,
        /// Pixels without a cache in their tile.
        pub black_pixels: u32,
    }

    /// A light of the scene file.
    pub struct PunctualLight as "PunctualLight" {
        /// Position (unused for directional lights).
        pub position_ws: [f32; 3],
        /// `LIGHT_DIRECTIONAL`, `LIGHT_POINT`, `LIGHT_SPOT`, or `LIGHT_EMITTERS`, which has no place and comes last.
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

    /// A part of the unit cube of the numbers that say where a light path starts, and how many of the paths start there.
    pub struct StartCell as "StartCell" {
        /// Its lowest corner: position in the order of the lights, and the light's two numbers.
        pub low: [f32; 3],
        /// Share of the paths in the cells before it.
        pub first: f32,
        /// Its edges.
        pub size: [f32; 3],
        /// Share of the paths that start in it, above 0.
        pub share: f32,
    }

    /// How much light one start of a light path would bring to the picture.
    pub struct StartSample as "StartSample" {
        /// The start: position in the order of the lights, and the light's two numbers.
        pub start: [f32; 3],
        /// Luminance that the visible point receives by it, per unit albedo; 0 where there is none.
        pub light: f32,
    }

    /// How many points are lit.
    pub struct PointCounts as "PointCounts" {
        /// Primary points in their list.
        pub primary_count: u32,
        /// Primary points that have no room there.
        pub primaries_lost: u32,
        /// Sides in the list of those that need a micro-buffer of their own.
        pub needed_count: u32,
        /// Sides that have no room there.
        pub needed_lost: u32,
        /// Sides that micro-buffers see.
        pub seen_count: u32,
        /// Primary points that see what they saw in the frame before, with `--reuse`.
        pub primaries_kept: u32,
        /// Sides that keep the light of the frame before, which are not in the list of those that need a micro-buffer.
        pub needed_kept: u32,
    }

    /// A light of the hierarchy: S0 (VPLs and scene lights), S1 and up. Radiant intensity towards the unit
    /// direction w is `flux / pi * ((1 - |lobe|) / 4 + max(dot(lobe, w), 0))`.
    pub struct GridLight as "GridLight" {
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
    pub struct GridPlacement as "GridPlacement" {
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

    /// What S1 was last built of, for the next build to go on from.
    pub struct BuiltGrid as "BuiltGrid" {
        /// Corner of vertex (0, 0, 0).
        pub origin_ws: [f32; 3],
        /// Edge of the top level's cell.
        pub h_top: f32,
        /// Unit of the fixed-point sums.
        pub flux_scale: f32,
        /// Lights in S0.
        pub light_count: u32,
        /// VPLs among them.
        pub vpl_count: u32,
        /// Vertices of S1; 0 where nothing has been built, or not all of them had room.
        pub vertex_count: u32,
    }

    /// What the lights of one level send to an inspected pixel.
    pub struct InspectedLevel as "InspectedLevel" {
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
    pub struct InspectedSample as "InspectedSample" {
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

    /// A texel of a micro-buffer of an inspected pixel.
    pub struct InspectedTexel as "InspectedTexel" {
        /// Of the environment and of surfaces.
        pub radiance: [f32; 3],
        /// How much of it surfaces cover; -1 where no direction lies in it.
        pub coverage: f32,
    }

    /// Everything about one pixel (pass `inspect`). Only `pixel`, `found` and `radiance` where there is no surface.
    pub struct InspectedPixel as "InspectedPixel" {
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
        /// Light of the environment in that.
        pub environment: [f32; 4],
        /// Unshadowed indirect lighting per unit albedo.
        pub lighting: [f32; 4],
        /// Filtered shadow ratio S / U.
        pub shadow_ratio: [f32; 4],
        /// By level.
        pub levels: [InspectedLevel; MAX_LEVEL as usize + 1],
        /// By reservoir.
        pub samples: [InspectedSample; MAX_SHADOW_SAMPLES as usize],
        /// Caches of light that light it.
        pub cache_count: u32,
        /// The one of them that counts most, by its place among the primary points.
        pub cache_slot: u32,
        /// Its key.
        pub cache_key: u32,
        /// Its share in the light.
        pub cache_share: f32,
        /// What it sees, row by row.
        pub cache_texels: [InspectedTexel; (PRIMARY_EDGE * PRIMARY_EDGE) as usize],
    }
}

const _: () = {
    assert!(
        size_of::<InspectedPixel>()
            == 176 + 32 * (MAX_LEVEL + 1 + MAX_SHADOW_SAMPLES) as usize + 16 * (PRIMARY_EDGE * PRIMARY_EDGE) as usize
    );
    assert!(size_of::<GpuMaterial>() == 48);
    assert!(size_of::<PunctualLight>() == 64);
    assert!(size_of::<GridLight>() == 64);
    assert!(size_of::<GridPlacement>() == 32);
    assert!(size_of::<FrameData>() == 64 + 16 * 12 + 16 * LEVEL_ROWS + 144);
};
