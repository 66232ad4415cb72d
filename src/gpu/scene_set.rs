//! The scene on the GPU: descriptor set 1 for shaders that trace rays or read lights, descriptor set 2 per
//! material for the G-buffer.

use std::sync::Arc;

use ash::vk;

use super::acceleration::{Acceleration, BUILD_INPUT};
use super::buffer::Buffer;
use super::check;
use super::descriptors::{Bound, Sets};
use super::device::Device;
use super::environment::EnvironmentParts;
use super::image::Image;
use super::physical::Physical;
use super::transfer::{Subresource, storage_buffer, upload_image};
use super::word_image::WordImage;
use super::work::StructureLevel;
use crate::environment::upload::PreparedEnvironment;
use crate::error::{Error, Result};
use crate::graph::ImageInfo;
use crate::scene::Draw;
use crate::scene::query_geometry::QueryGeometry;
use crate::scene::upload::MipChain;

/// Everything uploaded, as plain bytes and texels.
pub struct SceneData<'a> {
    /// BVH nodes.
    pub nodes: &'a [u8],
    /// BVH triangles in leaf order.
    pub triangles: &'a [u8],
    /// Scene vertices.
    pub vertices: &'a [u8],
    /// Three indices per triangle.
    pub indices: &'a [u8],
    /// Triangles for ray queries; `None` leaves the acceleration structures out.
    pub query: Option<&'a QueryGeometry>,
    /// `GpuMaterial`s.
    pub materials: &'a [u8],
    /// `PunctualLight`s, directional and spot lights first.
    pub lights: &'a [u8],
    /// Light from all around.
    pub environment: &'a PreparedEnvironment,
    /// Edge of the albedo array's layers.
    pub albedo_size_px: u32,
    /// Layers of the albedo array, at least one.
    pub albedo_layers: &'a [Vec<u8>],
    /// Textures at full resolution; sRGB or linear.
    pub textures: &'a [(bool, MipChain)],
    /// Per material: base-colour and normal texture.
    pub material_textures: &'a [(Option<u32>, Option<u32>)],
    /// Draws of the G-buffer.
    pub draws: &'a [Draw],
}

/// A part of the scene that frames have as an imported resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScenePart {
    /// Scene vertices, a buffer.
    Vertices,
    /// Three indices per triangle, a buffer.
    Indices,
    /// `GpuMaterial`s, a buffer.
    Materials,
    /// `PunctualLight`s, a buffer.
    Lights,
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
    const ALL: [Self; 11] = [
        Self::Vertices,
        Self::Indices,
        Self::Materials,
        Self::Lights,
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
            Self::Indices => "scene_indices",
            Self::Materials => "scene_materials",
            Self::Lights => "scene_lights",
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

/// The uploaded scene.
pub struct SceneSet {
    pub(super) scene: Sets,
    pub(super) materials: Sets,
    pub(super) vertices: Buffer,
    pub(super) indices: Buffer,
    pub(super) draws: Vec<Draw>,
    /// Materials, lights.
    pub(super) buffers: [Buffer; 2],
    /// BVH triangles.
    pub(super) triangles: WordImage,
    nodes: WordImage,
    environment: EnvironmentParts,
    query: Option<(Acceleration, Buffer)>,
    _images: Vec<Image>,
    _samplers: [Sampler; 2],
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
    /// Trilinear and repeating. Anisotropy only where derivatives exist: with an explicit level of detail
    /// lavapipe 22.3 takes 10 ms for one anisotropic sample.
    fn new(gpu: &Arc<Device>, anisotropy: bool) -> Result<Self> {
        let info = vk::SamplerCreateInfo::default()
            .mag_filter(vk::Filter::LINEAR)
            .min_filter(vk::Filter::LINEAR)
            .mipmap_mode(vk::SamplerMipmapMode::LINEAR)
            .address_mode_u(vk::SamplerAddressMode::REPEAT)
            .address_mode_v(vk::SamplerAddressMode::REPEAT)
            .anisotropy_enable(anisotropy)
            .max_anisotropy(8.0)
            .max_lod(vk::LOD_CLAMP_NONE);
        // SAFETY: anisotropy is only enabled where the feature is.
        let raw = check("the texture sampler", unsafe { gpu.device.create_sampler(&info, None) })?;
        Ok(Self { raw, gpu: Arc::clone(gpu) })
    }
}

impl SceneSet {
    /// The part of the scene that a resource of this name is.
    pub(super) fn part(&self, name: &str) -> Option<Physical> {
        let buffer = |buffer: &Buffer| Physical::Buffer { raw: buffer.raw, size_bytes: buffer.size_bytes };
        let [materials, lights] = &self.buffers;
        let query = self.query.as_ref();
        let structures = query.map(|(structures, _)| structures.buffers());
        match ScenePart::ALL.into_iter().find(|part| part.name() == name)? {
            ScenePart::Vertices => Some(buffer(&self.vertices)),
            ScenePart::Indices => Some(buffer(&self.indices)),
            ScenePart::Materials => Some(buffer(materials)),
            ScenePart::Lights => Some(buffer(lights)),
            ScenePart::EnvironmentMap => Some(self.environment.physical()[0]),
            ScenePart::EnvironmentTable => Some(self.environment.physical()[1]),
            ScenePart::Nodes => Some(self.nodes.physical()),
            ScenePart::Triangles => Some(self.triangles.physical()),
            ScenePart::TopStructure => structures.map(|[top, _]| buffer(top)),
            ScenePart::BottomStructure => structures.map(|[_, bottom]| buffer(bottom)),
            ScenePart::StructureTriangles => query.map(|(_, places)| buffer(places)),
        }
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

    /// Uploads a scene.
    ///
    /// # Errors
    /// [`Error::Failure`] when a part exceeds the device's storage buffer range; [`Error::Memory`].
    pub fn new(gpu: &Arc<Device>, data: &SceneData<'_>) -> Result<Self> {
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let build_input = data.query.map_or(vk::BufferUsageFlags::empty(), |_| BUILD_INPUT);
        let vertex_usage = storage | vk::BufferUsageFlags::VERTEX_BUFFER | build_input;
        let vertices = storage_buffer(gpu, "scene vertices", data.vertices, vertex_usage)?;
        let indices = storage_buffer(gpu, "scene indices", data.indices, storage | vk::BufferUsageFlags::INDEX_BUFFER)?;
        let materials = storage_buffer(gpu, "materials", data.materials, storage)?;
        let lights = storage_buffer(gpu, "scene lights", data.lights, storage)?;
        let nodes = WordImage::new(gpu, "BVH nodes", data.nodes)?;
        let triangles = WordImage::new(gpu, "BVH triangles", data.triangles)?;
        let environment = EnvironmentParts::new(gpu, data.environment)?;
        let sampler = Sampler::new(gpu, gpu.features().anisotropy)?;
        let plain_sampler = Sampler::new(gpu, false)?;
        let images = upload_textures(gpu, data)?;
        let bound = |b: &Buffer| Bound::Storage { buffer: b.raw, size_bytes: b.size_bytes };
        let texture = |i: &Image| Bound::Texture { view: i.view, sampler: sampler.raw };
        let mut contents = vec![
            (0, nodes.bound()),
            (1, triangles.bound()),
            (2, bound(&vertices)),
            (3, bound(&indices)),
            (4, bound(&materials)),
            (5, bound(&lights)),
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
        let per_material: Vec<_> = data
            .material_textures
            .iter()
            .map(|(color, normal)| {
                // Image 0 is the albedo array, 1 plain white, textures follow.
                let image = |t: &Option<u32>| &images[t.map_or(1, |t| t as usize + 2)];
                vec![(0, texture(image(color))), (1, texture(image(normal)))]
            })
            .collect();
        let material_sets = Sets::new(gpu, "material", vk::ShaderStageFlags::FRAGMENT, &per_material)?;
        Ok(Self {
            scene,
            materials: material_sets,
            vertices,
            indices,
            draws: data.draws.to_vec(),
            buffers: [materials, lights],
            triangles,
            nodes,
            environment,
            query,
            _images: images,
            _samplers: [sampler, plain_sampler],
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
