//! Scenes that were opened before, kept between runs in the user's own folder.

use std::fs;
use std::path::{Path, PathBuf};

use directories::ProjectDirs;
use log::debug;
use serde::{Deserialize, Serialize};

/// So many are kept.
const MOST: usize = 8;

/// What windows remember from run to run. Where it cannot be read or written, nothing is remembered.
#[derive(Debug, Default)]
pub struct Recent {
    place: Option<PathBuf>,
    kept: Kept,
}

/// The file.
#[derive(Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
struct Kept {
    /// Whole paths of scenes, the last one first.
    scenes: Vec<PathBuf>,
}

impl Recent {
    /// What the user's folder has.
    pub fn of_user() -> Self {
        let folders = ProjectDirs::from("", "", env!("CARGO_PKG_NAME"));
        let folder = folders.map(|folders| folders.state_dir().unwrap_or(folders.data_local_dir()).to_owned());
        folder.map_or_else(Self::default, |folder| Self::at(folder.join("window.toml")))
    }

    fn at(place: PathBuf) -> Self {
        let kept = fs::read_to_string(&place).ok().and_then(|text| toml::from_str(&text).ok()).unwrap_or_default();
        Self { place: Some(place), kept }
    }

    /// No window has been opened before.
    pub fn is_first_start(&self) -> bool {
        self.place.as_ref().is_none_or(|place| !place.exists())
    }

    /// Scenes that were opened, the last one first.
    pub fn scenes(&self) -> &[PathBuf] {
        &self.kept.scenes
    }

    /// Remembers that a window was opened, and with which scene; `None` is the built-in one.
    pub fn note(&mut self, scene: Option<&Path>) {
        if let Some(scene) = scene {
            let scene = fs::canonicalize(scene).unwrap_or_else(|_| scene.to_owned());
            self.kept.scenes.retain(|kept| *kept != scene);
            self.kept.scenes.insert(0, scene);
            self.kept.scenes.truncate(MOST);
        }
        if let Err(error) = self.write() {
            debug!("recent scenes are not kept: {error}");
        }
    }

    /// Appears whole or not at all, as several windows may write it.
    fn write(&self) -> std::io::Result<()> {
        let Some(place) = &self.place else { return Ok(()) };
        let folder = place.parent().unwrap_or(Path::new("."));
        fs::create_dir_all(folder)?;
        let text = toml::to_string(&self.kept).map_err(std::io::Error::other)?;
        let file = tempfile::NamedTempFile::new_in(folder)?;
        fs::write(file.path(), text)?;
        file.persist(place)?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_scene_is_the_first_and_none_is_there_twice() {
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join("state/window.toml");
        let mut recent = Recent::at(place.clone());
        assert!(recent.is_first_start() && recent.scenes().is_empty());
        recent.note(None);
        assert!(!Recent::at(place.clone()).is_first_start());
        for i in 0..10 {
            recent.note(Some(Path::new(&format!("/scenes/{i}.glb"))));
        }
        recent.note(Some(Path::new("/scenes/7.glb")));
        let again = Recent::at(place.clone());
        assert_eq!(again.kept, recent.kept);
        assert_eq!(again.scenes().len(), MOST);
        assert_eq!(again.scenes()[..2], [PathBuf::from("/scenes/7.glb"), PathBuf::from("/scenes/9.glb")]);
        fs::write(&place, "scenes = 3").unwrap();
        assert!(Recent::at(place).scenes().is_empty());
    }
}
