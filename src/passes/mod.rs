//! The passes of the frame, one file each, named like their shader folder and their timings.
//!
//! A pass here is a function that declares its inputs and outputs to the frame graph; it records nothing.

pub mod accumulate;
mod area_light;
pub mod atrous;
pub mod bounds;
pub mod brute_force;
pub mod cache_gather;
pub mod cache_tiles;
pub mod compaction;
pub mod compose;
pub mod debug_view;
pub mod descent;
pub mod direct_light;
pub mod emitter_light;
pub mod environment_light;
pub mod exclusive_scan;
pub mod first_level;
pub mod gbuffer;
pub mod grid_gather;
pub mod grid_update;
pub mod half_picture;
pub mod inspect;
pub mod interleave;
pub mod lgh_shape;
pub mod light_buckets;
pub mod light_gather;
pub mod light_shape;
pub mod light_starts;
pub mod light_volumes;
pub mod merge;
pub mod micro_buffers;
pub mod motion;
pub mod path_trace;
pub mod pbgi_reference;
pub mod pbgi_shape;
pub mod point_bounces;
pub mod point_cut;
pub mod point_light;
pub mod point_propagation;
pub mod point_reuse;
pub mod point_selection;
pub mod point_view;
pub mod points;
pub mod present;
pub mod radiance_cache;
pub mod reference;
pub mod refit;
pub mod rounds;
pub mod scene;
pub mod shadow_rays;
pub mod structures;
pub mod taa;
pub mod temporal;
pub mod tone_map;
pub mod vpl_trace;

use ash::vk;

use self::scene::SceneParts;
use self::temporal::Reuse;
use crate::gpu::{ComputeWork, Dispatch, TransferOp, Work};
use crate::graph::{Access, BufferHandle, Graph, History, ImageHandle, ImageInfo, Pass, PassId};
use crate::job::Job;
use crate::settings::{BackFaces, Rays, ShadowFilter, TextureFilter, View};
use crate::shader::spirv;
use crate::shared::FrameData;

/// What every frame has, whichever technique makes it. Known before the frame is built.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameShape {
    /// Picture width.
    pub width_px: u32,
    /// Picture height.
    pub height_px: u32,
    /// Direct light is part of the picture.
    pub direct: bool,
    /// How surfaces are lit by the environment; `None` where nothing comes from it, or no ray goes there.
    pub environment: Option<AreaLightShape>,
    /// How they are lit by surfaces that shine by themselves; `None` where none do, or no ray goes there.
    pub emitters: Option<AreaLightShape>,
    /// Something is seen that shines or is unlit.
    pub has_emission: bool,
    /// The camera looks through backs of single-sided surfaces.
    pub culls_back_faces: bool,
    /// How the camera sees textures.
    pub texture_filter: TextureFilter,
    /// The picture is the mean of several frames.
    pub accumulate: bool,
    /// The picture is smoothed over the frames before it ([`taa`]).
    pub taa: bool,
    /// What traces rays.
    pub rays: Rays,
    /// What the picture shows.
    pub view: View,
    /// Say everything about one pixel ([`inspect`]).
    pub inspect: bool,
    /// How the G-buffer finds where its surfaces were in the frame before; `None` where nobody asks.
    pub surface_motion: Option<SurfaceMotion>,
    /// Frames may use the lights of the frame before again, and what is built over them ([`Frame::kept`]).
    pub keeps_lights: bool,
}

/// What moves surfaces in the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurfaceMotion {
    /// The camera alone.
    Camera,
    /// The camera, and vertices of the scene.
    Vertices,
}

/// How direct light of the environment, or of surfaces that shine, is sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaLightShape {
    /// Shadow rays per pixel, at least one.
    pub samples: u32,
    /// The noise of the samples is filtered.
    pub is_filtered: bool,
    /// What is taken over from the frames before; `None` where each frame stands by itself.
    pub reuse: Option<Reuse>,
}

impl FrameShape {
    /// What a job asks of every frame, whatever its technique.
    #[must_use]
    pub fn new(job: &Job<'_>) -> Self {
        let settings = job.settings;
        let samples = settings.environment.samples;
        let is_filtered = settings.lgh.filter != ShadowFilter::None;
        let shape = AreaLightShape { samples, is_filtered, reuse: None };
        let lit_by = |is_there: bool| (is_there && samples > 0).then_some(shape);
        Self {
            environment: lit_by(job.has_environment()),
            emitters: lit_by(job.scene.emitter_count > 0),
            has_emission: job.scene.has_emission,
            culls_back_faces: settings.picture.back_faces == BackFaces::Cull,
            texture_filter: settings.picture.texture_filter,
            width_px: settings.picture.size.width,
            height_px: settings.picture.size.height,
            direct: settings.render.direct.is_on(),
            accumulate: settings.render.accumulate > 1,
            // Views show one frame as it is, and the frames of a mean are independent.
            taa: settings.render.taa.is_on() && settings.render.view == View::Final && settings.render.accumulate == 1,
            rays: settings.tracing.rays,
            view: settings.render.view,
            inspect: settings.output.inspect.is_some(),
            surface_motion: None,
            keeps_lights: false,
        }
    }
}

/// A frame under construction.
pub struct Frame {
    /// The graph so far.
    pub graph: Graph<Work>,
    /// The frame's constants.
    pub data: BufferHandle,
    /// Rays traced: `[0]` for VPLs, `[1]` for shadow samples, `[2]` towards the environment.
    pub ray_count: BufferHandle,
    /// The scene, unless the frame does without one.
    pub scene: Option<SceneParts>,
    /// What every frame has.
    pub shape: FrameShape,
    /// The pass that everything else follows.
    setup: PassId,
}

impl Frame {
    /// Starts a frame over a scene with the pass that writes its constants, and the scene's lights where they have
    /// changed, and clears its buffers.
    #[must_use]
    pub fn new(shape: FrameShape) -> Self {
        let rays = shape.rays;
        Self::begin(shape, Some(rays))
    }

    /// Starts a frame that has no scene.
    #[must_use]
    pub fn without_scene(shape: FrameShape) -> Self {
        Self::begin(shape, None)
    }

    fn begin(shape: FrameShape, scene_rays: Option<Rays>) -> Self {
        let mut graph = Graph::new();
        let data = graph.transient_buffer("frame_data", size_of::<FrameData>() as u64);
        let ray_count = graph.persistent_buffer("ray_count", 16);
        let scene = scene_rays.map(|rays| SceneParts::declare(&mut graph, rays));
        let lights = scene.map(|scene| TransferOp::SceneLights { buffer: scene.lights });
        let constants = [TransferOp::FrameData { buffer: data }, TransferOp::Fill { buffer: ray_count, value: 0 }];
        let setup = Pass::new("frame_setup", Work::Transfer(constants.into_iter().chain(lights).collect()));
        let written = [data, ray_count].into_iter().chain(scene.map(|scene| scene.lights));
        let setup = graph.add_pass(written.fold(setup, |pass, buffer| pass.uses(buffer, Access::TransferWrite)));
        Self { graph, data, ray_count, scene, shape, setup }
    }

    /// Fills buffers with a word each at the start of the frame, where all clears share one barrier. Transient buffers
    /// live from there on: large ones are better cleared by [`Self::clear_here`].
    pub fn clear(&mut self, buffers: &[(BufferHandle, u32)]) {
        add_fills(self.graph.pass_mut(self.setup), buffers);
    }

    /// The frame's constants once more, for passes to change.
    fn copy_of_constants(&mut self, name: &str) -> BufferHandle {
        let buffer = self.graph.transient_buffer(name, size_of::<FrameData>() as u64);
        let setup = self.graph.pass_mut(self.setup);
        setup.declare(buffer, Access::TransferWrite);
        if let Work::Transfer(ops) = &mut setup.payload {
            ops.push(TransferOp::FrameData { buffer });
        }
        buffer
    }

    /// Adds two chains of passes that do not depend on each other, and lays them side by side, so that they share barriers.
    pub fn side_by_side<A, B>(
        &mut self,
        add_first: impl FnOnce(&mut Self) -> A,
        add_second: impl FnOnce(&mut Self) -> B,
    ) -> (A, B) {
        let first = self.graph.passes().len();
        let added_first = add_first(self);
        let second = self.graph.passes().len();
        let added_second = add_second(self);
        self.graph.lay_side_by_side(first, second);
        (added_first, added_second)
    }

    /// Adds passes that need not run again in frames for which everything is the same that they read: of the frame's constants
    /// neither camera nor shadow samples. Their buffers are cleared when they run.
    pub fn kept<R>(&mut self, add: impl FnOnce(&mut Self) -> R) -> R {
        if !self.shape.keeps_lights {
            return add(self);
        }
        let first = self.graph.passes().len();
        let own = self.graph.add_pass(Pass::new("frame_setup/lights", Work::Transfer(Vec::new())));
        let setup = std::mem::replace(&mut self.setup, own);
        let added = add(self);
        self.setup = setup;
        self.graph.keep_from(first);
        added
    }

    /// Adds a pass that fills buffers with a word each.
    pub fn clear_here(&mut self, name: &str, buffers: &[(BufferHandle, u32)]) {
        let mut pass = Pass::new(name, Work::Transfer(Vec::new()));
        add_fills(&mut pass, buffers);
        self.graph.add_pass(pass);
    }

    /// A compute pass with the frame's constants bound where its shader reads them, which reads the scene where its
    /// work does; bind the rest and add it to the graph.
    #[must_use]
    pub fn compute(&self, name: &str, work: ComputeWork) -> Pass<Work> {
        let reads_frame = spirv::interface(&work.shader).is_ok_and(|shader| shader.binding("frame").is_some());
        let scene = self.scene.filter(|_| work.uses_scene);
        let pass = Pass::new(name, Work::Compute(work));
        let pass = if reads_frame { pass.bind("frame", self.data, Access::ComputeUniform) } else { pass };
        scene.into_iter().fold(pass, |pass, scene| scene.read_by(pass))
    }

    /// One thread per pixel of the picture.
    #[must_use]
    pub fn per_pixel(&self) -> Extent {
        Extent::Pixels([self.shape.width_px, self.shape.height_px])
    }

    /// Work of a compute shader that traces rays over the scene.
    #[must_use]
    pub fn ray_shader(&self, name: &str, extent: impl Into<Extent>) -> ComputeWork {
        let suffix = match self.shape.rays {
            Rays::Bvh => "",
            Rays::Query => "_query",
        };
        ComputeWork { uses_scene: true, ..shader(&format!("{name}{suffix}"), extent) }
    }

    /// A transient image of the picture's size.
    pub fn image(&mut self, name: &str, format: vk::Format) -> ImageHandle {
        let info = self.image_info(format);
        self.graph.transient_image(name, info)
    }

    /// An image of the picture's size that is kept from frame to frame.
    pub fn kept_image(&mut self, name: &str, format: vk::Format) -> ImageHandle {
        let info = self.image_info(format);
        self.graph.persistent_image(name, info)
    }

    /// An image of the picture's size of which the next frame reads what this one writes.
    pub fn history_image(&mut self, name: &str, format: vk::Format) -> History<ImageHandle> {
        let info = self.image_info(format);
        self.graph.history_image(name, info)
    }

    fn image_info(&self, format: vk::Format) -> ImageInfo {
        ImageInfo::new(format, self.shape.width_px, self.shape.height_px)
    }
}

/// Adds fills to a pass of transfers.
fn add_fills(pass: &mut Pass<Work>, buffers: &[(BufferHandle, u32)]) {
    for &(buffer, value) in buffers {
        pass.declare(buffer, Access::TransferWrite);
        if let Work::Transfer(ops) = &mut pass.payload {
            ops.push(TransferOp::Fill { buffer, value });
        }
    }
}

/// A pass that reads the buffer which its dispatch is in, if it is in one.
#[must_use]
pub fn read_dispatch(pass: Pass<Work>) -> Pass<Work> {
    match &pass.payload {
        Work::Compute(ComputeWork { dispatch: Dispatch::Indirect { buffer, .. }, .. }) => {
            let buffer = *buffer;
            pass.uses(buffer, Access::IndirectRead)
        }
        _ => pass,
    }
}

/// How much a shader runs over: the number of its workgroups follows from their size.
#[derive(Clone, Copy, Debug)]
pub enum Extent {
    /// At least as many threads in a line.
    Threads(u32),
    /// At least one thread per pixel: width, height.
    Pixels([u32; 2]),
    /// Workgroups as they are.
    Workgroups(Dispatch),
}

impl From<Dispatch> for Extent {
    fn from(dispatch: Dispatch) -> Self {
        Self::Workgroups(dispatch)
    }
}

impl Extent {
    /// The dispatch in workgroups of this size.
    #[must_use]
    pub fn dispatch(self, workgroup_size: [u32; 3]) -> Dispatch {
        let [x, y, _] = workgroup_size.map(|edge| edge.max(1));
        match self {
            Self::Threads(count) => Dispatch::groups(count.div_ceil(x)),
            Self::Pixels([width, height]) => Dispatch::Groups([width.div_ceil(x), height.div_ceil(y), 1]),
            Self::Workgroups(dispatch) => dispatch,
        }
    }
}

/// Compute work of one shader; the rest by struct update.
#[must_use]
pub fn shader(name: &str, extent: impl Into<Extent>) -> ComputeWork {
    let shader = format!("{name}.comp");
    // A shader that is missing is an error once the frame is checked.
    let workgroup_size = spirv::interface(&shader).map_or([1; 3], |interface| interface.workgroup_size);
    ComputeWork {
        shader,
        constants: Vec::new(),
        push: Vec::new(),
        dispatch: extent.into().dispatch(workgroup_size),
        uses_scene: false,
        repeat: None,
    }
}

/// One thread per item.
#[must_use]
pub fn threads(count: u32) -> Extent {
    Extent::Threads(count)
}
