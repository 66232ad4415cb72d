//! The files that a run will leave.

use std::collections::VecDeque;

use crate::Result;
use crate::files::{OutputFile, sequence};
use crate::settings::Settings;

/// The files that the settings ask for.
#[derive(Debug, Default)]
pub(super) struct Outputs {
    /// The picture of the last frame.
    pub picture: Option<OutputFile>,
    /// Or those of all measured frames, in their order.
    pub sequence: VecDeque<OutputFile>,
    /// The timings.
    pub timings: Vec<OutputFile>,
}

impl Outputs {
    /// Checks every output before any work is done.
    ///
    /// # Errors
    /// Those of [`OutputFile::create`].
    pub(super) fn prepare(settings: &Settings) -> Result<Self> {
        let output = &settings.output;
        let each = output.picture.iter().filter(|_| output.is_sequence());
        let each = each.flat_map(|path| (0..settings.run.frames).map(move |frame| sequence::path_of(path, frame)));
        let sequence = each.map(|path| OutputFile::create(&path)).collect::<Result<_>>()?;
        let one = output.picture.as_deref().filter(|_| !output.is_sequence());
        let picture = one.map(OutputFile::create).transpose()?;
        let timings = output.timings.iter().map(|path| OutputFile::create(path)).collect::<Result<_>>()?;
        Ok(Self { picture, sequence, timings })
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

    #[test]
    fn a_sequence_has_a_file_for_each_frame() {
        let folder = tempfile::tempdir().unwrap();
        let settings = Settings::default().changed(|s| {
            s.output.picture = Some(folder.path().join("a-{frame}.exr"));
            s.run.frames = 3;
        });
        let outputs = Outputs::prepare(&settings).unwrap();
        let files: Vec<_> = outputs.sequence.iter().map(|file| file.path().file_name().unwrap()).collect();
        assert!(outputs.picture.is_none() && files == ["a-0000.exr", "a-0001.exr", "a-0002.exr"], "{files:?}");
        let last = folder.path().join("a-0002.exr");
        std::fs::create_dir(&last).unwrap();
        let error = Outputs::prepare(&settings).unwrap_err();
        assert!(error.to_string().contains("a-0002.exr"), "{error}");
    }
}
