//! GLSL to SPIR-V with shaderc (feature `shader-compiler`).

use std::collections::BTreeMap;
use std::path::Path;

use super::interface::{Table, to_text};
use super::reflect::reflect;
use super::source::{ShaderSource, all_sources};
use super::spirv::{self, Spirv};
use super::variants::Stage;
use crate::error::{Error, Result};

/// Compiles one shader for Vulkan 1.3, optimised for speed, names kept for tools.
///
/// # Errors
/// With the compiler's message when the source does not compile.
pub fn compile(compiler: &shaderc::Compiler, source: &ShaderSource) -> Result<Vec<u8>> {
    let failure = |e: &dyn std::fmt::Display| Error::Failure(format!("{}: {e}", source.name));
    let mut options = shaderc::CompileOptions::new().map_err(|e| failure(&e))?;
    options.set_target_env(shaderc::TargetEnv::Vulkan, shaderc::EnvVersion::Vulkan1_3 as u32);
    options.set_optimization_level(shaderc::OptimizationLevel::Performance);
    options.set_generate_debug_info();
    options.set_warnings_as_errors();
    let kind = match source.stage {
        Stage::Vertex => shaderc::ShaderKind::Vertex,
        Stage::Fragment => shaderc::ShaderKind::Fragment,
        Stage::Compute => shaderc::ShaderKind::Compute,
    };
    let artifact = compiler
        .compile_into_spirv(&source.text, kind, &source.name, "main", Some(&options))
        .map_err(|e| Error::Failure(source.relocate(&e.to_string())))?;
    Ok(artifact.as_binary_u8().to_vec())
}

/// Compiles every stale shader under `shaders/` into `shaders/spirv/` and rewrites its manifest of source hashes.
/// Returns the names compiled.
///
/// # Errors
/// When a source does not compile or a file cannot be written; files compiled before that stay.
pub fn compile_all(shaders_dir: &Path) -> Result<Vec<String>> {
    let out_dir = shaders_dir.join("spirv");
    let manifest_path = out_dir.join("manifest.json");
    std::fs::create_dir_all(&out_dir).map_err(|e| Error::file(&out_dir, e))?;
    let old: BTreeMap<String, String> =
        std::fs::read_to_string(&manifest_path).ok().and_then(|s| serde_json::from_str(&s).ok()).unwrap_or_default();
    let compiler = shaderc::Compiler::new().map_err(|e| Error::Failure(format!("shaderc: {e}")))?;
    let mut manifest = BTreeMap::new();
    let mut compiled = Vec::new();
    for source in all_sources(shaders_dir)? {
        let path = out_dir.join(format!("{}.spv", source.name.replace('/', "__")));
        let hash = source.hash();
        if old.get(&source.name) != Some(&hash) || !path.exists() {
            std::fs::write(&path, compile(&compiler, &source)?).map_err(|e| Error::file(&path, e))?;
            compiled.push(source.name.clone());
        }
        manifest.insert(source.name, hash);
    }
    remove_orphans(&out_dir, &manifest)?;
    write_interfaces(&out_dir, manifest.keys())?;
    let text = serde_json::to_string_pretty(&manifest).map_err(|e| Error::file(&manifest_path, e))?;
    std::fs::write(&manifest_path, text + "\n").map_err(|e| Error::file(&manifest_path, e))?;
    Ok(compiled)
}

/// Shaders to put in use in place of others.
pub struct Reload(Vec<(String, Option<Spirv>)>);

impl Reload {
    /// Their names.
    #[must_use]
    pub fn names(&self) -> Vec<&str> {
        self.0.iter().map(|(name, _)| name.as_str()).collect()
    }

    /// Puts them in use; gives those that were.
    pub fn put_in_use(self) -> Self {
        let exchange = |(name, spirv): (String, Option<Spirv>)| {
            let before = spirv::replace(&name, spirv);
            (name, before)
        };
        Self(self.0.into_iter().map(exchange).collect())
    }
}

/// Compiles the shaders under `shaders/` whose sources are not those in use. With an error there are none.
///
/// # Errors
/// With file and line when a source does not compile.
pub fn reload(shaders_dir: &Path) -> Result<Reload> {
    let compiler = shaderc::Compiler::new().map_err(|e| Error::Failure(format!("shaderc: {e}")))?;
    let mut fresh = Vec::new();
    for source in all_sources(shaders_dir)? {
        let hash = source.hash();
        if spirv::hash_in_use(&source.name).as_ref() != Some(&hash) {
            let words = spirv::to_words(&compile(&compiler, &source)?);
            let interface = reflect(&words).map_err(|e| Error::Failure(format!("{}: {e}", source.name)))?;
            let spirv = Spirv::new(hash, words, interface);
            fresh.push((source.name, Some(spirv)));
        }
    }
    Ok(Reload(fresh))
}

/// Writes the table of what every module asks for.
fn write_interfaces<'a>(out_dir: &Path, names: impl Iterator<Item = &'a String>) -> Result<()> {
    let mut table = Table::new();
    for name in names {
        let path = out_dir.join(format!("{}.spv", name.replace('/', "__")));
        let words = spirv::to_words(&std::fs::read(&path).map_err(|e| Error::file(&path, e))?);
        table.insert(name.clone(), reflect(&words).map_err(|e| Error::file(&path, e))?);
    }
    let path = out_dir.join("interfaces.json");
    std::fs::write(&path, to_text(&table)).map_err(|e| Error::file(&path, e))
}

fn remove_orphans(out_dir: &Path, manifest: &BTreeMap<String, String>) -> Result<()> {
    for entry in std::fs::read_dir(out_dir).map_err(|e| Error::file(out_dir, e))?.flatten() {
        let path = entry.path();
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().replace("__", "/");
        if path.extension().is_some_and(|e| e == "spv") && !manifest.contains_key(&stem) {
            std::fs::remove_file(&path).map_err(|e| Error::file(&path, e))?;
        }
    }
    Ok(())
}
