//! `--dump DIR`: every intermediate of a frame in files that other programs read (`docs/dumps.md`).

pub mod contents;
pub mod diff;
pub mod folder;
pub mod images;
pub mod manifest;
pub mod table;

use std::sync::Arc;

use serde_json::{Value, json};

pub use crate::dump::array;
use crate::dump::{Array, Contents, Derived, DumpContext, Scalar, all_words};
use crate::gpu::{Gpu, Work, Written};
use crate::graph::{ImageDepth, ImageInfo, PREVIOUS, Resource, ResourceInfo};
use crate::renderer::{Renderer, UploadedScene};
use crate::report::timings::{Device, Program, SceneInfo};
use crate::scene::{Scene, upload};
use crate::settings::Settings;
use crate::shared::FrameData;
use crate::techniques::{Shapes, Technique};
use crate::{Error, Result};
use folder::DumpFolder;
use images::Picture;
use manifest::{FileEntry, Manifest, SCHEMA, frame_constants};
use table::{entry, others};

/// Stands for a pass where something is of the frame before, and its folder.
const HISTORY: &str = "history";

/// What a dump is made of.
pub struct Sources<'a> {
    /// The device.
    pub gpu: &'a Arc<Gpu>,
    /// The scene.
    pub scene: &'a Scene,
    /// The scene on the device.
    pub uploaded: &'a UploadedScene,
    /// The compiled frame.
    pub renderer: &'a Renderer,
    /// The settings, as used.
    pub settings: &'a Settings,
    /// What the manifest says of the scene.
    pub scene_info: &'a SceneInfo,
}

/// Renders one more frame pass by pass and writes everything into the folder, which does not show before its
/// [`DumpFolder::commit`].
///
/// # Errors
/// Device errors, and [`Error::File`] when a file cannot be written.
pub fn write(folder: &mut DumpFolder, sources: &Sources<'_>) -> Result<()> {
    write_scene(folder, sources)?;
    let graph = sources.renderer.executor().graph();
    let Shapes { frame: shape, technique } = sources.renderer.shapes();
    let known = DumpContext::new(shape, (**technique).as_any());
    let mut frame = FrameDump { folder, known, shapes: sources.renderer.shapes() };
    frame.known.pass = HISTORY.to_owned();
    for part in sources.renderer.read_history()? {
        frame.add(None, &graph.resources()[part.resource], &part)?;
    }
    sources.renderer.run_and_read(|index, written| {
        let pass = &graph.passes()[index];
        frame.known.pass.clone_from(&pass.name);
        frame.known.push = match &pass.payload {
            Work::Compute(work) => work.push.clone(),
            _ => Vec::new(),
        };
        if index == 0 {
            frame.add_filled(graph.resources())?;
        }
        frame.add_pass(index, graph.resources(), &written)?;
        frame.add_derived(index, graph.resources(), &written, sources.renderer.frame_data())
    })?;
    let manifest = Manifest {
        schema: SCHEMA.to_owned(),
        program: value(Program::this())?,
        device: value(Device::of(sources.gpu.report()))?,
        scene: value(sources.scene_info)?,
        settings: value(sources.settings)?,
        shape: shape_json(sources.renderer.shapes()),
        frame: frame_constants(sources.renderer.frame_data()),
        passes: sources.renderer.pass_names(),
        files: folder.files().to_vec(),
    };
    folder.add_manifest(&manifest)
}

fn value(part: impl serde::Serialize) -> Result<Value> {
    serde_json::to_value(part).map_err(|error| Error::Failure(format!("cannot express the manifest as JSON: {error}")))
}

fn shape_json(shapes: &Shapes) -> Value {
    let mut sizes = shapes.technique.manifest();
    sizes.insert("size_px".to_owned(), json!([shapes.frame.width_px, shapes.frame.height_px]));
    Value::Object(sizes)
}

fn write_scene(folder: &mut DumpFolder, sources: &Sources<'_>) -> Result<()> {
    let bytes = sources.uploaded.read_back(sources.gpu)?;
    let triangles = sources.scene.indices.len() as u64 / 3;
    let materials = sources.scene.materials.len() as u64;
    let lights = u64::from(sources.uploaded.light_count());
    for (about, array, size) in [
        (others::PUNCTUAL_LIGHTS, contents::punctual_lights(&bytes.lights, lights), bytes.lights.len()),
        (others::TRIANGLES, contents::triangles(&bytes.triangles, triangles), bytes.triangles.len()),
        (others::MATERIALS, contents::materials(&bytes.materials, materials), bytes.materials.len()),
    ] {
        add_input(folder, about, &array, size)?;
    }
    let environment = upload::environment(sources.scene);
    if environment.cells[0] > 0 {
        let [map, table] = [contents::environment_map(&environment), contents::environment_table(&environment)];
        add_input(folder, others::ENVIRONMENT_MAP, &map, size_of_val(environment.texels.as_slice()))?;
        add_input(folder, others::ENVIRONMENT_TABLE, &table, table.bytes.len())?;
    }
    Ok(())
}

/// Adds a part of the scene, which takes so many bytes on the device.
fn add_input(folder: &mut DumpFolder, about: (&str, &str, &str), array: &Array, size_bytes: usize) -> Result<()> {
    let (resource, units, meaning) = about;
    let mut entry = array_entry(None, "scene", resource, array);
    entry.kind = "scene".to_owned();
    entry.resource_bytes = size_bytes as u64;
    (entry.units, entry.meaning) = (units.to_owned(), meaning.to_owned());
    folder.add_array(entry, array)
}

/// A frame on its way into the folder.
struct FrameDump<'a> {
    folder: &'a mut DumpFolder,
    known: DumpContext<'a>,
    shapes: &'a Shapes,
}

impl FrameDump<'_> {
    fn technique(&self) -> &'static dyn Technique {
        self.shapes.technique.technique()
    }

    /// What the host has put into buffers before the first frame, as if the first pass had written it.
    fn add_filled(&mut self, resources: &[Resource]) -> Result<()> {
        let filled = resources.iter().enumerate().filter_map(|(i, resource)| Some((i, resource.contents.as_ref()?)));
        filled
            .map(|(resource, contents)| Written { resource, level: 0, bytes: contents.to_vec() })
            .try_for_each(|part| self.add(Some(0), &resources[part.resource], &part))
    }

    fn add_pass(&mut self, index: usize, resources: &[Resource], written: &[Written]) -> Result<()> {
        for part in written {
            let name = &resources[part.resource].name;
            if entry(self.technique(), name).is_some_and(|about| about.noted) {
                self.known.note(name, &part.bytes);
            }
        }
        written.iter().try_for_each(|part| self.add(Some(index), &resources[part.resource], part))
    }

    /// Adds what a pass has written, or without one what the frame before has left, which is described like what this one
    /// leaves.
    fn add(&mut self, index: Option<usize>, resource: &Resource, Written { level, bytes, .. }: &Written) -> Result<()> {
        let of_history = resource.name.strip_prefix(PREVIOUS).filter(|_| index.is_none());
        let about = entry(self.technique(), of_history.unwrap_or(&resource.name));
        let pass = self.known.pass.clone();
        let finish = |mut file: FileEntry, size_bytes: usize| {
            file.resource_bytes = size_bytes as u64;
            file.units = about.map_or("unknown", |a| a.units).to_owned();
            let meaning = about.map_or("No description.", |a| a.meaning);
            file.meaning = of_history.map_or_else(|| meaning.to_owned(), |_| format!("Of the frame before. {meaning}"));
            file
        };
        let interleaved = about.is_some_and(|a| a.interleaved) && self.shapes.technique.is_interleaved();
        let layout = if interleaved { "interleaved" } else { "picture" };
        match resource.info {
            ResourceInfo::Image(info) => {
                let names = match about.map(|a| a.contents) {
                    Some(Contents::Image(names)) => names,
                    _ => &["R", "G", "B", "A"],
                };
                for (slice, texels) in slices(&info, *level, bytes) {
                    let [width_px, height_px, _] = info.level_size_px(*level);
                    let picture = Picture::from_texels(info.format, [width_px, height_px], names, texels)?;
                    let name = format!("{}{slice}", resource.name);
                    let mut file = finish(image_entry(index, &pass, &name, &picture), texels.len());
                    file.layout = Some(layout.to_owned());
                    self.folder.add_picture(file, &picture)?;
                }
                Ok(())
            }
            ResourceInfo::Buffer(_) => {
                let unpack = match about.map(|a| a.contents) {
                    // How much of it was in use is no longer known.
                    Some(Contents::Buffer(unpack)) if of_history.is_none() => unpack,
                    _ => all_words,
                };
                let array = unpack(bytes, &self.known);
                let mut file = finish(array_entry(index, &pass, &resource.name, &array), bytes.len());
                file.layout = about.is_some_and(|a| a.interleaved).then(|| layout.to_owned());
                self.folder.add_array(file, &array)
            }
        }
    }

    /// What the technique makes of what a pass has written.
    fn add_derived(
        &mut self,
        index: usize,
        resources: &[Resource],
        written: &[Written],
        data: &FrameData,
    ) -> Result<()> {
        for part in written {
            let resource = &resources[part.resource].name;
            let derived = self.shapes.technique.derived(resource, &part.bytes, &self.known, data);
            let Some(Derived { name, units, meaning, array }) = derived else { continue };
            let mut file = array_entry(Some(index), &self.known.pass, name, &array);
            file.kind = "derived".to_owned();
            file.resource_bytes = array.bytes.len() as u64;
            (file.units, file.meaning) = (units.to_owned(), meaning.to_owned());
            self.folder.add_array(file, &array)?;
        }
        Ok(())
    }
}

/// The flat images that a level is made of, each with what its name ends in.
fn slices<'a>(info: &ImageInfo, level: u32, texels: &'a [u8]) -> Vec<(String, &'a [u8])> {
    let of_level = if info.level_count > 1 { format!("_level_{level}") } else { String::new() };
    let [_, _, depth_px] = info.level_size_px(level);
    let (what, count) = match info.depth {
        ImageDepth::Flat => return vec![(of_level, texels)],
        ImageDepth::Layers(count) => ("layer", count),
        ImageDepth::Texels(_) => ("slice", depth_px),
    };
    let parts = texels.chunks_exact(texels.len() / count as usize).enumerate();
    parts.map(|(index, part)| (format!("{of_level}_{what}_{index}"), part)).collect()
}

fn array_entry(pass_index: Option<usize>, pass: &str, resource: &str, array: &Array) -> FileEntry {
    let scale = |name: &str, scalar| match (resource, name, scalar) {
        (_, "normal_octahedral", _) => Some(1.0 / 32767.0),
        ("moments", _, Scalar::I64) => Some(0.5_f64.powi(40)),
        _ => None,
    };
    let scales = array.fields.iter().filter_map(|f| Some((f.name.clone(), scale(&f.name, f.scalar)?)));
    FileEntry {
        file: file_name(pass_index, pass, resource, "npy"),
        dtype: array.dtype_json(),
        shape: array.shape.clone(),
        first_element: array.first,
        scale: scales.collect(),
        ..blank(pass_index, pass, resource, "buffer")
    }
}

fn image_entry(pass_index: Option<usize>, pass: &str, resource: &str, picture: &Picture) -> FileEntry {
    FileEntry {
        file: file_name(pass_index, pass, resource, "exr"),
        dtype: json!(picture.scalar.type_string()),
        shape: vec![picture.height_px.into(), picture.width_px.into()],
        channels: picture.channels.iter().map(|(name, _)| name.clone()).collect(),
        ..blank(pass_index, pass, resource, "image")
    }
}

fn blank(pass_index: Option<usize>, pass: &str, resource: &str, kind: &str) -> FileEntry {
    FileEntry {
        pass_index,
        pass: pass.to_owned(),
        resource: resource.to_owned(),
        kind: kind.to_owned(),
        file: String::new(),
        dtype: Value::Null,
        shape: Vec::new(),
        channels: Vec::new(),
        first_element: 0,
        resource_bytes: 0,
        layout: None,
        scale: std::collections::BTreeMap::new(),
        units: String::new(),
        meaning: String::new(),
    }
}

/// A folder for each pass, in the order of the frame.
fn file_name(pass_index: Option<usize>, pass: &str, resource: &str, extension: &str) -> String {
    let folder = pass_index.map_or_else(|| pass.to_owned(), |i| format!("{i:03}_{}", pass.replace('/', ".")));
    format!("{folder}/{resource}.{extension}")
}

#[cfg(test)]
mod tests;
