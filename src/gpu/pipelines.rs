//! The pipelines of a device: shared between frames, compiled on several threads, kept on disk between runs.

use std::collections::HashMap;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use ash::vk;

use super::check;
use super::descriptors::{Binding, Sets};
use super::device::Device;
use super::pipeline::{self, Pipeline};
use super::pipeline_file::{Owner, PipelineFile};
use super::work::{Constants, RasterDraw, RasterState};
use crate::error::Result;
use crate::shader::spirv;

/// The most pipelines that are kept although no frame has them: those of some dozens of techniques and settings.
const MOST_IDLE: usize = 1000;

/// All pipelines so far, by everything that they are made of: a frame of another size, and one that a run comes back to,
/// share them. Drivers that compile shaders at their first use do so once.
pub(super) struct Pipelines {
    known: Mutex<HashMap<Key, Arc<Pipeline>>>,
    cache: DriverCache,
    gpu: Arc<Device>,
}

/// A shader by name, and by the hash of its source where that replaces the embedded one.
type Shader = (String, Option<String>);

/// What a pipeline is made of. Sets count by their bindings: layouts of the same bindings are compatible.
#[derive(PartialEq, Eq, Hash)]
struct Key {
    shaders: Vec<Shader>,
    constants: Constants,
    push_words: usize,
    sets: Vec<Vec<Binding>>,
    /// Of graphics pipelines alone.
    raster: Option<RasterKey>,
}

#[derive(PartialEq, Eq, Hash)]
struct RasterKey {
    state: RasterState,
    color_formats: Vec<vk::Format>,
    depth_format: vk::Format,
}

fn shader(name: &str) -> Shader {
    (name.to_owned(), spirv::replaced_hash(name))
}

fn bindings(sets: &[&Sets]) -> Vec<Vec<Binding>> {
    sets.iter().map(|set| set.bindings.clone()).collect()
}

fn raw_layouts(sets: &[&Sets]) -> Vec<vk::DescriptorSetLayout> {
    sets.iter().map(|set| set.layout).collect()
}

impl Pipelines {
    /// None yet. In `folder` the driver's cache is kept from run to run.
    pub fn new(gpu: &Arc<Device>, folder: Option<&Path>) -> Result<Self> {
        Ok(Self { known: Mutex::default(), cache: DriverCache::new(gpu, folder)?, gpu: Arc::clone(gpu) })
    }

    /// A compute pipeline.
    pub fn compute(
        &self,
        name: &str,
        constants: &Constants,
        push_words: usize,
        sets: &[&Sets],
    ) -> Result<Arc<Pipeline>> {
        let key = Key {
            shaders: vec![shader(name)],
            constants: constants.clone(),
            push_words,
            sets: bindings(sets),
            raster: None,
        };
        self.find(key, || {
            pipeline::create_compute(&self.gpu, self.cache.raw, name, constants, push_words, &raw_layouts(sets))
        })
    }

    /// A graphics pipeline for dynamic rendering into the given formats.
    pub fn graphics(
        &self,
        draw: &RasterDraw,
        color_formats: &[vk::Format],
        depth_format: vk::Format,
        sets: &[&Sets],
    ) -> Result<Arc<Pipeline>> {
        let RasterDraw { vertex, fragment, constants, push, state, .. } = draw;
        let key = Key {
            shaders: vec![shader(vertex), shader(fragment)],
            constants: constants.clone(),
            push_words: push.len(),
            sets: bindings(sets),
            raster: Some(RasterKey { state: *state, color_formats: color_formats.to_vec(), depth_format }),
        };
        self.find(key, || {
            let layouts = raw_layouts(sets);
            pipeline::compile_graphics(&self.gpu, self.cache.raw, draw, color_formats, depth_format, &layouts)
        })
    }

    /// The pipeline of this key, made by `create` when there is none. Several threads may create at once.
    fn find(&self, key: Key, create: impl FnOnce() -> Result<Pipeline>) -> Result<Arc<Pipeline>> {
        if let Some(pipeline) = self.known().get(&key) {
            return Ok(Arc::clone(pipeline));
        }
        let pipeline = Arc::new(create()?);
        let mut known = self.known();
        let is_idle = |pipeline: &Arc<Pipeline>| Arc::strong_count(pipeline) == 1;
        if known.values().filter(|pipeline| is_idle(pipeline)).count() > MOST_IDLE {
            known.retain(|_, pipeline| !is_idle(pipeline));
        }
        // Another thread may have been faster.
        Ok(Arc::clone(known.entry(key).or_insert(pipeline)))
    }

    fn known(&self) -> MutexGuard<'_, HashMap<Key, Arc<Pipeline>>> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The driver's own cache of compiled pipelines. It locks itself.
struct DriverCache {
    /// Null without a file.
    raw: vk::PipelineCache,
    /// Where it is kept, and what it was filled with.
    kept: Option<(PipelineFile, Vec<u8>)>,
    gpu: Arc<Device>,
}

impl DriverCache {
    fn new(gpu: &Arc<Device>, folder: Option<&Path>) -> Result<Self> {
        let Some(folder) = folder else {
            return Ok(Self { raw: vk::PipelineCache::null(), kept: None, gpu: Arc::clone(gpu) });
        };
        // SAFETY: the physical device comes from this instance.
        let properties = unsafe { gpu.instance.raw.get_physical_device_properties(gpu.physical) };
        let vk::PhysicalDeviceProperties { vendor_id, device_id, pipeline_cache_uuid: uuid, .. } = properties;
        let file = PipelineFile::new(folder, Owner { vendor_id, device_id, uuid });
        let data = file.read();
        let info = vk::PipelineCacheCreateInfo::default().initial_data(&data);
        // SAFETY: the data is what this driver gave, by checksum and header; destroyed in `drop`.
        let raw = check("the pipeline cache", unsafe { gpu.device.create_pipeline_cache(&info, None) })?;
        Ok(Self { raw, kept: Some((file, data)), gpu: Arc::clone(gpu) })
    }

    /// Writes the file if there is anything new.
    fn keep(&self) {
        let Some((file, before)) = &self.kept else { return };
        // SAFETY: the cache is alive, and no pipeline is being created.
        match unsafe { self.gpu.device.get_pipeline_cache_data(self.raw) } {
            Ok(data) if data == *before => {}
            Ok(data) => file.write(&data),
            Err(result) => log::info!("the driver does not give its pipelines: {result}"),
        }
    }
}

impl Drop for DriverCache {
    fn drop(&mut self) {
        self.keep();
        // SAFETY: pipelines do not need the cache once they are made; a null one is ignored.
        unsafe { self.gpu.device.destroy_pipeline_cache(self.raw, None) };
    }
}
