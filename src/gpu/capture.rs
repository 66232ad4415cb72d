//! Captures of single frames by RenderDoc, where its library is installed.

use std::path::PathBuf;

use libloading::Library;
use renderdoc::{OverlayBits, RenderDoc, V112};

use crate::error::{Error, Result};

/// Name of RenderDoc's library.
const LIBRARY: &str = if cfg!(windows) { "renderdoc.dll" } else { "librenderdoc.so" };

/// One frame for RenderDoc to capture.
pub struct FrameCapture {
    renderdoc: RenderDoc<V112>,
    frame: u64,
    /// Captures that there were when the frame began.
    before: Option<u32>,
    done: bool,
}

impl FrameCapture {
    /// Loads RenderDoc when a frame is to be captured. Must come before the Vulkan instance.
    ///
    /// # Errors
    /// [`Error::Usage`] when the library is not there.
    pub fn load(frame: Option<u32>) -> Result<Option<Self>> {
        let Some(frame) = frame else { return Ok(None) };
        // SAFETY: RenderDoc's library does nothing but hook the graphics libraries when it is loaded, which is what is
        // asked for. It stays until the program ends.
        match unsafe { Library::new(LIBRARY) } {
            Ok(library) => std::mem::forget(library),
            Err(error) => log::info!("{error}"),
        }
        let mut renderdoc: RenderDoc<V112> = RenderDoc::new().map_err(|error| {
            log::info!("{error}");
            Error::Usage(format!(
                "--renderdoc-frame needs RenderDoc's library ({LIBRARY}), which is not there: install RenderDoc \
                 (Debian: apt install renderdoc), or start gridlight from it"
            ))
        })?;
        if !renderdoc.is_target_control_connected() {
            // Not started by RenderDoc's own program, which has its places and its overlay.
            renderdoc.set_capture_file_path_template("gridlight");
            renderdoc.mask_overlay_bits(OverlayBits::NONE, OverlayBits::NONE);
        }
        Ok(Some(Self { renderdoc, frame: u64::from(frame), before: None, done: false }))
    }

    /// The same result, where no device fits with a word on what RenderDoc may have to do with it.
    ///
    /// # Errors
    /// That of the result.
    pub fn opened<T>(capture: Option<&Self>, result: Result<T>) -> Result<T> {
        result.map_err(|error| match (capture, error) {
            (Some(_), Error::NoDevice(what)) => Error::NoDevice(format!(
                "{what}; RenderDoc is loaded and may offer less of Vulkan than the driver does: try another version of it"
            )),
            (_, error) => error,
        })
    }

    /// A frame begins.
    pub fn begin(&mut self, number: u64) {
        if number == self.frame && !self.done {
            self.before = Some(self.renderdoc.get_num_captures());
            self.renderdoc.start_frame_capture(std::ptr::null(), std::ptr::null());
        }
    }

    /// The frame that began last is over; gives the file when it was the one to capture. One that was not shown after all
    /// is captured again.
    ///
    /// # Errors
    /// [`Error::Failure`] when RenderDoc made no file.
    pub fn end(&mut self, was_shown: bool) -> Result<Option<PathBuf>> {
        let Some(before) = self.before.take() else { return Ok(None) };
        self.done = was_shown;
        self.renderdoc.end_frame_capture(std::ptr::null(), std::ptr::null());
        if !was_shown {
            return Ok(None);
        }
        let (path, _) = self.renderdoc.get_capture(before).ok_or_else(|| {
            Error::Failure(format!(
                "RenderDoc made no capture of frame {}: its Vulkan layer may not be installed",
                self.frame
            ))
        })?;
        log::warn!("RenderDoc captured frame {} in {}", self.frame, path.display());
        Ok(Some(path))
    }
}
