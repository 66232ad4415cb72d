//! The folder of an error report.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use crate::cli::REPORT_FILES;
use crate::files::OutputFile;
use crate::report::ErrorReport;
use crate::{Error, Result};

/// A folder known to take the files of a report. One that was made for it goes away again when it stays empty.
#[derive(Debug)]
pub struct ReportFolder {
    path: PathBuf,
    made: bool,
    files: Vec<OutputFile>,
}

impl ReportFolder {
    /// Makes the folder where it is missing, and checks that the files can be written.
    ///
    /// # Errors
    /// [`Error::File`] when it cannot be made, is no folder, or a file cannot be written.
    pub fn prepare(path: &Path) -> Result<Self> {
        let made = match fs::create_dir(path) {
            Ok(()) => true,
            Err(error) if error.kind() == ErrorKind::AlreadyExists && path.is_dir() => false,
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {
                return Err(Error::file(path, "the report needs a folder, and this is none"));
            }
            Err(error) if error.kind() == ErrorKind::NotFound => {
                return Err(Error::file(path, "the folder cannot be made: there is no folder above it"));
            }
            Err(error) => return Err(Error::file(path, format!("the folder cannot be made: {error}"))),
        };
        let mut folder = Self { path: path.to_path_buf(), made, files: Vec::new() };
        for name in REPORT_FILES {
            folder.files.push(OutputFile::create(&path.join(name))?);
        }
        Ok(folder)
    }

    /// Writes the three files, each whole.
    ///
    /// # Errors
    /// [`Error::File`] when one cannot be written, [`Error::Failure`] when the report cannot be expressed.
    pub fn commit(mut self, report: &ErrorReport) -> Result<()> {
        let texts = [report.to_json()?, report.to_markdown().into_bytes(), report.to_html()?.into_bytes()];
        for (file, text) in std::mem::take(&mut self.files).into_iter().zip(&texts) {
            file.commit(text)?;
        }
        Ok(())
    }
}

impl Drop for ReportFolder {
    fn drop(&mut self) {
        // Fails, as it should, once there is a file in it.
        if self.made
            && let Err(error) = fs::remove_dir(&self.path)
        {
            log::debug!("{} stays: {error}", self.path.display());
        }
    }
}
