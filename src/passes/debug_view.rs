//! `debug_view`: intermediate results as pictures (`docs/views.md`). Each function gives an image of values: what an
//! EXR holds in rgb, and in alpha the number that a colour map shows, below 0 where there is none.

use ash::vk;

use super::compaction::Lights;
use super::gbuffer::GBuffer;
use super::lgh_shape::LghShape;
use super::light_shape::LightShape;
use super::merge::MergedLights;
use super::tone_map::{self, ToneMapped};
use super::{Frame, shader};
use crate::gpu::{
    ColorTarget, ComputeWork, DepthTarget, Dispatch, DrawCall, RasterDraw, RasterState, RasterWork, Viewport, Work,
};
use crate::graph::{Access, BufferHandle, ImageHandle, ImageInfo, Pass};
use crate::settings::{Reservoir, View};
use crate::shared::TILE_SIZE;
use crate::views::{LEVEL_COLORS, MAX_COLORS, NO_VALUE, color_map};

/// Lights that one dispatch of [`sum_lights`] may visit, all workgroups together: below a second on two CPU cores.
const VISITS_PER_DISPATCH: u64 = 15_000_000;
/// Diameter of a light's disc in a picture 640 pixels wide, pixels.
const POINT_PX: f32 = 2.5;

/// What [`show_surface`] shows of each pixel's surface (`debug_view/show_surface.comp.glsl`).
#[derive(Clone, Copy, Debug)]
pub enum SurfaceView {
    /// Linear base colour.
    Albedo,
    /// Shading normal in world space.
    Normal,
    /// Distance along the viewing direction.
    Depth,
    /// How far it has moved in the picture since the frame before.
    Motion(ImageHandle),
    /// Albedo times this lighting.
    Indirect(ImageHandle),
    /// S / U of the environment's light.
    EnvironmentVisibility(super::shadow_rays::ShadowEstimates),
    /// S / U of this lighting.
    ShadowRatio(ImageHandle, super::shadow_rays::ShadowEstimates),
}

/// How values become colours (`debug_view/colorize.comp.glsl`).
#[derive(Clone, Copy, Debug)]
enum Coding {
    LinearColor = 0,
    Direction = 1,
    Mapped = 2,
}

fn image_info(frame: &Frame, format: vk::Format) -> ImageInfo {
    ImageInfo::new(format, frame.shape.width_px, frame.shape.height_px)
}

/// The numbers of a view.
pub(super) fn values_image(frame: &mut Frame) -> ImageHandle {
    let info = image_info(frame, vk::Format::R32G32B32A32_SFLOAT);
    frame.graph.persistent_image("view_values", info)
}

/// Adds the pass for what is read from the G-buffer and images in the picture's layout.
pub fn show_surface(frame: &mut Frame, gbuffer: &GBuffer, shown: SurfaceView) -> ImageHandle {
    let values = values_image(frame);
    // Bindings that a view does not read still need an image of the right kind.
    let unused = gbuffer.albedo;
    let (index, [lighting, shadowed, unshadowed]) = match shown {
        SurfaceView::Albedo => (0, [unused; 3]),
        SurfaceView::Normal => (1, [unused; 3]),
        SurfaceView::Depth => (2, [unused; 3]),
        SurfaceView::Motion(motion) => (6, [motion, unused, unused]),
        SurfaceView::Indirect(lighting) => (3, [lighting, unused, unused]),
        SurfaceView::EnvironmentVisibility(estimates) => (5, [unused, estimates.shadowed, estimates.unshadowed]),
        SurfaceView::ShadowRatio(lighting, estimates) => (4, [lighting, estimates.shadowed, estimates.unshadowed]),
    };
    let work =
        ComputeWork { constants: vec![("SHOWN", index)], ..shader("debug_view/show_surface", frame.per_pixel()) };
    let pass = frame
        .compute("debug_view", work)
        .bind("depth_image", gbuffer.depth, Access::ComputeSampled)
        .bind("albedo_image", gbuffer.albedo, Access::ComputeSampled)
        .bind("normals_image", gbuffer.normals, Access::ComputeSampled)
        .bind("indirect_image", lighting, Access::ComputeSampled)
        .bind("shadowed_image", shadowed, Access::ComputeSampled)
        .bind("unshadowed_image", unshadowed, Access::ComputeSampled)
        .bind("out_values", values, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    values
}

/// Adds the pass for the lights that each pixel tests; the frame must count them.
pub fn show_lights_tested(frame: &mut Frame, lights_tested: BufferHandle) -> ImageHandle {
    let values = values_image(frame);
    let pass = frame
        .compute("debug_view", shader("debug_view/show_lights_tested", frame.per_pixel()))
        .bind("lights_tested", lights_tested, Access::ComputeRead)
        .bind("out_values", values, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    values
}

/// Adds the pass for the levels of the lights in each pixel's reservoirs.
pub fn show_chosen_levels(
    frame: &mut Frame,
    shape: &LghShape,
    merged: &MergedLights,
    reservoirs: BufferHandle,
) -> ImageHandle {
    let values = values_image(frame);
    let constants = vec![("EXACT", u32::from(shape.reservoir == Reservoir::Exact))];
    let work = ComputeWork { constants, ..shader("debug_view/show_chosen_levels", frame.per_pixel()) };
    let pass = frame
        .compute("debug_view", work)
        .bind("merged_lights", merged.lights, Access::ComputeRead)
        .bind("reservoirs", reservoirs, Access::ComputeRead)
        .bind("out_values", values, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    values
}

/// What [`sum_lights`] makes.
#[derive(Clone, Copy, Debug)]
pub struct LightSums {
    /// Number of lights that contribute; or mean level, dominant level and largest share.
    pub values: ImageHandle,
    /// Linear colour: the levels' colours mixed by share. Nothing in it unless shares were asked for.
    pub mix: ImageHandle,
}

/// Adds the passes that visit every light at every pixel; `shares` asks for the levels' shares in the lighting rather
/// than for the number of lights. The picture is done in bands of rows, so that no dispatch takes long.
pub fn sum_lights(
    frame: &mut Frame,
    shape: &LghShape,
    gbuffer: &GBuffer,
    placement: BufferHandle,
    merged: &MergedLights,
    shares: bool,
) -> LightSums {
    let values = values_image(frame);
    let mix = frame.image("level_mix", vk::Format::R32G32B32A32_SFLOAT);
    let [width_px, height_px] = shape.sub_image_px();
    let sub_images = shape.interleave.pow(2);
    let lights = shape.grid_capacity + if shape.first_level == 0 { shape.lights.light_capacity() } else { 0 };
    let [columns, rows] = [width_px, height_px].map(|edge| edge.div_ceil(TILE_SIZE));
    // The lights are dealt to the sub-images, so that a row of workgroups in all of them visits each light once each column.
    let visits_per_row = u64::from(columns) * u64::from(lights);
    let rows_per_band = (VISITS_PER_DISPATCH / visits_per_row.max(1)).clamp(1, u64::from(rows)) as u32;
    for (band, first_row) in (0..rows).step_by(rows_per_band as usize).enumerate() {
        let band_rows = rows_per_band.min(rows - first_row);
        let mut push = vec![first_row * TILE_SIZE];
        push.extend(LEVEL_COLORS.iter().chain(&[NO_VALUE]));
        let work = ComputeWork {
            constants: vec![("SHARES", u32::from(shares)), ("LOBE", shape.lobe.code())],
            push,
            ..shader("debug_view/sum_lights", Dispatch::Groups([columns, band_rows, sub_images]))
        };
        // Later bands keep what earlier ones have written.
        let access = if band == 0 { Access::ComputeWrite } else { Access::ComputeReadWrite };
        let pass = frame
            .compute(&format!("debug_view/sum_lights_{}", band + 1), work)
            .bind("depth_image", gbuffer.depth, Access::ComputeSampled)
            .bind("normals_image", gbuffer.normals, Access::ComputeSampled)
            .bind("merged_lights", merged.lights, Access::ComputeRead)
            .bind("sub_images", merged.sub_images, Access::ComputeRead)
            .bind("grid", placement, Access::ComputeRead)
            .bind("out_values", values, access)
            .bind("out_mix", mix, access);
        frame.graph.add_pass(pass);
    }
    LightSums { values, mix }
}

/// Adds the pass that draws the lights S0 as discs: flux in rgb and 1 in alpha, 0 where there is no disc. Lights behind
/// the surfaces of the G-buffer are hidden.
pub fn draw_points(frame: &mut Frame, shape: &LightShape, gbuffer: &GBuffer, lights: &Lights) -> ImageHandle {
    let values = values_image(frame);
    let [width, height] = [frame.shape.width_px, frame.shape.height_px];
    let radius_px = 0.5 * (POINT_PX * width as f32 / 640.0).max(2.0);
    let draw = RasterDraw {
        vertex: "debug_view/draw_points.vert".to_owned(),
        fragment: "debug_view/draw_points.frag".to_owned(),
        constants: Vec::new(),
        push: vec![radius_px.to_bits()],
        state: RasterState {
            additive_blend: false,
            depth_compare: Some(vk::CompareOp::GREATER_OR_EQUAL),
            depth_write: false,
            cull: vk::CullModeFlags::NONE,
            scene_vertices: false,
        },
        viewport: Viewport::whole(width, height),
        call: DrawCall::Direct { vertex_count: 6, instance_count: shape.light_capacity() },
    };
    let work = RasterWork {
        colors: vec![ColorTarget { target: values.into(), clear: Some([0; 4]) }],
        depth: Some(DepthTarget { target: gbuffer.depth.into(), clear: None, write: false }),
        extent_px: [width, height],
        draws: vec![draw],
        uses_scene: false,
    };
    frame.graph.add_pass(
        Pass::new("debug_view/draw_points", Work::Raster(work))
            .bind("frame", frame.data, Access::GraphicsUniform)
            .bind("light_positions", lights.positions, Access::VertexRead)
            .bind("light_fluxes", lights.fluxes, Access::VertexRead)
            .bind("light_counts", lights.counts, Access::VertexRead)
            .uses(gbuffer.depth, Access::DepthAttachmentRead)
            .uses(values, Access::ColorAttachmentWrite),
    );
    values
}

/// Adds the passes that make a picture of values by the view's colour map, or of colours and directions as such. The
/// "exposure" of such a picture is the upper end of its scale.
pub fn colorize(frame: &mut Frame, view: View, values: ImageHandle) -> ToneMapped {
    let map = color_map(view);
    let known_end = map.map_or(Some(1.0), |map| map.end);
    let scale = scale(frame, known_end.unwrap_or(0.0));
    if known_end.is_none() {
        let pass = frame
            .compute("debug_view/measure_scale", shader("debug_view/measure_scale", Dispatch::groups(1)))
            .bind("values_image", values, Access::ComputeSampled)
            .bind("scale", scale, Access::ComputeWrite);
        frame.graph.add_pass(pass);
    }
    let coding = match (map, view) {
        (Some(_), _) => Coding::Mapped,
        (None, View::Normal) => Coding::Direction,
        (None, _) => Coding::LinearColor,
    };
    let picture = picture(frame);
    let work = ComputeWork {
        constants: vec![("CODING", coding as u32)],
        push: palette(view),
        ..shader("debug_view/colorize", frame.per_pixel())
    };
    let pass = frame
        .compute("debug_view/colorize", work)
        .bind("values_image", values, Access::ComputeSampled)
        .bind("scale", scale, Access::ComputeRead)
        .bind("out_picture", picture, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    ToneMapped { picture, exposure: scale, is_exposed: false }
}

/// The upper end of a view's scale, with this value at the start of the frame.
pub(super) fn scale(frame: &mut Frame, end: f32) -> BufferHandle {
    let scale = frame.graph.persistent_buffer("view_scale", 16);
    frame.clear(&[(scale, end.to_bits())]);
    scale
}

/// The picture that a view makes.
pub(super) fn picture(frame: &mut Frame) -> ImageHandle {
    let info = image_info(frame, vk::Format::R8G8B8A8_UNORM);
    frame.graph.persistent_image("picture", info)
}

/// The colours of a view as shaders are told them: how many, that of no value, then theirs.
pub(super) fn palette(view: View) -> Vec<u32> {
    let colors = color_map(view).map_or(&LEVEL_COLORS[..], |map| map.colors);
    let mut push = vec![colors.len() as u32, NO_VALUE];
    push.extend(colors);
    push.resize(2 + MAX_COLORS, 0);
    push
}

/// Adds the passes that lay points over the dimmed picture of direct light, with a little albedo.
pub fn overlay_points(frame: &mut Frame, gbuffer: &GBuffer, points: ImageHandle, direct: ImageHandle) -> ToneMapped {
    let exposure = tone_map::measure_exposure(frame, "exposure", gbuffer, points);
    let direct_exposure = tone_map::measure_exposure(frame, "direct_exposure", gbuffer, direct);
    let picture = picture(frame);
    let pass = frame
        .compute("debug_view/overlay_points", shader("debug_view/overlay_points", frame.per_pixel()))
        .bind("points_image", points, Access::ComputeSampled)
        .bind("direct_image", direct, Access::ComputeSampled)
        .bind("points_exposure", exposure, Access::ComputeRead)
        .bind("direct_exposure", direct_exposure, Access::ComputeRead)
        .bind("albedo_image", gbuffer.albedo, Access::ComputeSampled)
        .bind("out_picture", picture, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    ToneMapped { picture, exposure, is_exposed: true }
}
