//! One error type for the whole program, and the exit code each kind maps to.

use std::path::{Path, PathBuf};

use ash::vk;

/// Everything that can go wrong, each variant with the exit code that docs/options.md documents.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Something failed that is neither the user's options nor the device: exit code 1.
    #[error("{0}")]
    Failure(String),
    /// A file could not be read, understood or written: exit code 1.
    #[error("{}: {reason}", shortened(path.display().to_string()))]
    File {
        /// The file in question.
        path: PathBuf,
        /// What is wrong with it, as a clause that reads after "path: ".
        reason: String,
    },
    /// The command line or the settings file asks for something impossible: exit code 2.
    #[error("{0}")]
    Usage(String),
    /// A comparison exceeded the threshold the user gave: exit code 3.
    #[error("{0}")]
    Threshold(String),
    /// The validation layers reported messages: exit code 4.
    #[error("the validation layers reported {count} message(s), the first: {first}")]
    Validation {
        /// How many messages arrived.
        count: usize,
        /// The first one, whole.
        first: String,
    },
    /// The device was lost: exit code 5.
    #[error("the Vulkan device was lost {place}")]
    DeviceLost {
        /// In which passes, or at which call outside a frame, as a clause that reads after "lost".
        place: String,
    },
    /// The user stopped the run; what was finished has been written: exit code 130.
    #[error("{0}")]
    Interrupted(String),
    /// No Vulkan loader, driver or suitable device: exit code 77.
    #[error("{0}")]
    NoDevice(String),
    /// A Vulkan call failed in a way the program cannot mend: exit code 1.
    #[error("{what} failed: {result}")]
    Vulkan {
        /// The call or the object concerned.
        what: String,
        /// What Vulkan answered.
        result: vk::Result,
    },
    /// Device memory could not be had: exit code 1.
    #[error("no memory for {name}: {reason}")]
    Memory {
        /// The resource that was to be allocated.
        name: String,
        /// What the allocator answered.
        reason: String,
    },
}

/// The exit code of an interrupted run, as shells have it: 128 and the number of the signal.
pub const INTERRUPTED_EXIT_CODE: u8 = 130;

/// Shorthand used throughout the crate.
pub type Result<T> = std::result::Result<T, Error>;

/// The most characters of a sentence that quotes a file: names in a file may be of any length.
const LONGEST_SENTENCE: usize = 600;

/// A sentence about a file, its middle left out where it is too long to be read.
#[must_use]
pub fn shortened(sentence: String) -> String {
    let length = sentence.chars().count();
    if length <= LONGEST_SENTENCE {
        return sentence;
    }
    let half = LONGEST_SENTENCE / 2;
    let (start, end) = (sentence.chars().take(half), sentence.chars().skip(length - half));
    start.chain(" ... ".chars()).chain(end).collect()
}

impl Error {
    /// A [`Error::File`] from anything that can be shown.
    pub fn file(path: impl AsRef<Path>, reason: impl std::fmt::Display) -> Self {
        Self::File { path: path.as_ref().to_path_buf(), reason: shortened(reason.to_string()) }
    }

    /// The process exit code for this error.
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Usage(_) => 2,
            Self::Threshold(_) => 3,
            Self::Validation { .. } => 4,
            Self::DeviceLost { .. } => 5,
            Self::NoDevice(_) => 77,
            Self::Interrupted(_) => INTERRUPTED_EXIT_CODE,
            Self::Failure(_) | Self::File { .. } | Self::Vulkan { .. } | Self::Memory { .. } => 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_too_long_loses_its_middle() {
        let long = Error::file("a", format!("begins {} ends", "\u{e9}".repeat(50_000))).to_string();
        assert!(long.starts_with("a: begins ") && long.contains(" ... ") && long.ends_with(" ends"), "{long}");
        assert_eq!(long.chars().count(), 3 + LONGEST_SENTENCE + 5);
        assert_eq!(shortened("short".to_owned()), "short");
        assert!(Error::file("x/".repeat(5000), "no").to_string().len() < 700);
    }
}
