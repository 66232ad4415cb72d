//! `point_reuse`: what is kept from the frame before while lights and settings stand still, wherever the camera goes. A
//! primary point at the same place sees the same, and a secondary point that is seen by the same texels has the same light,
//! so that nothing of it shows in the picture.

use super::micro_buffers::{PRIMARY_TEXELS, PlacedPoints, seen_texels_bytes};
use super::points::Points;
use super::{Frame, shader, threads};
use crate::gpu::{ComputeWork, Work};
use crate::graph::{Access, BufferHandle, History, Pass};
use crate::settings::MicroFill;

/// What is kept.
#[derive(Clone, Copy, Debug)]
pub struct Kept {
    /// For each primary point its number in the frame before.
    slots: BufferHandle,
    /// What its texels see.
    texels: History<BufferHandle>,
    /// `MicroBuffers::seen_texels`, unless where sides are lit depends on the side alone.
    pub seen_texels: Option<History<BufferHandle>>,
}

/// Adds the pass that finds primary points which stood in the frame before where they stand now.
pub fn match_primaries(frame: &mut Frame, points: &Points, primaries: &PlacedPoints, micro: MicroFill) -> Kept {
    let capacity = primaries.cut.primaries.capacity;
    let places = frame.graph.history_buffer("point_places", 8 * u64::from(capacity));
    let slots = frame.graph.transient_buffer("kept_slots", 4 * u64::from(capacity));
    let texels = frame.graph.history_buffer("kept_texels", 4 * u64::from(PRIMARY_TEXELS) * u64::from(capacity));
    let work = ComputeWork { push: vec![capacity], ..shader("point_reuse/match_primaries", threads(capacity)) };
    let pass = frame
        .compute("point_reuse/match_primaries", work)
        .bind("point_counts", primaries.cut.counts.counts, Access::ComputeReadWrite)
        .bind("point_primaries", primaries.cut.primaries.keys, Access::ComputeRead)
        .bind("primary_leaves", primaries.leaves, Access::ComputeRead)
        .bind("point_nodes", points.nodes, Access::ComputeSampled)
        .bind("point_places", places.current, Access::ComputeWrite)
        .bind("previous_point_places", places.previous, Access::ComputeRead)
        .bind("kept_slots", slots, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    let by_rays = micro == MicroFill::Rays;
    let seen_texels = by_rays.then(|| frame.graph.history_buffer("seen_texels", seen_texels_bytes(points)));
    Kept { slots, texels, seen_texels }
}

impl Kept {
    /// A compute pass that fills micro-buffers, or takes them from the frame before.
    #[must_use]
    pub fn kept_by(&self, pass: Pass<Work>) -> Pass<Work> {
        pass.bind("kept_slots", self.slots, Access::ComputeRead)
            .bind("previous_kept_texels", self.texels.previous, Access::ComputeRead)
            .bind("kept_texels", self.texels.current, Access::ComputeWrite)
    }

    /// Adds the pass that takes out of the `needed` sides those that keep the light of the frame before.
    pub fn keep_light(
        &self,
        frame: &mut Frame,
        points: &Points,
        counts: BufferHandle,
        needed: BufferHandle,
    ) -> BufferHandle {
        let word_count = points.side_words();
        let lit = frame.graph.history_buffer("lit_bits", 4 * u64::from(word_count));
        let unlit = points.side_bits(frame, "unlit_bits");
        let suffix = if self.seen_texels.is_some() { "" } else { "_points" };
        let work = shader(&format!("point_reuse/keep_light{suffix}"), threads(word_count));
        let mut pass = frame
            .compute("point_reuse/keep_light", ComputeWork { push: vec![word_count], ..work })
            .bind("point_counts", counts, Access::ComputeReadWrite)
            .bind("needed_bits", needed, Access::ComputeRead)
            .bind("previous_lit_bits", lit.previous, Access::ComputeRead)
            .bind("lit_bits", lit.current, Access::ComputeWrite)
            .bind("unlit_bits", unlit, Access::ComputeWrite);
        if let Some(texels) = self.seen_texels {
            pass = pass
                .bind("kept_slots", self.slots, Access::ComputeRead)
                .bind("seen_texels", texels.current, Access::ComputeRead)
                .bind("previous_seen_texels", texels.previous, Access::ComputeRead);
        }
        frame.graph.add_pass(pass);
        unlit
    }
}
