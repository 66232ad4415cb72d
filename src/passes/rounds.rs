//! Further rounds of shadow samples in a frame, for pixels whose history is short of frames: each counts as one. The blend of a
//! round lists the tiles that take part in the next one.

use super::Frame;
use super::temporal::{Blended, Reuse};
use crate::gpu::{Dispatch, Work};
use crate::graph::{Access, BufferHandle, ImageHandle, Pass};
use crate::shared::TILE_SIZE;

/// Words of a list before its tiles (`common/rounds.glsl`).
pub const LIST_HEADER: usize = 4;

/// A further round.
#[derive(Clone, Copy, Debug)]
pub struct Round {
    /// From 2 on: the frame's own samples are the first.
    pub number: u32,
    /// Frames that are enough where there is no history.
    pub enough_frames: f32,
    /// Frames in the history in alpha, this one's rounds so far included.
    pub history: ImageHandle,
    /// Tiles of the picture with pixels that take part, after a dispatch of a workgroup for each.
    tiles: BufferHandle,
    /// The same for the next round, if there is one.
    pub next_tiles: Option<BufferHandle>,
}

impl Round {
    /// A workgroup for each tile that takes part.
    #[must_use]
    pub fn dispatch(&self) -> Dispatch {
        Dispatch::Indirect { buffer: self.tiles, offset_bytes: 0 }
    }

    /// Push constants.
    #[must_use]
    pub fn push(&self) -> [u32; 2] {
        [self.number, self.enough_frames.to_bits()]
    }

    /// A pass with [`Self::dispatch`] that runs over the tiles.
    pub fn listed(&self, pass: Pass<Work>) -> Pass<Work> {
        pass.bind("round_tiles", self.tiles, Access::ComputeRead).uses(self.tiles, Access::IndirectRead)
    }
}

/// The further rounds of a frame, in their order.
pub fn all(reuse: Reuse, blended: &Blended) -> Vec<Round> {
    let (enough_frames, history) = (reuse.enough_frames(), blended.histories[0]);
    let tiles = &blended.round_tiles;
    let next = tiles.iter().copied().skip(1).map(Some).chain([None]);
    (2..)
        .zip(tiles.iter().copied().zip(next))
        .map(|(number, (tiles, next_tiles))| Round { number, enough_frames, history, tiles, next_tiles })
        .collect()
}

/// Declares a list of tiles for each further round, empty at the start of the frame.
pub(super) fn declare_tiles(frame: &mut Frame, reuse: Reuse) -> Vec<BufferHandle> {
    let tile_count: u64 =
        [frame.shape.width_px, frame.shape.height_px].map(|edge| u64::from(edge.div_ceil(TILE_SIZE))).iter().product();
    let declare =
        |number| frame.graph.transient_buffer(&format!("round_tiles_{number}"), 4 * (LIST_HEADER as u64 + tile_count));
    let tiles: Vec<BufferHandle> = (2..=reuse.last_round()).map(declare).collect();
    let empty: Vec<(BufferHandle, u32)> = tiles.iter().map(|tiles| (*tiles, 0)).collect();
    frame.clear(&empty);
    tiles
}
