//! `--dump DIR`: every intermediate of a frame in files that other programs read (`docs/dumps.md`).

pub mod array;
pub mod contents;
pub mod diff;
pub mod folder;
pub mod images;
pub mod manifest;
pub mod table;

use std::sync::Arc;

use serde_json::{Value, json};

use crate::gpu::{Gpu, Work, Written};
use crate::graph::{Resource, ResourceInfo};
use crate::passes::FrameShape;
use crate::renderer::{Renderer, UploadedScene};
use crate::report::timings::{Device, Program, SceneInfo};
use crate::scene::Scene;
use crate::settings::Settings;
use crate::shared::{GridLight, GridPlacement};
use crate::{Error, Result};
use array::{Array, Scalar};
use contents::Known;
use folder::DumpFolder;
use images::Picture;
use manifest::{FileEntry, Manifest, SCHEMA, frame_constants};
use table::{Contents, entry, others};

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
    let mut frame = FrameDump { folder, known: Known::new(sources.renderer.shape().clone()), placement: None };
    sources.renderer.run_and_read(|index, written| {
        let pass = &graph.passes()[index];
        frame.known.pass.clone_from(&pass.name);
        frame.known.push = match &pass.payload {
            Work::Compute(work) => work.push.clone(),
            _ => Vec::new(),
        };
        frame.add_pass(index, graph.resources(), &written)?;
        let alpha = sources.renderer.frame_data().tuning[0];
        frame.add_radii(index, graph.resources(), &written, alpha)
    })?;
    Manifest {
        schema: SCHEMA.to_owned(),
        program: value(Program::this())?,
        device: value(Device::of(sources.gpu.report()))?,
        scene: value(sources.scene_info)?,
        settings: value(sources.settings)?,
        shape: shape_json(sources.renderer.shape()),
        frame: frame_constants(sources.renderer.frame_data()),
        passes: sources.renderer.pass_names(),
        files: folder.files().to_vec(),
    }
    .write(folder.path())
}

fn value(part: impl serde::Serialize) -> Result<Value> {
    serde_json::to_value(part).map_err(|error| Error::Failure(format!("cannot express the manifest as JSON: {error}")))
}

fn shape_json(shape: &FrameShape) -> Value {
    json!({
        "size_px": [shape.width_px, shape.height_px],
        "sub_image_px": shape.sub_image_px(),
        "interleaved_px": shape.interleaved_px(),
        "interleave": shape.interleave,
        "top_level": shape.levels.top,
        "first_level": shape.first_level,
        "slots": shape.slot_count(),
        "light_capacity": shape.light_capacity(),
        "grid_capacity": shape.grid_capacity,
        "upper_capacity": shape.upper_capacity,
        "shadow_samples": shape.shadow_samples,
    })
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
        let (resource, units, meaning) = about;
        let mut entry = array_entry(None, "scene", resource, &array);
        entry.kind = "scene".to_owned();
        entry.resource_bytes = size as u64;
        (entry.units, entry.meaning) = (units.to_owned(), meaning.to_owned());
        folder.add_array(entry, &array)?;
    }
    Ok(())
}

/// A frame on its way into the folder.
struct FrameDump<'a> {
    folder: &'a mut DumpFolder,
    known: Known,
    placement: Option<GridPlacement>,
}

impl FrameDump<'_> {
    fn add_pass(&mut self, index: usize, resources: &[Resource], written: &[Written]) -> Result<()> {
        for part in written {
            let name = &resources[part.resource].name;
            self.known.note(name, &part.bytes);
            if name == "grid_placement" {
                self.placement = Some(bytemuck::pod_read_unaligned(&part.bytes));
            }
        }
        written.iter().try_for_each(|part| self.add(index, &resources[part.resource], &part.bytes))
    }

    fn add(&mut self, index: usize, resource: &Resource, bytes: &[u8]) -> Result<()> {
        let about = entry(&resource.name);
        let pass = self.known.pass.clone();
        let finish = |mut file: FileEntry| {
            file.resource_bytes = bytes.len() as u64;
            file.units = about.map_or("unknown", |a| a.units).to_owned();
            file.meaning = about.map_or("No description.", |a| a.meaning).to_owned();
            file
        };
        let interleaved = about.is_some_and(|a| a.interleaved) && self.known.shape.interleave > 1;
        let layout = if interleaved { "interleaved" } else { "picture" };
        match resource.info {
            ResourceInfo::Image(info) => {
                let names = match about.map(|a| a.contents) {
                    Some(Contents::Image(names)) => names,
                    _ => &["R", "G", "B", "A"],
                };
                let picture = Picture::from_texels(&info, names, bytes)?;
                let mut file = finish(image_entry(index, &pass, &resource.name, &picture));
                file.layout = Some(layout.to_owned());
                self.folder.add_picture(file, &picture)
            }
            ResourceInfo::Buffer(_) => {
                let unpack = match about.map(|a| a.contents) {
                    Some(Contents::Buffer(unpack)) => unpack,
                    _ => contents::all_words,
                };
                let array = unpack(bytes, &self.known);
                let mut file = finish(array_entry(Some(index), &pass, &resource.name, &array));
                file.layout = about.is_some_and(|a| a.interleaved).then(|| layout.to_owned());
                self.folder.add_array(file, &array)
            }
        }
    }

    /// The blending radius of every merged light, which the shaders compute where they need it.
    fn add_radii(&mut self, index: usize, resources: &[Resource], written: &[Written], alpha: f32) -> Result<()> {
        let merged = written.iter().find(|part| resources[part.resource].name == "merged_lights");
        let (Some(merged), Some(placement)) = (merged, self.placement) else { return Ok(()) };
        let list = contents::merged_lights(&merged.bytes, &self.known);
        let lights: Vec<GridLight> = bytemuck::pod_collect_to_vec(&list.bytes);
        let top = self.known.shape.levels.top as i32;
        let radius = |light: &GridLight| alpha * (placement.h_top * 2.0_f32.powi(light.level as i32 - top));
        let radii: Vec<u8> = lights.iter().flat_map(|light| radius(light).to_le_bytes()).collect();
        let array = Array::plain(Scalar::F32, &list.shape, &radii);
        let (resource, units, meaning) = others::BLENDING_RADII;
        let mut file = array_entry(Some(index), &self.known.pass, resource, &array);
        file.kind = "derived".to_owned();
        file.resource_bytes = radii.len() as u64;
        (file.units, file.meaning) = (units.to_owned(), meaning.to_owned());
        self.folder.add_array(file, &array)
    }
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

fn image_entry(pass_index: usize, pass: &str, resource: &str, picture: &Picture) -> FileEntry {
    FileEntry {
        file: file_name(Some(pass_index), pass, resource, "exr"),
        dtype: json!(picture.scalar.type_string()),
        shape: vec![picture.height_px.into(), picture.width_px.into()],
        channels: picture.channels.iter().map(|(name, _)| name.clone()).collect(),
        ..blank(Some(pass_index), pass, resource, "image")
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
