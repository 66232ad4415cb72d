//! The scene on the GPU: descriptor set 1 for shaders that trace rays or read lights, descriptor set 2 per
//! material for the G-buffer.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use ash::vk;

use super::acceleration::{Acceleration, BUILD_INPUT};
use super::buffer::Buffer;
use super::check;
use super::descriptors::{Bound, Sets, binding_kind};
use super::device::Device;
use super::environment::EnvironmentParts;
use super::image::Image;
use super::physical::Physical;
use super::transfer::{Subresource, copy_buffer, storage_buffer, upload_buffer, upload_image};
use super::word_image::WordImage;
use super::work::StructureLevel;
use crate::environment::upload::PreparedEnvironment;
use crate::error::{Error, Result};
use crate::graph::ImageInfo;
use crate::scene::chunks::Chunk;
use crate::scene::octahedral::NO_TANGENT;
use crate::scene::query_geometry::QueryGeometry;
use crate::scene::sampling::{Filter, Sampling, Wrap};
use crate::scene::upload::MipChain;
use crate::settings::TextureFilter;
use crate::shader::interface::BindingKind;
use crate::shared::Emitter;

/// Everything uploaded, as plain bytes and texels.
pub struct SceneData<'a> {
    /// BVH nodes.
    pub nodes: &'a [u8],
    /// Bytes of nodes that there is to be room for, where the tree may be built anew.
    pub node_capacity_bytes: usize,
    /// BVH triangles in leaf order.
    pub triangles: &'a [u8],
    /// Scene vertices.
    pub vertices: &'a [u8],
    /// Packed tangents of the vertices up to the last that has one, may be empty.
    pub tangents: &'a [u8],
    /// Whether vertices are replaced, so that those of the frame before are kept.
    pub vertices_move: bool,
    /// Three indices per triangle.
    pub indices: &'a [u8],
    /// Triangles for ray queries; `None` leaves the acceleration structures out.
    pub query: Option<&'a QueryGeometry>,
    /// `GpuMaterial`s.
    pub materials: &'a [u8],
    /// `PunctualLight`s, directional and spot lights first.
    pub lights: &'a [u8],
    /// `Emitter`s, may be empty.
    pub emitters: &'a [u8],
    /// Light from all around.
    pub environment: &'a PreparedEnvironment,
    /// Edge of the albedo array's layers.
    pub albedo_size_px: u32,
    /// Layers of the albedo array, at least one.
    pub albedo_layers: &'a [Vec<u8>],
    /// Textures at full resolution; sRGB or linear.
    pub textures: &'a [(bool, MipChain)],
    /// Per material: textures of base colour, normals and emission, and how they are read.
    pub material_textures: &'a [[(Option<u32>, Sampling); 3]],
    /// Draws of the G-buffer, in short runs.
    pub chunks: Vec<Chunk>,
}

/// A part of the scene that frames have as an imported resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScenePart {
    /// Scene vertices, a buffer.
    Vertices,
    /// Packed tangents of the vertices up to the last that has one, a buffer.
    Tangents,
    /// The vertices of the frame before, a buffer; only where vertices move.
    PreviousVertices,
    /// Three indices per triangle, a buffer.
    Indices,
    /// `GpuMaterial`s, a buffer.
    Materials,
    /// `PunctualLight`s, a buffer.
    Lights,
    /// `Emitter`s, a buffer.
    Emitters,
    /// Light from all around, an image.
    EnvironmentMap,
    /// The sums that directions of the environment are drawn from, a buffer.
    EnvironmentTable,
    /// BVH nodes, an image of words.
    Nodes,
    /// BVH triangles in leaf order, an image of words.
    Triangles,
    /// The buffer that holds the top acceleration structure.
    TopStructure,
    /// The buffer that holds the bottom acceleration structure.
    BottomStructure,
    /// Places of the structures' triangles in the BVH, a buffer.
    StructureTriangles,
}

impl ScenePart {
    const ALL: [Self; 14] = [
        Self::Vertices,
        Self::Tangents,
        Self::PreviousVertices,
        Self::Indices,
        Self::Materials,
        Self::Lights,
        Self::Emitters,
        Self::EnvironmentMap,
        Self::EnvironmentTable,
        Self::Nodes,
        Self::Triangles,
        Self::TopStructure,
        Self::BottomStructure,
        Self::StructureTriangles,
    ];

    /// Name of the resource.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Vertices => "scene_vertices",
            Self::Tangents => "scene_tangents",
            Self::PreviousVertices => "previous_vertices",
            Self::Indices => "scene_indices",
            Self::Materials => "scene_materials",
            Self::Lights => "scene_lights",
            Self::Emitters => "scene_emitters",
            Self::EnvironmentMap => "environment_map",
            Self::EnvironmentTable => "environment_table",
            Self::Nodes => "bvh_nodes",
            Self::Triangles => "bvh_triangles",
            Self::TopStructure => "top_structure",
            Self::BottomStructure => "bottom_structure",
            Self::StructureTriangles => "structure_triangles",
        }
    }
}

/// In the order of their numbers.
const TEXTURE_FILTERS: [TextureFilter; 2] = [TextureFilter::Anisotropic, TextureFilter::Trilinear];

/// The uploaded scene.
pub struct SceneSet {
    pub(super) scene: Sets,
    /// A set per material with each filter of [`TEXTURE_FILTERS`].
    pub(super) materials: Sets,
    pub(super) vertices: Buffer,
    pub(super) tangents: Buffer,
    previous_vertices: Option<Buffer>,
    pub(super) indices: Buffer,
    pub(super) chunks: Vec<Chunk>,
    /// Materials, lights.
    pub(super) buffers: [Buffer; 2],
    emitters: Buffer,
    /// BVH triangles.
    pub(super) triangles: WordImage,
    pub(super) nodes: WordImage,
    environment: EnvironmentParts,
    query: Option<(Acceleration, Buffer)>,
    _images: Vec<Image>,
    _samplers: Vec<Sampler>,
}

struct Sampler {
    raw: vk::Sampler,
    gpu: Arc<Device>,
}

impl Drop for Sampler {
    fn drop(&mut self) {
        // SAFETY: owners wait for the GPU before they drop the scene.
        unsafe { self.gpu.device.destroy_sampler(self.raw, None) };
    }
}

impl Sampler {
    /// Anisotropy only where derivatives exist: with an explicit level of detail lavapipe 22.3 takes 10 ms for one
    /// anisotropic sample.
    fn new(gpu: &Arc<Device>, sampling: Sampling, anisotropy: bool) -> Result<Self> {
        let filter = |filter: Filter| match filter {
            Filter::Linear => vk::Filter::LINEAR,
            Filter::Nearest => vk::Filter::NEAREST,
        };
        let mips = match sampling.mips {
            Some(Filter::Linear) => vk::SamplerMipmapMode::LINEAR,
            _ => vk::SamplerMipmapMode::NEAREST,
        };
        let [u, v] = sampling.wrap.map(|wrap| match wrap {
            Wrap::Repeat => vk::SamplerAddressMode::REPEAT,
            Wrap::Mirror => vk::SamplerAddressMode::MIRRORED_REPEAT,
            Wrap::Clamp => vk::SamplerAddressMode::CLAMP_TO_EDGE,
        });
        let smooth = (sampling.magnify, sampling.minify) == (Filter::Linear, Filter::Linear);
        let info = vk::SamplerCreateInfo::default()
            .mag_filter(filter(sampling.magnify))
            .min_filter(filter(sampling.minify))
            .mipmap_mode(mips)
            .address_mode_u(u)
            .address_mode_v(v)
            .anisotropy_enable(anisotropy && smooth && sampling.mips.is_some())
            .max_anisotropy(8.0)
            // A quarter is what Vulkan has for samplers without mips: still more than 0 where texels get smaller.
            .max_lod(if sampling.mips.is_some() { vk::LOD_CLAMP_NONE } else { 0.25 });
        // SAFETY: anisotropy is only enabled where the feature is.
        let raw = check("the texture sampler", unsafe { gpu.device.create_sampler(&info, None) })?;
        Ok(Self { raw, gpu: Arc::clone(gpu) })
    }
}

impl SceneSet {
    /// The textures of a material.
    pub(super) fn material_set(&self, material: u32, filter: TextureFilter) -> vk::DescriptorSet {
        let per_filter = self.materials.sets.len() / TEXTURE_FILTERS.len();
        self.materials.sets[filter as usize * per_filter + material as usize]
    }

    /// The part of the scene that a resource of this name is.
    pub(super) fn part(&self, name: &str) -> Option<Physical> {
        let buffer = |buffer: &Buffer| Physical::Buffer { raw: buffer.raw, size_bytes: buffer.size_bytes };
        let [materials, lights] = &self.buffers;
        let query = self.query.as_ref();
        let structures = query.map(|(structures, _)| structures.buffers());
        match ScenePart::ALL.into_iter().find(|part| part.name() == name)? {
            ScenePart::Vertices => Some(buffer(&self.vertices)),
            ScenePart::Tangents => Some(buffer(&self.tangents)),
            ScenePart::PreviousVertices => self.previous_vertices.as_ref().map(buffer),
            ScenePart::Indices => Some(buffer(&self.indices)),
            ScenePart::Materials => Some(buffer(materials)),
            ScenePart::Lights => Some(buffer(lights)),
            ScenePart::Emitters => Some(buffer(&self.emitters)),
            ScenePart::EnvironmentMap => Some(self.environment.physical()[0]),
            ScenePart::EnvironmentTable => Some(self.environment.physical()[1]),
            ScenePart::Nodes => Some(self.nodes.physical()),
            ScenePart::Triangles => Some(self.triangles.physical()),
            ScenePart::TopStructure => structures.map(|[top, _]| buffer(top)),
            ScenePart::BottomStructure => structures.map(|[_, bottom]| buffer(bottom)),
            ScenePart::StructureTriangles => query.map(|(_, places)| buffer(places)),
        }
    }

    /// What the bindings of its set are that rays and lights are read from.
    #[must_use]
    pub fn binding_kinds(&self) -> Vec<BindingKind> {
        self.scene.bindings.iter().map(|(_, kind, _)| binding_kind(*kind)).collect()
    }

    /// Bytes of scratch memory that a new build of an acceleration structure takes; `None` without ray queries.
    #[must_use]
    pub fn scratch_bytes(&self, level: StructureLevel) -> Option<u64> {
        self.query.as_ref().map(|(structures, _)| structures.scratch_bytes(level))
    }

    /// Records a new build of an acceleration structure, where there are any.
    pub(super) fn record_build(&self, commands: vk::CommandBuffer, level: StructureLevel, scratch: vk::Buffer) {
        if let Some((structures, _)) = &self.query {
            structures.record_build(commands, level, scratch);
        }
    }

    /// Replaces the contents of a part between frames; waits. They fit into what was there before, and nobody needs the rest.
    ///
    /// # Errors
    /// [`Error::Failure`] when they do not fit, or the part is one that stays; when the device is lost.
    pub fn replace(&self, gpu: &Arc<Device>, part: ScenePart, bytes: &[u8]) -> Result<()> {
        let buffer = match part {
            ScenePart::Nodes => return self.nodes.replace(gpu, bytes),
            ScenePart::Triangles => return self.triangles.replace(gpu, bytes),
            ScenePart::Vertices => &self.vertices,
            ScenePart::Tangents => &self.tangents,
            ScenePart::Lights => &self.buffers[1],
            _ => return Err(Error::Failure(format!("{} are not replaced between frames", part.name()))),
        };
        if bytes.len() as u64 > buffer.size_bytes {
            let (name, room) = (part.name(), buffer.size_bytes);
            return Err(Error::Failure(format!("{} bytes do not fit {name}, which have {room}", bytes.len())));
        }
        upload_buffer(gpu, buffer, bytes)
    }

    /// Replaces the environment between frames by one of the same size; waits.
    ///
    /// # Errors
    /// [`Error::Failure`] when it has another size; when the device is lost.
    pub fn replace_environment(&self, gpu: &Arc<Device>, environment: &PreparedEnvironment) -> Result<()> {
        self.environment.replace(gpu, environment)
    }

    /// Keeps the vertices as those of the frame before, where they move; waits. Call it before they are replaced.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn keep_vertices(&self, gpu: &Arc<Device>) -> Result<()> {
        self.previous_vertices.as_ref().map_or(Ok(()), |previous| copy_buffer(gpu, &self.vertices, previous))
    }

    /// Builds the acceleration structures anew, if there are any, after the vertices have been replaced; waits.
    ///
    /// # Errors
    /// [`Error::Failure`] when there are other triangles than before; when the device is lost.
    pub fn rebuild_structures(&self, gpu: &Arc<Device>, geometry: &QueryGeometry) -> Result<()> {
        let Some((structures, places)) = &self.query else { return Ok(()) };
        structures.rebuild(gpu, geometry)?;
        upload_buffer(gpu, places, bytemuck::cast_slice(&geometry.bvh_triangles))
    }

    /// Uploads a scene.
    ///
    /// # Errors
    /// [`Error::Failure`] when a part exceeds the device's storage buffer range; [`Error::Memory`].
    pub fn new(gpu: &Arc<Device>, data: &SceneData<'_>) -> Result<Self> {
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let build_input = data.query.map_or(vk::BufferUsageFlags::empty(), |_| BUILD_INPUT);
        let vertex_usage = storage | vk::BufferUsageFlags::VERTEX_BUFFER | build_input;
        let vertices = storage_buffer(gpu, "scene vertices", data.vertices, vertex_usage)?;
        // A buffer cannot be empty: a word that says nothing stands for none.
        let no_tangent = NO_TANGENT.to_le_bytes();
        let tangents = if data.tangents.is_empty() { &no_tangent[..] } else { data.tangents };
        let tangents = storage_buffer(gpu, "scene tangents", tangents, storage)?;
        let indices = storage_buffer(gpu, "scene indices", data.indices, storage | vk::BufferUsageFlags::INDEX_BUFFER)?;
        let keep = || storage_buffer(gpu, "previous vertices", data.vertices, storage);
        let previous_vertices = data.vertices_move.then(keep).transpose()?;
        let materials = storage_buffer(gpu, "materials", data.materials, storage)?;
        let lights = storage_buffer(gpu, "scene lights", data.lights, storage)?;
        // A buffer cannot be empty: one that stands for none is not read.
        let no_emitter = [0; size_of::<Emitter>()];
        let emitters = if data.emitters.is_empty() { &no_emitter[..] } else { data.emitters };
        let emitters = storage_buffer(gpu, "emitters", emitters, storage)?;
        let nodes = WordImage::new(gpu, "BVH nodes", data.nodes, data.node_capacity_bytes)?;
        let triangles = WordImage::new(gpu, "BVH triangles", data.triangles, 0)?;
        let environment = EnvironmentParts::new(gpu, data.environment)?;
        let samplings: BTreeSet<Sampling> = data.material_textures.iter().flatten().map(|(_, s)| *s).collect();
        let mut samplers = BTreeMap::new();
        for (sampling, filter) in samplings.into_iter().flat_map(|s| TEXTURE_FILTERS.map(|filter| (s, filter))) {
            let anisotropy = gpu.features().anisotropy && filter == TextureFilter::Anisotropic;
            samplers.insert((sampling, filter as usize), Sampler::new(gpu, sampling, anisotropy)?);
        }
        let plain_sampler = Sampler::new(gpu, Sampling::default(), false)?;
        let images = upload_textures(gpu, data)?;
        let bound = |b: &Buffer| Bound::Storage { buffer: b.raw, size_bytes: b.size_bytes };
        let mut contents = vec![
            (0, nodes.bound()),
            (1, triangles.bound()),
            (2, bound(&vertices)),
            (3, bound(&indices)),
            (4, bound(&materials)),
            (5, bound(&lights)),
            (11, bound(&emitters)),
            (6, Bound::Texture { view: images[0].view, sampler: plain_sampler.raw }),
        ];
        contents.extend(environment.bound());
        let query = data.query.map(|geometry| query_parts(gpu, &vertices, geometry)).transpose()?;
        if let Some((acceleration, structure_triangles)) = &query {
            contents.extend([(7, acceleration.bound()), (8, bound(structure_triangles))]);
        }
        let scene = Sets::new(
            gpu,
            "scene",
            vk::ShaderStageFlags::COMPUTE | vk::ShaderStageFlags::VERTEX | vk::ShaderStageFlags::FRAGMENT,
            &[contents],
        )?;
        let of_material = |filter: TextureFilter, textures: &[(Option<u32>, Sampling); 3]| {
            // Image 0 is the albedo array, 1 plain white, textures follow.
            let texture = |(texture, sampling): &(Option<u32>, Sampling)| Bound::Texture {
                view: images[texture.map_or(1, |t| t as usize + 2)].view,
                sampler: samplers[&(*sampling, filter as usize)].raw,
            };
            vec![(0, texture(&textures[0])), (1, texture(&textures[1])), (2, texture(&textures[2]))]
        };
        let mut per_material = Vec::new();
        for filter in TEXTURE_FILTERS {
            per_material.extend(data.material_textures.iter().map(|textures| of_material(filter, textures)));
        }
        let material_sets = Sets::new(gpu, "material", vk::ShaderStageFlags::FRAGMENT, &per_material)?;
        Ok(Self {
            scene,
            materials: material_sets,
            vertices,
            tangents,
            previous_vertices,
            indices,
            chunks: data.chunks.clone(),
            buffers: [materials, lights],
            emitters,
            triangles,
            nodes,
            environment,
            query,
            _images: images,
            _samplers: samplers.into_values().chain([plain_sampler]).collect(),
        })
    }
}

/// The acceleration structures, and which triangle of the BVH each of theirs is.
fn query_parts(gpu: &Arc<Device>, vertices: &Buffer, geometry: &QueryGeometry) -> Result<(Acceleration, Buffer)> {
    let structure_triangles = bytemuck::cast_slice(&geometry.bvh_triangles);
    let structure_triangles =
        storage_buffer(gpu, "structure triangles", structure_triangles, vk::BufferUsageFlags::STORAGE_BUFFER)?;
    Ok((Acceleration::new(gpu, vertices, geometry)?, structure_triangles))
}

/// The albedo array, one white texel, and every texture with its mips.
fn upload_textures(gpu: &Arc<Device>, data: &SceneData<'_>) -> Result<Vec<Image>> {
    let srgb = vk::Format::R8G8B8A8_SRGB;
    let edge = data.albedo_size_px;
    let info = ImageInfo::new(srgb, edge, edge).with_layers(data.albedo_layers.len() as u32);
    let array = Image::texture(gpu, "albedo array", &info, vk::ImageUsageFlags::empty())?;
    let layers: Vec<_> = data
        .albedo_layers
        .iter()
        .enumerate()
        .map(|(layer, texels)| Subresource { mip: 0, layer: layer as u32, width_px: edge, height_px: edge, texels })
        .collect();
    upload_image(gpu, &array, &layers)?;
    let mut images = vec![array];
    let white: MipChain = vec![(1, 1, vec![255; 4])];
    images.push(upload_mips(gpu, "white", srgb, &white)?);
    for (index, (is_srgb, mips)) in data.textures.iter().enumerate() {
        let format = if *is_srgb { srgb } else { vk::Format::R8G8B8A8_UNORM };
        images.push(upload_mips(gpu, &format!("texture {index}"), format, mips)?);
    }
    Ok(images)
}

fn upload_mips(gpu: &Arc<Device>, name: &str, format: vk::Format, mips: &MipChain) -> Result<Image> {
    let (width_px, height_px, _) = mips[0];
    let limit = gpu.report().limits.image_edge_px;
    if width_px > limit || height_px > limit {
        return Err(Error::Failure(format!(
            "{name} is {width_px}x{height_px}, this device's images end at {limit}x{limit}"
        )));
    }
    let info = ImageInfo::new(format, width_px, height_px).with_levels(mips.len() as u32);
    let image = Image::texture(gpu, name, &info, vk::ImageUsageFlags::empty())?;
    let parts: Vec<_> = mips
        .iter()
        .enumerate()
        .map(|(mip, (width_px, height_px, texels))| Subresource {
            mip: mip as u32,
            layer: 0,
            width_px: *width_px,
            height_px: *height_px,
            texels,
        })
        .collect();
    upload_image(gpu, &image, &parts)?;
    Ok(image)
}
