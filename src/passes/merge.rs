//! `merge`: the lights of all used levels in one list, dealt to the interleaved sub-images (section 4.1).

use ash::vk;

use super::compaction::{GridLights, Lights};
use super::lgh_shape::LghShape;
use super::{Frame, shader};
use crate::gpu::Dispatch;
use crate::graph::{Access, BufferHandle, ImageHandle, ImageInfo};
use crate::shared::{GridLight, LIGHT_TEXELS, LIGHTS_PER_ROW, MAX_LEVEL, SUB_IMAGE_STRIDE};

/// The merged list.
#[derive(Clone, Copy, Debug)]
pub struct MergedLights {
    /// The lights: per sub-image, per level.
    pub lights: BufferHandle,
    /// The lights once more as texels (`common/light_texels.glsl`).
    pub texels: ImageHandle,
    /// Where each level of each sub-image starts.
    pub sub_images: BufferHandle,
    /// One indirect draw per sub-image.
    pub draws: BufferHandle,
}

/// Lights that fit into the merged list.
fn capacity(shape: &LghShape) -> u32 {
    let sub_image_count = shape.interleave * shape.interleave;
    let originals = if shape.first_level == 0 { shape.lights.light_capacity() } else { 0 };
    // Levels with fewer lights than sub-images are copied to each.
    let copies = sub_image_count * sub_image_count * (MAX_LEVEL + 1);
    shape.grid_capacity + originals + copies
}

/// Rows of the image that holds the merged lights.
#[must_use]
pub fn light_rows(shape: &LghShape) -> u32 {
    capacity(shape).div_ceil(LIGHTS_PER_ROW)
}

/// Adds the passes.
pub fn add(
    frame: &mut Frame,
    shape: &LghShape,
    lights: &Lights,
    placement: BufferHandle,
    grid: &GridLights,
) -> MergedLights {
    let sub_image_count = shape.interleave * shape.interleave;
    let capacity = u64::from(capacity(shape));
    let info = ImageInfo::new(vk::Format::R32G32B32A32_SFLOAT, LIGHTS_PER_ROW * LIGHT_TEXELS, light_rows(shape));
    let merged = MergedLights {
        texels: frame.graph.transient_image("merged_light_texels", info),
        lights: frame.graph.persistent_buffer("merged_lights", size_of::<GridLight>() as u64 * capacity),
        sub_images: frame.graph.persistent_buffer("sub_images", 4 * u64::from(sub_image_count * SUB_IMAGE_STRIDE)),
        draws: frame.graph.transient_buffer("light_volume_draws", 16 * u64::from(sub_image_count)),
    };
    let dispatch = frame.graph.transient_buffer("merge_dispatch", 16);
    let pass = frame
        .compute("merge/deal_lights", shader("merge/deal_lights", Dispatch::groups(1)))
        .bind("level_table", grid.level_table, Access::ComputeRead)
        .bind("light_counts", lights.counts, Access::ComputeRead)
        .bind("sub_images", merged.sub_images, Access::ComputeWrite)
        .bind("draws", merged.draws, Access::ComputeWrite)
        .bind("merge_dispatch", dispatch, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    let indirect = Dispatch::Indirect { buffer: dispatch, offset_bytes: 0 };
    let pass = frame
        .compute("merge", shader("merge/merge_lights", indirect))
        .bind("grid_lights", grid.lights, Access::ComputeRead)
        .bind("level_table", grid.level_table, Access::ComputeRead)
        .bind("sub_images", merged.sub_images, Access::ComputeRead)
        .with(|pass| lights.read_by(pass))
        .bind("light_counts", lights.counts, Access::ComputeRead)
        .bind("merged_lights", merged.lights, Access::ComputeWrite)
        .bind("grid", placement, Access::ComputeRead)
        .bind("light_texels", merged.texels, Access::ComputeWrite)
        .uses(dispatch, Access::IndirectRead);
    frame.graph.add_pass(pass);
    merged
}
