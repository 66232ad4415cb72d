//! What each shader module asks for: bindings, push constants, specialization constants, workgroup size. Reflected from
//! the SPIR-V when shaders are compiled, committed as `shaders/spirv/interfaces.json` and embedded.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use serde::{Deserialize, Serialize};

use super::variants::Stage;

/// Interfaces by shader variant, as in `gbuffer/draw_scene.frag`.
pub type Table = BTreeMap<String, Interface>;

/// The interface of one module.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Interface {
    /// Pipeline stage.
    pub stage: Stage,
    /// Invocations of a workgroup along each axis; 1 in other stages than compute.
    pub workgroup_size: [u32; 3],
    /// Bytes of shared memory of a workgroup.
    pub shared_bytes: u32,
    /// Bytes of push constants.
    pub push_bytes: u32,
    /// Identifiers of the specialization constants by name.
    pub constants: BTreeMap<String, u32>,
    /// Bindings by set and number.
    pub bindings: Vec<Binding>,
}

/// One binding of a module.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Binding {
    /// As the shader's code says it: the variable, or the only member of a block without an instance name.
    pub name: String,
    /// Descriptor set.
    pub set: u32,
    /// Number in the set.
    pub binding: u32,
    /// What is bound.
    pub kind: BindingKind,
    /// Which images; `None` for what is no image.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dimension: Option<ImageDimension>,
    /// Declared `readonly`.
    pub readonly: bool,
    /// Declared `writeonly`.
    pub writeonly: bool,
    /// Some instruction reads it.
    pub reads: bool,
    /// Some instruction writes it.
    pub writes: bool,
}

/// Kinds of bindings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BindingKind {
    /// `uniform` block.
    UniformBuffer,
    /// `buffer` block.
    StorageBuffer,
    /// Image without a sampler, `texelFetch`.
    SampledImage,
    /// `imageLoad`, `imageStore`.
    StorageImage,
    /// Image and sampler in one.
    CombinedImageSampler,
    /// Of ray queries.
    AccelerationStructure,
}

/// Kinds of images by the coordinates that shaders give.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ImageDimension {
    /// `image2D`, `texture2D`.
    #[serde(rename = "2d")]
    D2,
    /// `image2DArray`, `texture2DArray`.
    #[serde(rename = "2d-array")]
    D2Array,
    /// `image3D`, `texture3D`.
    #[serde(rename = "3d")]
    D3,
}

impl Interface {
    /// The binding of this name.
    #[must_use]
    pub fn binding(&self, name: &str) -> Option<&Binding> {
        self.bindings.iter().find(|binding| binding.name == name)
    }
}

/// The committed interfaces. Empty when the file is damaged, which a test would notice.
pub fn embedded() -> &'static Table {
    static TABLE: OnceLock<Table> = OnceLock::new();
    let text = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/shaders/spirv/interfaces.json"));
    TABLE.get_or_init(|| serde_json::from_str(text).unwrap_or_default())
}

/// The text of `interfaces.json`: one line for each module and each binding, so that changes are seen.
#[must_use]
pub fn to_text(table: &Table) -> String {
    let line = |value: &dyn Fn() -> serde_json::Result<String>| value().unwrap_or_default();
    let modules: Vec<String> = table
        .iter()
        .map(|(name, interface)| {
            let bindings: Vec<String> =
                interface.bindings.iter().map(|b| format!("\n    {}", line(&|| serde_json::to_string(b)))).collect();
            let rest = line(&|| serde_json::to_string(&Interface { bindings: Vec::new(), ..interface.clone() }));
            let head = rest.trim_end_matches("[]}");
            format!("{}: {head}[{}]}}", line(&|| serde_json::to_string(name)), bindings.join(","))
        })
        .collect();
    format!("{{\n{}\n}}\n", modules.join(",\n"))
}
