//! What point-based global illumination tells about an inspected pixel: its caches, and what the one sees that counts most.

use glam::Vec3;

use super::super::{Cell, InspectorImage, InspectorTable};
use crate::color::luminance;
use crate::cpu::tone_map::srgb_encode;
use crate::passes::pbgi_shape::PbgiShape;
use crate::shared::{InspectedPixel, InspectedTexel, PRIMARY_EDGE};

/// Middle grey.
const KEY: f32 = 0.18;

/// Radiance and coverage of a texel in which directions lie.
fn used(texel: &InspectedTexel) -> Option<(Vec3, f32)> {
    (texel.coverage >= 0.0).then(|| (Vec3::from(texel.radiance), texel.coverage))
}

/// The tables of a pixel, without those that have no rows.
pub(super) fn tables(shape: &PbgiShape, pixel: &InspectedPixel) -> Vec<InspectorTable> {
    if pixel.found == 0 || pixel.cache_count == 0 {
        return Vec::new();
    }
    let covered: Vec<f32> = pixel.cache_texels.iter().filter_map(used).map(|(_, coverage)| coverage).collect();
    let share = covered.iter().sum::<f32>() / covered.len().max(1) as f32;
    let height = shape.cloud.leaf_count_log2.saturating_sub((pixel.cache_key / 2).max(1).ilog2());
    let cells = [
        pixel.cache_count.to_string(),
        pixel.cache_slot.to_string(),
        pixel.cache_key.to_string(),
        height.to_string(),
        format!("{:.1} %", 100.0 * pixel.cache_share),
        format!("{:.1} %", 100.0 * share),
    ];
    vec![InspectorTable {
        name: "inspected caches",
        columns: &[
            ("caches", "Caches that light the pixel"),
            ("first", "The cache with the largest share, by its index among the primary points"),
            ("key", "Its side of a node: twice the node, and 1 for the side that its normal does not face"),
            ("level", "Its level in the tree, counted up from the leaves"),
            ("share", "Its share in the light of the pixel"),
            ("covered", "Texels of its micro-buffer in which it sees surfaces"),
        ],
        rows: vec![cells.map(Cell::plain).into()],
    }]
}

/// What the cache sees that counts most, and where that is a surface.
pub(super) fn images(pixel: &InspectedPixel) -> Vec<InspectorImage> {
    if pixel.found == 0 || pixel.cache_count == 0 {
        return Vec::new();
    }
    let exposure = exposure(pixel);
    let shown = |radiance: Vec3| {
        let exposed = exposure * radiance;
        packed(exposed / (1.0 + exposed))
    };
    vec![
        image(
            "micro-buffer",
            "What the first cache sees, exposed for itself; its normal is in the middle",
            pixel,
            |(radiance, _)| shown(radiance),
        ),
        image(
            "surfaces",
            "White where surfaces cover it, black where the environment is visible",
            pixel,
            |(_, coverage)| packed(Vec3::splat(coverage)),
        ),
    ]
}

fn image(
    name: &'static str,
    help: &'static str,
    pixel: &InspectedPixel,
    color: impl Fn((Vec3, f32)) -> u32,
) -> InspectorImage {
    let colors = pixel.cache_texels.iter().map(|texel| used(texel).map(&color)).collect();
    InspectorImage { name, help, edge: PRIMARY_EDGE, colors }
}

/// From the log-average of what is not black.
fn exposure(pixel: &InspectedPixel) -> f32 {
    let lit = pixel.cache_texels.iter().filter_map(used).map(|(radiance, _)| luminance(radiance)).filter(|l| *l > 0.0);
    let logs: Vec<f32> = lit.map(f32::ln).collect();
    if logs.is_empty() { 1.0 } else { KEY / (logs.iter().sum::<f32>() / logs.len() as f32).exp() }
}

/// `0xRRGGBB` of a linear colour.
fn packed(linear: Vec3) -> u32 {
    let encoded = srgb_encode(linear.clamp(Vec3::ZERO, Vec3::ONE));
    let [r, g, b] = encoded.to_array().map(|value| (255.0 * value).round() as u8);
    u32::from_be_bytes([0, r, g, b])
}
