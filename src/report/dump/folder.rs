//! The folder of a dump: appears whole, under its name, or not at all.

use std::io;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use super::images::Picture;
use super::manifest::{FileEntry, Manifest};
use crate::dump::Array;
use crate::{Error, Result};

/// A name under which a dump may appear, known to be free and beside which one can write.
#[derive(Debug)]
pub struct DumpTarget {
    path: PathBuf,
}

impl DumpTarget {
    /// Checks that `path` is new or an empty folder, and that its parent can be written.
    ///
    /// # Errors
    /// [`Error::Usage`] for a folder with something in it, [`Error::File`] for the rest.
    pub fn prepare(path: &Path) -> Result<Self> {
        match std::fs::read_dir(path) {
            Ok(mut entries) => {
                if entries.next().is_some() {
                    return Err(Error::Usage(format!(
                        "--dump {}: the folder is not empty; name a new one",
                        path.display()
                    )));
                }
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(error) if error.kind() == io::ErrorKind::NotADirectory => {
                return Err(Error::file(path, "cannot hold a dump: it is not a folder"));
            }
            Err(error) => return Err(Error::file(path, format!("cannot hold a dump: {error}"))),
        }
        let target = Self { path: path.to_path_buf() };
        drop(target.temporary()?);
        Ok(target)
    }

    /// Starts a dump.
    ///
    /// # Errors
    /// [`Error::File`] when no folder can be made beside the target.
    pub fn begin(self) -> Result<DumpFolder> {
        Ok(DumpFolder { temporary: self.temporary()?, target: self.path, files: Vec::new() })
    }

    /// A folder beside the target, with the permissions any new folder gets.
    fn temporary(&self) -> Result<TempDir> {
        let parent = self.path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let mut builder = tempfile::Builder::new();
        builder.prefix(".gridlight-").suffix(".tmp");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            builder.permissions(std::fs::Permissions::from_mode(0o777));
        }
        builder.tempdir_in(parent).map_err(|error| match error.kind() {
            io::ErrorKind::NotFound => {
                Error::file(&self.path, format!("cannot be written: there is no folder {}", parent.display()))
            }
            _ => Error::file(&self.path, format!("cannot be written: {error}")),
        })
    }
}

/// A dump in the making, under a temporary name; gone again unless it is committed.
#[derive(Debug)]
pub struct DumpFolder {
    temporary: TempDir,
    target: PathBuf,
    files: Vec<FileEntry>,
}

impl DumpFolder {
    /// Where the files are for now.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.temporary.path()
    }

    /// What has been added.
    #[must_use]
    pub fn files(&self) -> &[FileEntry] {
        &self.files
    }

    /// Writes an array to the entry's file.
    ///
    /// # Errors
    /// [`Error::File`] when that fails.
    pub fn add_array(&mut self, entry: FileEntry, array: &Array) -> Result<()> {
        self.place(&entry).and_then(|path| array.write(&path)).map_err(|error| self.about_target(error))?;
        self.files.push(entry);
        Ok(())
    }

    /// Writes a picture to the entry's file.
    ///
    /// # Errors
    /// [`Error::File`] when that fails.
    pub fn add_picture(&mut self, entry: FileEntry, picture: &Picture) -> Result<()> {
        self.place(&entry).and_then(|path| picture.write(&path)).map_err(|error| self.about_target(error))?;
        self.files.push(entry);
        Ok(())
    }

    /// Writes what tells of all files.
    ///
    /// # Errors
    /// [`Error::File`] when that fails.
    pub fn add_manifest(&mut self, manifest: &Manifest) -> Result<()> {
        manifest.write(self.path()).map_err(|error| self.about_target(error))
    }

    /// An error under the name that people know: of the temporary folder there will be nothing left to look at.
    fn about_target(&self, error: Error) -> Error {
        match error {
            Error::File { path, reason } => {
                let path = path.strip_prefix(self.path()).map_or_else(|_| path.clone(), |file| self.target.join(file));
                Error::File { path, reason }
            }
            other => other,
        }
    }

    fn place(&self, entry: &FileEntry) -> Result<PathBuf> {
        let path = self.path().join(&entry.file);
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder)
                .map_err(|error| Error::file(folder, format!("cannot be written: {error}")))?;
        }
        Ok(path)
    }

    /// Gives the dump its name.
    ///
    /// # Errors
    /// [`Error::File`] when it has been taken meanwhile.
    pub fn commit(self) -> Result<()> {
        let Self { temporary, target, .. } = self;
        let unwritable = |error: io::Error| Error::file(&target, format!("cannot be written: {error}"));
        // An empty folder of the name makes room; not every system renames over one.
        if target.is_dir() {
            std::fs::remove_dir(&target).map_err(unwritable)?;
        }
        std::fs::rename(temporary.path(), &target).map_err(unwritable)?;
        // It no longer exists under the old name: nothing is left to delete.
        let _ = temporary.keep();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dump_appears_at_the_end_or_not_at_all() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("dump");
        drop(DumpTarget::prepare(&path).unwrap().begin().unwrap());
        assert_eq!(std::fs::read_dir(place.path()).unwrap().count(), 0);
        for _ in 0..2 {
            let folder = DumpTarget::prepare(&path).unwrap().begin().unwrap();
            std::fs::write(folder.path().join("a"), "a").unwrap();
            folder.commit().unwrap();
            assert_eq!(std::fs::read_dir(place.path()).unwrap().count(), 1);
            assert_eq!(std::fs::read(path.join("a")).unwrap(), b"a");
            // What is there is an error, an empty folder is not.
            assert_eq!(DumpTarget::prepare(&path).unwrap_err().exit_code(), 2);
            std::fs::remove_file(path.join("a")).unwrap();
        }
    }

    #[test]
    fn impossible_places() {
        let place = tempfile::tempdir().unwrap();
        let file = place.path().join("file");
        std::fs::write(&file, "").unwrap();
        for (path, part) in [
            (file.clone(), "it is not a folder"),
            (file.join("inside"), "cannot hold a dump"),
            (place.path().join("no/dump"), "there is no folder"),
        ] {
            let error = DumpTarget::prepare(&path).unwrap_err();
            assert_eq!(error.exit_code(), 1);
            assert!(error.to_string().contains(part), "{error}");
        }
    }
}
