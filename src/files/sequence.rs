//! Names of the pictures of a sequence.

use std::path::{Path, PathBuf};

/// Where the number of the frame goes in the name of a picture.
pub const FRAME_PLACE: &str = "{frame}";

/// Whether a path has a place for the number of the frame.
#[must_use]
pub fn is_sequence(path: &Path) -> bool {
    path.to_string_lossy().contains(FRAME_PLACE)
}

/// The picture of a frame: four digits or more, so that files sorted by name are in order.
#[must_use]
pub fn path_of(path: &Path, frame: u32) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(name.replace(FRAME_PLACE, &format!("{frame:04}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_have_names_in_order() {
        let path = Path::new("a.b/x-{frame}.exr");
        assert!(is_sequence(path) && !is_sequence(Path::new("a/x-frame.exr")));
        assert_eq!(path_of(path, 7), Path::new("a.b/x-0007.exr"));
        assert_eq!(path_of(path, 12345), Path::new("a.b/x-12345.exr"));
    }
}
