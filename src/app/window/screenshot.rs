//! Pictures of what the window shows, with the settings that made them beside.

use std::path::{Path, PathBuf};

use crate::renderer::Renderer;
use crate::report::FileKind;
use crate::report::files::OutputFile;
use crate::report::timings::Program;
use crate::settings::{self, Settings};
use crate::{Error, Result};

/// Writes the picture of the last frame; gives what was written, in words. Waits for the GPU.
///
/// # Errors
/// When a file cannot be written or the device is lost.
pub fn save(renderer: &Renderer, settings: &Settings, name: Option<&Path>) -> Result<String> {
    let Program { name: program, version, commit } = Program::this();
    let note = format!("{program} {version} ({commit}), {}", settings::name(&settings.technique));
    let picture = renderer.read_picture(note)?;
    let write = |path: &Path| OutputFile::create(path)?.commit_picture(&picture);
    if let Some(path) = name.filter(|path| FileKind::of(path).is_some()) {
        write(path)?;
        return Ok(path.display().to_string());
    }
    let base = name.map_or_else(free_name, |name| Ok(name.to_path_buf()))?;
    for extension in ["exr", "png"] {
        write(&with_extension(&base, extension))?;
    }
    save_settings(settings, &with_extension(&base, "toml"))?;
    Ok(format!("{}.exr, .png and .toml", base.display()))
}

/// Writes the settings as a file that `--settings` reads.
///
/// # Errors
/// When the file cannot be written.
pub fn save_settings(settings: &Settings, path: &Path) -> Result<()> {
    let text = settings.to_toml()?;
    std::fs::write(path, text).map_err(|error| Error::file(path, format!("cannot be written: {error}")))
}

fn with_extension(base: &Path, extension: &str) -> PathBuf {
    let mut name = base.as_os_str().to_owned();
    name.push(".");
    name.push(extension);
    name.into()
}

/// The first of gridlight-001, gridlight-002, ... that no file here has.
fn free_name() -> Result<PathBuf> {
    let taken = |base: &Path| ["exr", "png", "toml"].iter().any(|e| with_extension(base, e).exists());
    (1..1000)
        .map(|number| PathBuf::from(format!("gridlight-{number:03}")))
        .find(|base| !taken(base))
        .ok_or_else(|| Error::Failure("there are 999 screenshots here already: move some away".to_owned()))
}
