//! Decoders of other people's files: what they fail at is an error, never the end of the program.

use std::cell::Cell;
use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};

use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};

use super::mistaken;

/// No compression that is read makes data more than so many times smaller, but for that of WebP: deflate comes to 1032,
/// a progressive JPEG of one colour to 1228.
const SMALLEST_PART: u64 = 2048;
/// The largest width and height of an image.
pub const MAX_IMAGE_EDGE: u32 = 16_384;
/// The most memory a decoder may take for one image, in bytes.
const MAX_IMAGE_BYTES: u64 = 2 << 30;

thread_local! {
    static IS_GUARDED: Cell<bool> = const { Cell::new(false) };
}

/// Runs a decoder; a panic of it becomes an error, and nothing is printed once [`hide_guarded_panics`] has been called.
///
/// # Errors
/// Those of `decode`.
pub fn guarded<T>(decode: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    let before = IS_GUARDED.replace(true);
    let result = catch_unwind(AssertUnwindSafe(decode));
    IS_GUARDED.set(before);
    result.unwrap_or_else(|_| Err("it is damaged in a way that its decoder does not expect".to_owned()))
}

/// Width and height of an image, as its file announces them.
///
/// # Errors
/// What is wrong with it, as a sentence about the file.
pub fn image_size(file: &[u8]) -> Result<[u32; 2], String> {
    guarded(|| {
        let reader = ImageReader::new(Cursor::new(file)).with_guessed_format().map_err(|e| e.to_string())?;
        reader.into_dimensions().map(<[u32; 2]>::from).map_err(|e| e.to_string())
    })
}

/// Decodes an image whose size the file may have.
///
/// # Errors
/// What is wrong with it, as a sentence about the file.
pub fn decode_image(file: &[u8], format: ImageFormat) -> Result<DynamicImage, String> {
    if let Some(what) = mistaken(file) {
        return Err(what.to_owned());
    }
    guarded(|| {
        let mut reader = ImageReader::with_format(Cursor::new(file), format);
        let mut limits = Limits::default();
        limits.max_image_width = Some(MAX_IMAGE_EDGE);
        limits.max_image_height = Some(MAX_IMAGE_EDGE);
        limits.max_alloc = Some(MAX_IMAGE_BYTES);
        reader.limits(limits);
        let decoder = reader.into_decoder().map_err(|e| e.to_string())?;
        // WebP makes an image of one colour as small as it likes.
        if format != ImageFormat::WebP && !could_hold(file.len() as u64, decoder.total_bytes()) {
            let ((width, height), have) = (decoder.dimensions(), file.len());
            return Err(format!("it cannot have the {width}x{height} pixels that it announces in {have} bytes"));
        }
        DynamicImage::from_decoder(decoder).map_err(|e| e.to_string())
    })
}

/// Whether this thread is in a guarded decoder.
#[must_use]
pub fn is_guarded() -> bool {
    IS_GUARDED.get()
}

/// Has panics of guarded decoders logged instead of printed. Once per process, at its start.
pub fn hide_guarded_panics() {
    let print = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        if is_guarded() {
            log::debug!("a decoder panicked: {}", panic.to_string().replace('\n', " "));
        } else {
            print(panic);
        }
    }));
}

/// Whether a file of so many bytes may hold so many, however well compressed.
#[must_use]
pub fn could_hold(file_bytes: u64, bytes: u64) -> bool {
    bytes / SMALLEST_PART <= file_bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_an_error() {
        assert_eq!(guarded(|| Ok(3)), Ok(3));
        assert_eq!(guarded(|| Err::<(), _>("a".to_owned())), Err("a".to_owned()));
        let failed = guarded::<()>(|| {
            assert!(is_guarded());
            panic!("as a decoder might")
        });
        assert!(failed.is_err_and(|reason| reason.contains("damaged")) && !is_guarded());
    }

    #[test]
    fn sizes_are_believed_as_far_as_the_file_goes() {
        assert!(could_hold(1000, 2_000_000) && could_hold(0, 2000) && !could_hold(1000, 3_000_000));
    }
}
