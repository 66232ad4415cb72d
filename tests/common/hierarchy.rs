//! The hierarchy alone on the GPU: lights in, every buffer out.

use std::sync::Arc;

use gridlight::cpu::count_lights::{LevelTable, TABLE_WORDS};
use gridlight::cpu::deal_lights::{Deal, SUB_IMAGE_STRIDE};
use gridlight::cpu::exclusive_scan::exclusive_scan;
use gridlight::cpu::grid::Grid;
use gridlight::cpu::grid_update::SlotLights;
use gridlight::cpu::lights::LightList;
use gridlight::cpu::scatter_lights::Moments;
use gridlight::gpu::{Executor, Gpu};
use gridlight::graph::BufferHandle;
use gridlight::light_grid::Levels;
use gridlight::passes::FrameShape;
use gridlight::passes::lgh_shape::LghShape;
use gridlight::passes::light_shape::{LightShape, SLOTS_AT_ONCE};
use gridlight::settings::{
    CenterWeight, FirstLevelBuild, GridUpdate, LevelBuild, Reservoir, ShadowEstimate, ShadowFilter, ShadowPoints, View,
};
use gridlight::shared::{FrameData, GridLight, GridPlacement};
use gridlight::techniques::lgh::{self, HierarchyOutputs};

/// Size of the picture that the lights are dealt for.
const SIZE_PX: [u32; 2] = [16, 16];

/// A compiled hierarchy for up to so many lights.
pub struct Hierarchy {
    executor: Executor,
    outputs: HierarchyOutputs,
    shape: LghShape,
}

/// What to compile.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Lmax.
    pub top: u32,
    /// How levels above S1 are built.
    pub build: LevelBuild,
    /// How lights count in positions.
    pub center: CenterWeight,
    /// Interleave n.
    pub interleave: u32,
    /// First used level.
    pub first_level: u32,
    /// Lights that fit.
    pub light_capacity: u32,
    /// Grid lights that fit; `None` is enough for any lights.
    pub grid_capacity: Option<u32>,
}

/// Everything the GPU made.
#[derive(Clone)]
pub struct Readback {
    /// Placement and levels.
    pub grid: Grid,
    /// Occupancy bits.
    pub occupancy: Vec<u32>,
    /// Their ranks.
    pub ranks: Vec<u32>,
    /// The level table.
    pub table: LevelTable,
    /// Grid lights of all levels.
    pub lights: Vec<GridLight>,
    /// Where each level of each sub-image starts.
    pub sub_images: Vec<u32>,
    /// The merged list.
    pub merged: Vec<GridLight>,
    /// How it was dealt.
    pub deal: Deal,
    /// Descent tables of the lights above S1.
    pub tables: Vec<u32>,
    /// Representatives of the S1 lights: keys and lights.
    pub representatives: Vec<u32>,
    /// Low bits of a representative that hold its light.
    pub index_bits: u32,
}

impl Hierarchy {
    /// Compiles it.
    pub fn new(gpu: &Arc<Gpu>, options: Options) -> Self {
        Self::of_shape(gpu, shape(options))
    }

    /// Compiles one of a shape.
    pub fn of_shape(gpu: &Arc<Gpu>, shape: LghShape) -> Self {
        let (graph, outputs) = lgh::build_hierarchy(frame_shape(), &shape);
        let executor = Executor::new(gpu, graph, None).unwrap();
        Self { executor, outputs, shape }
    }

    /// Grid lights that fit.
    pub fn grid_capacity(&self) -> u32 {
        self.shape.grid_capacity
    }

    /// Runs it once over `lights`.
    pub fn run(&mut self, lights: &LightList, scene_radius: f32) -> Readback {
        let count = lights.len() as u32;
        assert!(count <= self.shape.lights.light_capacity());
        let write = |buffer, bytes: &[u8]| self.executor.write_buffer(buffer, bytes).unwrap();
        write(self.outputs.lights.positions, bytemuck::cast_slice(&lights.positions));
        write(self.outputs.lights.fluxes, bytemuck::cast_slice(&lights.fluxes));
        write(self.outputs.lights.counts, bytemuck::cast_slice(&[count, count, 0, 0]));
        // What is never written must not look like a result.
        for buffer in [self.outputs.grid.lights, self.outputs.grid.ranks, self.outputs.merged.lights] {
            let size = self.executor.read_buffer(buffer).unwrap().len();
            write(buffer, &vec![0xff; size]);
        }
        let data = frame_data(&self.shape, scene_radius);
        let ticket = self.executor.submit(bytemuck::bytes_of(&data)).unwrap();
        self.executor.wait(ticket).unwrap();
        self.read_back(count)
    }

    /// Runs it once over the lights of slots, where it may go on from what it was run over before.
    pub fn run_slots(&mut self, lights: &SlotLights, scene_radius: f32) -> Readback {
        let slots = self.outputs.lights.slots.expect("a hierarchy that goes on");
        let words = (slots.count as usize).div_ceil(32);
        let mut bits = vec![0; words];
        let taken = lights.slots.iter().enumerate().filter(|(_, light)| light.is_some());
        taken.for_each(|(slot, _)| bits[slot / 32] |= 1 << (slot % 32));
        self.executor.write_buffer(slots.bits, bytemuck::cast_slice(&bits)).unwrap();
        self.executor.write_buffer(slots.ranks, bytemuck::cast_slice(&exclusive_scan(&bits))).unwrap();
        self.run(&lights.lights, scene_radius)
    }

    /// Words of what was counted where it may go on: lights that changed, those that were applied, words that differ.
    pub fn update_counts(&self) -> [u32; 3] {
        let words: Vec<u32> = self.read(self.outputs.grid.update_counts.expect("a hierarchy that goes on"));
        [words[0], words[1], words[2]]
    }

    /// The sums of S1 that are kept for the next run.
    pub fn kept_moments(&self) -> Vec<Moments> {
        let table: Vec<u32> = self.read(self.outputs.grid.level_table);
        let mut moments: Vec<Moments> = self.read(self.named("kept_moments"));
        moments.truncate(table[3] as usize);
        moments
    }

    /// Writes other sums in their place.
    pub fn keep_moments(&self, moments: &[Moments]) {
        self.executor.write_buffer(self.named("kept_moments"), bytemuck::cast_slice(moments)).unwrap();
    }

    fn named(&self, name: &str) -> BufferHandle {
        self.executor.graph().buffer_named(name).expect(name)
    }

    fn read_back(&self, light_count: u32) -> Readback {
        let outputs = &self.outputs;
        let placement: Vec<GridPlacement> = self.read(outputs.placement);
        let table: Vec<u32> = self.read(outputs.grid.level_table);
        let mut words = [0; TABLE_WORDS];
        words.copy_from_slice(&table[..TABLE_WORDS]);
        let table = LevelTable(words);
        let top = self.shape.levels.top;
        let mut lights: Vec<GridLight> = self.read(outputs.grid.lights);
        lights.truncate(table.range(top).end);
        let sub_image_count = self.shape.interleave * self.shape.interleave;
        let sub_images: Vec<u32> = self.read(outputs.merged.sub_images);
        let mut merged: Vec<GridLight> = self.read(outputs.merged.lights);
        merged.truncate(sub_images[(sub_image_count as usize - 1) * SUB_IMAGE_STRIDE + top as usize + 1] as usize);
        let descent = outputs.descent.unwrap();
        Readback {
            tables: self.read(descent.tables),
            representatives: self.read(descent.representatives),
            index_bits: descent.index_bits,
            grid: Grid { placement: placement[0], levels: self.shape.levels, center: self.shape.center },
            occupancy: self.read(outputs.grid.occupancy),
            ranks: self.read(outputs.grid.ranks),
            table,
            lights,
            sub_images,
            merged,
            deal: Deal { sub_image_count, first_level: self.shape.first_level, top_level: top, light_count },
        }
    }

    fn read<T: bytemuck::Pod>(&self, buffer: BufferHandle) -> Vec<T> {
        bytemuck::pod_collect_to_vec(&self.executor.read_buffer(buffer).unwrap())
    }
}

/// Sizes and modes of a hierarchy alone.
pub fn shape(options: Options) -> LghShape {
    let levels = Levels::new(options.top);
    let lights = u64::from(options.light_capacity);
    // A light has 8 vertices, an S1 light again 8 in each level above.
    let most = |level: u32| u64::from(levels.vertices_per_axis(level)).pow(3).min(8 * 8 * lights);
    let all = (1..=levels.top).map(most).sum::<u64>().max(1) as u32;
    LghShape {
        lights: LightShape {
            path_count: 0,
            starts: None,
            lacks_paths: false,
            bounces: 0,
            slots_at_once: SLOTS_AT_ONCE,
            vpl_capacity: options.light_capacity,
            scene_light_count: 0,
            shadow_samples: 0,
            vpl_radius: 0.0,
            vpl_flux_share: 0.0,
        },
        picture_px: SIZE_PX,
        interleave: options.interleave,
        levels,
        indirect_size: gridlight::settings::IndirectSize::Full,
        anchor: None,
        lobe: gridlight::settings::Lobe::Mixture,
        center: options.center,
        first_level: options.first_level,
        grid_capacity: options.grid_capacity.unwrap_or(all),
        upper_capacity: options.grid_capacity.unwrap_or(all),
        shadow_points: ShadowPoints::Descent,
        shadow_estimate: ShadowEstimate::Ratio,
        lighting: gridlight::settings::LightingMode::Gather,
        reservoir: Reservoir::Lock,
        build: options.build,
        scatter: if options.build == LevelBuild::Scatter { FirstLevelBuild::Atomic } else { FirstLevelBuild::Sorted },
        grid_update: GridUpdate::Full,
        filter: ShadowFilter::None,
        reuse: None,
        lighting_format: ash::vk::Format::R16G16B16A16_SFLOAT,
        count_lights_tested: false,
    }
}

/// What a frame around it has.
pub fn frame_shape() -> FrameShape {
    FrameShape {
        width_px: SIZE_PX[0],
        height_px: SIZE_PX[1],
        direct: true,
        environment: None,
        emitters: None,
        has_emission: false,
        culls_back_faces: false,
        texture_filter: gridlight::settings::TextureFilter::Anisotropic,
        accumulate: false,
        taa: false,
        rays: gridlight::settings::Rays::Bvh,
        view: View::Final,
        inspect: false,
        surface_motion: None,
        keeps_lights: false,
    }
}

/// The constants that the hierarchy reads.
pub fn frame_data(shape: &LghShape, scene_radius: f32) -> FrameData {
    FrameData {
        scene_radius,
        size_px: SIZE_PX,
        sub_image_px: shape.sub_image_px(),
        interleave: shape.interleave,
        shadow_samples: shape.lights.shadow_samples,
        shadow_from: 2,
        first_level: shape.first_level,
        top_level: shape.levels.top,
        vpl_capacity: shape.lights.vpl_capacity,
        path_count: shape.lights.path_count,
        bounces: shape.lights.bounces,
        seed: 1,
        scene_lights: shape.lights.scene_light_count,
        alpha: 1.0,
        sampling_seed: 1,
        levels: shape.levels.table(),
        ..bytemuck::Zeroable::zeroed()
    }
}
