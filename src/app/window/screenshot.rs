//! Pictures of what the window shows, with the settings that made them beside.

use std::path::{Path, PathBuf};

use crate::files::FileKind;
use crate::files::OutputFile;
use crate::files::pictures::Picture;
use crate::renderer::Renderer;
use crate::report::timings::Program;
use crate::settings::Settings;
use crate::{Error, Result};

/// Writes the picture of the last frame; gives what was written, in words. `held` is the left side of a split view, which
/// has files of its own unless a single one is named. Waits for the GPU.
///
/// # Errors
/// When a file cannot be written or the device is lost.
pub fn save(
    renderer: &Renderer,
    settings: &Settings,
    held: Option<(&Renderer, Settings)>,
    name: Option<&Path>,
) -> Result<String> {
    if let Some(path) = name.filter(|path| FileKind::of(path).is_some()) {
        OutputFile::create(path)?.commit_picture(&picture(renderer, settings)?)?;
        return Ok(whole(path));
    }
    let base = name.map_or_else(free_name, |name| Ok(name.to_path_buf()))?;
    save_all(renderer, settings, &base)?;
    let mut what = format!("{}.exr, .png and .toml", whole(&base));
    if let Some((renderer, settings)) = held {
        let left = with_end(&base, "-left");
        save_all(renderer, &settings, &left)?;
        what += &format!(", {} of the left side", left.display());
    }
    Ok(what)
}

/// Where a file lies.
fn whole(path: &Path) -> String {
    std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf()).display().to_string()
}

fn picture(renderer: &Renderer, settings: &Settings) -> Result<Picture> {
    renderer.read_picture(Program::this().note(settings))
}

fn save_all(renderer: &Renderer, settings: &Settings, base: &Path) -> Result<()> {
    let picture = picture(renderer, settings)?;
    for extension in [".exr", ".png"] {
        OutputFile::create(&with_end(base, extension))?.commit_picture(&picture)?;
    }
    save_settings(settings, &with_end(base, ".toml"))
}

/// Writes the settings as a file that `--settings` reads.
///
/// # Errors
/// When the file cannot be written.
pub fn save_settings(settings: &Settings, path: &Path) -> Result<()> {
    let text = settings.to_toml()?;
    std::fs::write(path, text).map_err(|error| Error::file(path, format!("cannot be written: {error}")))
}

fn with_end(base: &Path, end: &str) -> PathBuf {
    let mut name = base.as_os_str().to_owned();
    name.push(end);
    name.into()
}

/// The first of gridlight-001, gridlight-002, ... that no file here has.
fn free_name() -> Result<PathBuf> {
    let taken = |base: &Path| [".exr", ".png", ".toml"].iter().any(|end| with_end(base, end).exists());
    (1..1000)
        .map(|number| PathBuf::from(format!("gridlight-{number:03}")))
        .find(|base| !taken(base))
        .ok_or_else(|| Error::Failure("there are already 999 screenshots here: move some away".to_owned()))
}
