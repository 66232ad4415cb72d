//! The files that a run will leave.

use crate::Result;
use crate::files::OutputFile;
use crate::settings::Settings;

/// The files that the settings ask for.
#[derive(Debug, Default)]
pub(super) struct Outputs {
    /// The picture.
    pub picture: Option<OutputFile>,
    /// The timings.
    pub timings: Vec<OutputFile>,
}

impl Outputs {
    /// Checks every output before any work is done.
    ///
    /// # Errors
    /// Those of [`OutputFile::create`].
    pub(super) fn prepare(settings: &Settings) -> Result<Self> {
        let picture = settings.output.picture.as_deref().map(OutputFile::create).transpose()?;
        let timings = settings.output.timings.iter().map(|path| OutputFile::create(path)).collect::<Result<_>>()?;
        Ok(Self { picture, timings })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_outputs_are_prepared() {
        let folder = tempfile::tempdir().unwrap();
        let settings = Settings::default().changed(|s| {
            s.output.picture = Some(folder.path().join("a.exr"));
            s.output.timings = vec![folder.path().join("no/a.csv")];
        });
        assert_eq!(Outputs::prepare(&settings).unwrap_err().exit_code(), 1);
        let outputs = Outputs::prepare(&settings.changed(|s| s.output.timings.clear())).unwrap();
        assert!(outputs.picture.is_some() && outputs.timings.is_empty());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
