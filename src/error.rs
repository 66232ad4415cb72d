//! One error type for the whole program, and the exit code each kind maps to.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use ash::vk;

/// Everything that can go wrong, each variant with the exit code that docs/options.md documents.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Something failed that is neither the user's options nor the device: exit code 1.
    #[error("{}", short_words(.0))]
    Failure(String),
    /// A file could not be read, understood or written: exit code 1.
    #[error("{}: {}", shortened(&path.display().to_string()), shortened(reason))]
    File {
        /// The file in question.
        path: PathBuf,
        /// What is wrong with it, as a clause that reads after "path: ".
        reason: String,
    },
    /// The command line or the settings file asks for something impossible: exit code 2.
    #[error("{}", shortened(.0))]
    Usage(String),
    /// A comparison exceeded the threshold the user gave: exit code 3.
    #[error("{}", shortened(.0))]
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
    #[error("{}", shortened(.0))]
    Interrupted(String),
    /// No Vulkan loader, driver or suitable device: exit code 77.
    #[error("{}", shortened(.0))]
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

/// The most characters of a word in a sentence: longer than most paths.
const LONGEST_WORD: usize = 300;
/// The most characters of a sentence. The longest one without a quotation, which lists all views, has about 400.
const LONGEST_SENTENCE: usize = 900;

/// A sentence as people can read it. It may quote names and values of any length, from a file or a command line, which lose
/// their middle; the words around them stay.
#[must_use]
pub fn shortened(sentence: &str) -> String {
    without_middle(&short_words(sentence), LONGEST_SENTENCE).into_owned()
}

/// The same of words alone: what a shader compiler says is many sentences.
fn short_words(sentences: &str) -> String {
    sentences.split_inclusive(char::is_whitespace).map(short_word).collect()
}

/// A value as a sentence can quote it more than once.
#[must_use]
pub fn short_word(value: &str) -> Cow<'_, str> {
    without_middle(value, LONGEST_WORD)
}

/// The ends of a text that has more than `most` characters.
fn without_middle(text: &str, most: usize) -> Cow<'_, str> {
    let length = text.chars().count();
    if length <= most {
        return text.into();
    }
    let half = most / 2;
    let (start, end) = (text.chars().take(half), text.chars().skip(length - half));
    start.chain(" ... ".chars()).chain(end).collect()
}

impl Error {
    /// A [`Error::File`] from anything that can be shown.
    pub fn file(path: impl AsRef<Path>, reason: impl std::fmt::Display) -> Self {
        Self::File { path: path.as_ref().to_path_buf(), reason: reason.to_string() }
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
        assert_eq!(long.chars().count(), "a: begins ends".len() + LONGEST_WORD + " ... ".len());
        let of_many_words = Error::Usage(format!("begins {} ends", "a name ".repeat(2000))).to_string();
        assert!(of_many_words.starts_with("begins a name") && of_many_words.ends_with("name  ends"), "{of_many_words}");
        assert_eq!(of_many_words.chars().count(), LONGEST_SENTENCE + 5);
        assert_eq!(shortened("two  words"), "two  words");
        assert!(Error::file("x/".repeat(5000), "no").to_string().len() < LONGEST_WORD + 20);
    }
}
