//! A finished picture in a window: a small frame of its own, so that a window shows the last picture, and its panel over it,
//! while the next one is rendered.

use std::collections::VecDeque;
use std::sync::Arc;

use crate::error::Result;
use crate::gpu::{Executor, FrameTicket, Gpu, SharedImage, WindowTarget};
use crate::passes::present::{self, Part, WindowFormat};

/// What brings a picture into the window, or nothing but the panel.
pub struct Show {
    executor: Executor,
    part: Part,
    under_way: VecDeque<FrameTicket>,
}

impl Show {
    /// For a picture; without one its part of the window is black.
    ///
    /// # Errors
    /// Device errors.
    pub fn new(gpu: &Arc<Gpu>, picture: Option<&Arc<SharedImage>>, window: WindowFormat, part: Part) -> Result<Self> {
        let graph = present::show(window, part, picture.is_some());
        let executor = Executor::with_images(gpu, graph, None, picture.cloned().into_iter().collect())?;
        Ok(Self { executor, part, under_way: VecDeque::new() })
    }

    /// Which part of the window it fills.
    #[must_use]
    pub fn part(&self) -> Part {
        self.part
    }

    /// How many of its frames are not done.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn count_under_way(&mut self) -> Result<usize> {
        while let Some(ticket) = self.under_way.front() {
            if !self.executor.is_done(ticket)? {
                break;
            }
            self.under_way.pop_front();
        }
        Ok(self.under_way.len())
    }

    /// Submits one frame into an image of the window.
    ///
    /// # Errors
    /// When the device is lost, and those of the overlay.
    pub fn submit(&mut self, shown: &mut WindowTarget<'_>) -> Result<()> {
        let ticket = self.executor.submit_to(&[], shown)?;
        self.under_way.push_back(ticket);
        Ok(())
    }
}
