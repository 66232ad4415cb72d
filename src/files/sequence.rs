//! Names of the pictures of a sequence.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::{Error, Result};

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

/// The pictures of a sequence that are there, by their numbers, with any number of digits.
///
/// # Errors
/// [`Error::Usage`] unless the place of the number is once in the name of the file; [`Error::File`] when the folder cannot be
/// read, no picture is there, or two have the same number.
pub fn frames_of(path: &Path) -> Result<BTreeMap<u32, PathBuf>> {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let parts: Vec<&str> = name.split(FRAME_PLACE).collect();
    let &[before, after] = &parts[..] else {
        let path = path.display();
        return Err(Error::Usage(format!("{path} must have {FRAME_PLACE} once in its name, in place of the number")));
    };
    let entries = std::fs::read_dir(folder.unwrap_or(Path::new(".")));
    let entries = entries.map_err(|e| Error::file(path, format_args!("its folder cannot be read: {e}")))?;
    let mut frames = BTreeMap::new();
    for entry in entries {
        let entry = entry.map_err(|e| Error::file(path, format_args!("its folder cannot be read: {e}")))?;
        let file = entry.file_name().to_string_lossy().into_owned();
        let digits = file.strip_prefix(before).and_then(|rest| rest.strip_suffix(after));
        let digits = digits.filter(|digits| digits.bytes().all(|byte| byte.is_ascii_digit()));
        let Some(frame) = digits.and_then(|digits| digits.parse().ok()) else { continue };
        if let Some(other) = frames.insert(frame, path.with_file_name(&file)) {
            let other = other.file_name().unwrap_or_default().to_string_lossy();
            return Err(Error::file(path, format_args!("{other} and {file} are both the frame {frame}")));
        }
    }
    if frames.is_empty() {
        let example = path_of(path, 0);
        return Err(Error::file(path, format_args!("there is no picture of this name, such as {}", example.display())));
    }
    Ok(frames)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_found_by_their_numbers() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let write = |name: &str| std::fs::write(path(name), "").unwrap();
        let complaint = |name: &str| frames_of(&path(name)).unwrap_err().to_string();
        assert!(complaint("a-{frame}.exr").contains("there is no picture of this name, such as"));
        ["a-0000.exr", "a-7.exr", "a-12345.exr", "a-.exr", "a-x.exr", "a-3.png", "a--1.exr"]
            .into_iter()
            .for_each(write);
        let expected = [(0, "a-0000.exr"), (7, "a-7.exr"), (12345, "a-12345.exr")];
        let expected = expected.map(|(frame, name)| (frame, path(name)));
        assert_eq!(frames_of(&path("a-{frame}.exr")).unwrap(), BTreeMap::from(expected));
        write("a-0007.exr");
        assert!(complaint("a-{frame}.exr").ends_with("are both the frame 7"));
        assert!(complaint("a.exr").ends_with("must have {frame} once in its name, in place of the number"));
        assert!(complaint("{frame}-{frame}.exr").contains("once in its name"));
        assert!(complaint("none/a-{frame}.exr").contains("its folder cannot be read"));
    }

    #[test]
    fn frames_have_names_in_order() {
        let path = Path::new("a.b/x-{frame}.exr");
        assert!(is_sequence(path) && !is_sequence(Path::new("a/x-frame.exr")));
        assert_eq!(path_of(path, 7), Path::new("a.b/x-0007.exr"));
        assert_eq!(path_of(path, 12345), Path::new("a.b/x-12345.exr"));
    }
}
