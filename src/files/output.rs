//! Output files that appear whole or not at all.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::{Error, Result};

/// The formats this program writes, known by their extensions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    /// OpenEXR, linear radiance.
    Exr,
    /// PNG, exposed and tone-mapped.
    Png,
    /// Timings with statistics.
    Json,
    /// Timings of every frame.
    Csv,
    /// A report to look at.
    Html,
    /// A report as text.
    Markdown,
}

impl FileKind {
    const ALL: [Self; 6] = [Self::Exr, Self::Png, Self::Json, Self::Csv, Self::Html, Self::Markdown];

    /// The format that the extension of `path` names, in any case.
    #[must_use]
    pub fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?;
        Self::ALL.into_iter().find(|kind| extension.eq_ignore_ascii_case(kind.extension()))
    }

    /// The extension, without the dot.
    #[must_use]
    pub fn extension(self) -> &'static str {
        match self {
            Self::Exr => "exr",
            Self::Png => "png",
            Self::Json => "json",
            Self::Csv => "csv",
            Self::Html => "html",
            Self::Markdown => "md",
        }
    }
}

/// A file that will be written when the run is over, known now to be writable.
///
/// Nothing of that name appears or changes before [`OutputFile::commit`], and nothing is left behind when
/// there is none, not even when the process is killed.
#[derive(Debug)]
pub struct OutputFile {
    path: PathBuf,
    kind: FileKind,
}

impl OutputFile {
    /// Checks that `path` has a known extension and can be written.
    ///
    /// # Errors
    /// [`Error::Usage`] for the extension, [`Error::File`] for the rest.
    pub fn create(path: &Path) -> Result<Self> {
        let kind = FileKind::of(path).ok_or_else(|| {
            Error::Usage(format!("{} must end in .exr, .png, .json, .csv, .html or .md", path.display()))
        })?;
        // A link is followed, so that the rename replaces what it points to.
        let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
        match fs::metadata(&target) {
            Ok(existing) => check_existing(path, &target, &existing)?,
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            // Such as a name that is too long, which a temporary file would not show.
            Err(error) if error.kind() != io::ErrorKind::NotADirectory => return Err(unwritable(path, &error)),
            Err(_) => {}
        }
        check_folder(path, folder(&target))?;
        drop(temporary(&target).map_err(|error| unwritable(path, &error))?);
        Ok(Self { path: target, kind })
    }

    /// The format, from the extension.
    #[must_use]
    pub fn kind(&self) -> FileKind {
        self.kind
    }

    /// Where the file will be.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes the file under a temporary name and renames it.
    ///
    /// # Errors
    /// [`Error::File`] when that fails; then an earlier file of that name is as it was.
    pub fn commit(self, bytes: &[u8]) -> Result<()> {
        let write = || -> io::Result<()> {
            let mut file = temporary(&self.path)?;
            // The file itself: its wrapper tells its name in errors.
            file.as_file_mut().write_all(bytes)?;
            file.persist(&self.path).map_err(|error| error.error)?;
            Ok(())
        };
        write().map_err(|error| unwritable(&self.path, &error))
    }
}

fn unwritable(path: &Path, error: &io::Error) -> Error {
    // What went wrong with a temporary file, without its name.
    let cause = error.get_ref().and_then(|inner| inner.source());
    let reason = cause.map_or_else(|| error.to_string(), ToString::to_string);
    Error::file(path, format!("cannot be written: {reason}"))
}

fn check_existing(path: &Path, target: &Path, existing: &fs::Metadata) -> Result<()> {
    if existing.is_dir() {
        return Err(Error::file(path, "cannot be written: it is a folder"));
    }
    if !existing.is_file() {
        return Err(Error::file(path, "cannot be written: it is not a regular file"));
    }
    if existing.permissions().readonly() {
        return Err(Error::file(path, "cannot be written: the file exists and is read-only"));
    }
    // What forbids it besides the permission bits, such as an attribute; nothing is written.
    fs::OpenOptions::new().write(true).open(target).map(drop).map_err(|error| unwritable(path, &error))
}

fn check_folder(path: &Path, folder: &Path) -> Result<()> {
    match fs::metadata(folder) {
        Ok(found) if found.is_dir() => Ok(()),
        Ok(_) => Err(Error::file(path, format!("cannot be written: {} is not a folder", folder.display()))),
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            Err(Error::file(path, format!("cannot be written: there is no folder {}", folder.display())))
        }
        Err(error) => Err(unwritable(path, &error)),
    }
}

fn folder(path: &Path) -> &Path {
    path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// A temporary file beside `path`, with the permissions any new file gets.
fn temporary(path: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".gridlight-").suffix(".tmp");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder(path))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    fn complaint(path: &Path) -> String {
        let error = OutputFile::create(path).unwrap_err();
        assert!(error.to_string().contains(path.to_str().unwrap()), "{error}");
        error.to_string()
    }

    #[test]
    fn kinds_by_extension() {
        assert_eq!(FileKind::of(Path::new("a/b.EXR")), Some(FileKind::Exr));
        assert_eq!(FileKind::of(Path::new("b.csv")), Some(FileKind::Csv));
        assert_eq!(FileKind::of(Path::new("exr")), None);
        assert_eq!(FileKind::of(Path::new("b.exr.gz")), None);
    }

    #[test]
    fn commit_replaces_and_leaves_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.json");
        fs::write(&path, "old").unwrap();
        let file = OutputFile::create(&path).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(file.kind(), FileKind::Json);
        file.commit(b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(names(folder.path()), ["a.json"]);
    }

    #[test]
    fn without_commit_nothing_changes() {
        let folder = tempfile::tempdir().unwrap();
        let (old, new) = (folder.path().join("old.png"), folder.path().join("new.png"));
        fs::write(&old, "old").unwrap();
        drop(OutputFile::create(&old).unwrap());
        drop(OutputFile::create(&new).unwrap());
        assert_eq!(fs::read(&old).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["old.png"]);
    }

    #[cfg(unix)]
    #[test]
    fn permissions_are_those_of_any_new_file() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (plain, written) = (folder.path().join("plain"), folder.path().join("a.png"));
        fs::write(&plain, "").unwrap();
        OutputFile::create(&written).unwrap().commit(b"x").unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&plain), mode(&written));
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed() {
        let folder = tempfile::tempdir().unwrap();
        let (target, link) = (folder.path().join("target.png"), folder.path().join("link.png"));
        fs::write(&target, "old").unwrap();
        std::os::unix::fs::symlink(&target, &link).unwrap();
        OutputFile::create(&link).unwrap().commit(b"new").unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&target).unwrap(), b"new");
    }

    #[test]
    fn what_cannot_be_written_is_found_first() {
        let folder = tempfile::tempdir().unwrap();
        let inside = |name: &str| folder.path().join(name);
        fs::create_dir(inside("d.png")).unwrap();
        assert!(complaint(&inside("d.png")).ends_with("it is a folder"));
        assert!(complaint(&inside("no/a.png")).contains("there is no folder"));
        fs::write(inside("file"), "").unwrap();
        let sentence = complaint(&inside("file/a.png"));
        assert!(sentence.ends_with("is not a folder"), "{sentence}");
        assert!(complaint(&inside("a.jpg")).contains("must end in"));
        let kept = inside("kept.png");
        fs::write(&kept, "").unwrap();
        let mut permissions = fs::metadata(&kept).unwrap().permissions();
        permissions.set_readonly(true);
        fs::set_permissions(&kept, permissions).unwrap();
        assert!(complaint(&kept).ends_with("read-only"));
    }
}
