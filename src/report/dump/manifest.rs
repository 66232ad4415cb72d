//! `manifest.json`: what a dump was made with, and what each of its files is.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::files::read_text;
use crate::shared::FrameData;
use crate::{Error, Result};

/// The version of a dump's layout.
pub const SCHEMA: &str = "gridlight-dump/1";
/// The manifest's name in the dump's folder.
pub const FILE_NAME: &str = "manifest.json";

/// One file of a dump.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FileEntry {
    /// Position of the pass in `passes`; none for the scene.
    pub pass_index: Option<usize>,
    /// The pass that wrote the resource, or `scene`.
    pub pass: String,
    /// The graph's name of the resource.
    pub resource: String,
    /// `buffer`, `image`, `scene` (an input) or `derived` (computed for the dump).
    pub kind: String,
    /// Path in the folder, with `/`.
    pub file: String,
    /// NumPy's type string; for records a list of `[name, type string, shape]`.
    pub dtype: Value,
    /// Elements along each axis; for images height and width.
    pub shape: Vec<u64>,
    /// Channels of an image.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub channels: Vec<String>,
    /// Index in the resource of the file's first element.
    pub first_element: u64,
    /// Bytes of the whole resource, used or not.
    pub resource_bytes: u64,
    /// `picture`, or `interleaved` for sub-images side by side; none for what has no pixels.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub layout: Option<String>,
    /// Fields of integers that stand for real numbers, with the factor that gives them; an array without names has
    /// the name ``.
    #[serde(skip_serializing_if = "BTreeMap::is_empty", default)]
    pub scale: BTreeMap<String, f64>,
    /// Units of the numbers.
    pub units: String,
    /// What the resource holds, in a sentence.
    pub meaning: String,
}

/// The whole manifest.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Always [`SCHEMA`].
    pub schema: String,
    /// The program that ran.
    pub program: Value,
    /// The device it ran on.
    pub device: Value,
    /// The scene it rendered.
    pub scene: Value,
    /// Every setting, as used.
    pub settings: Value,
    /// Sizes, capacities and modes of the frame.
    pub shape: Value,
    /// The frame's constants by name.
    pub frame: Value,
    /// Every pass in order.
    pub passes: Vec<String>,
    /// Every file, in the order of the frame.
    pub files: Vec<FileEntry>,
}

impl Manifest {
    /// Reads the manifest of a dump's folder.
    ///
    /// # Errors
    /// [`Error::File`] when there is none, or it is no manifest of this version.
    pub fn read(folder: &Path) -> Result<Self> {
        let path = folder.join(FILE_NAME);
        let text = read_text(&path)
            .map_err(|error| Error::file(&path, format!("cannot be read, so that this is no dump: {error}")))?;
        let json: Value =
            serde_json::from_str(&text).map_err(|error| Error::file(&path, format!("is not JSON: {error}")))?;
        let schema = json.get("schema").and_then(Value::as_str).unwrap_or("nothing");
        if schema != SCHEMA {
            return Err(Error::file(&path, format!("is not the manifest of a dump: schema is {schema}, not {SCHEMA}")));
        }
        serde_json::from_value(json).map_err(|error| Error::file(&path, format!("is damaged: {error}")))
    }

    /// Writes the manifest into a dump's folder.
    ///
    /// # Errors
    /// [`Error::File`] when that fails.
    pub fn write(&self, folder: &Path) -> Result<()> {
        let path = folder.join(FILE_NAME);
        let mut text = serde_json::to_vec_pretty(self).map_err(|error| Error::file(&path, error))?;
        text.push(b'\n');
        std::fs::write(&path, text).map_err(|error| Error::file(&path, format!("cannot be written: {error}")))
    }
}

/// The frame's constants by name.
#[must_use]
pub fn frame_constants(data: &FrameData) -> Value {
    json!({
        "clip_from_world": data.clip_from_world,
        "eye_ws": data.eye_ws,
        "near": data.near,
        "jitter_px": [data.jitter_x_px, data.jitter_y_px],
        "forward_ws": data.forward_ws,
        "right_ws": data.right_ws,
        "rasteriser_step": data.rasteriser_step,
        "up_ws": data.up_ws,
        "scene_center_ws": data.scene_center_ws,
        "scene_radius": data.scene_radius,
        "size_px": data.size_px,
        "sub_image_px": data.sub_image_px,
        "interleave": data.interleave,
        "shadow_samples": data.shadow_samples,
        "shadow_from": data.shadow_from,
        "first_level": data.first_level,
        "top_level": data.top_level,
        "vpl_capacity": data.vpl_capacity,
        "path_count": data.path_count,
        "bounces": data.bounces,
        "seed": data.seed,
        "sampling_seed": data.sampling_seed,
        "accumulated_frame": data.accumulated_frame,
        "direct_lights": data.direct_lights,
        "first_point_light": data.first_point_light,
        "scene_lights": data.scene_lights,
        "alpha": data.alpha,
        "clamp_squared": data.clamp_squared,
        "large_vpl_luminance": data.large_vpl_luminance,
        "exposure": data.exposure,
        "exposure_compensation": data.exposure_compensation,
        "tone_map": data.tone_map,
        "largest_triangle": data.largest_triangle,
        "environment_cells": data.environment_cells,
        "environment_scale": data.environment_scale,
        "environment_turn": data.environment_turn,
        "environment_share": data.environment_share,
    })
}
