//! `micro_buffers`: what primary points see, in 16x16 texels about their normals (Ritschel et al. 2009).

use std::sync::Arc;

use super::pbgi_shape::PbgiShape;
use super::point_cut::PointCut;
use super::point_reuse::{self, Kept};
use super::points::Points;
use super::{Frame, shader};
use crate::gpu::{ComputeWork, Dispatch, Work};
use crate::graph::{Access, BufferHandle, Pass};
use crate::micro_buffers::table;
use crate::settings::MicroFill;
use crate::shared::{
    POINT_DISPATCH_GROUP_EACH, POINT_DISPATCH_GROUP_OF_FOUR, POINT_DISPATCH_THREAD_EACH, POINT_LEAVES, PRIMARY_EDGE,
    SECONDARY_EDGE,
};

/// Texels of a primary point's micro-buffer.
pub const PRIMARY_TEXELS: u32 = PRIMARY_EDGE * PRIMARY_EDGE;

/// What light is gathered with, the same in every frame.
#[derive(Clone, Copy, Debug)]
pub struct GatherTables {
    /// Texels of the micro-buffers of primary points.
    pub primary: BufferHandle,
    /// Of secondary points.
    pub secondary: BufferHandle,
    /// Means of the environment.
    pub environment: BufferHandle,
}

impl GatherTables {
    /// Declares them.
    pub fn declare(frame: &mut Frame, shape: &PbgiShape) -> Self {
        let mut texels = |name: &str, edge: u32| {
            let contents: Arc<[u8]> = bytemuck::cast_slice(&table(edge, shape.hemisphere)).into();
            frame.graph.filled_buffer(name, contents)
        };
        Self {
            primary: texels("micro_table_primary", PRIMARY_EDGE),
            secondary: texels("micro_table_secondary", SECONDARY_EDGE),
            environment: shape.means_buffer(frame),
        }
    }

    /// A compute pass that gathers light of primary points or of pixels.
    #[must_use]
    pub fn primary_read_by(&self, pass: Pass<Work>) -> Pass<Work> {
        self.read_by(pass, self.primary)
    }

    /// A compute pass that gathers light of secondary points.
    #[must_use]
    pub fn secondary_read_by(&self, pass: Pass<Work>) -> Pass<Work> {
        self.read_by(pass, self.secondary)
    }

    fn read_by(&self, pass: Pass<Work>, texels: BufferHandle) -> Pass<Work> {
        pass.bind("micro_table", texels, Access::ComputeRead).bind(
            "environment_means",
            self.environment,
            Access::ComputeRead,
        )
    }
}

/// The primary points, and the leaves of each that the eye sees.
#[derive(Clone, Copy, Debug)]
pub struct PlacedPoints {
    /// The points.
    pub cut: PointCut,
    /// `POINT_LEAVES` words for each.
    pub leaves: BufferHandle,
}

impl PlacedPoints {
    /// A workgroup for each.
    #[must_use]
    pub fn per_point(&self) -> Dispatch {
        self.cut.primaries.dispatch(POINT_DISPATCH_GROUP_EACH)
    }

    /// A thread for each.
    #[must_use]
    pub fn per_thread(&self) -> Dispatch {
        self.cut.primaries.dispatch(POINT_DISPATCH_THREAD_EACH)
    }

    /// A compute pass over as many as there are.
    #[must_use]
    pub fn counted_by(&self, pass: Pass<Work>) -> Pass<Work> {
        let counts = self.cut.counts;
        pass.bind("point_counts", counts.counts, Access::ComputeRead).uses(counts.dispatches, Access::IndirectRead)
    }

    /// A compute pass over the points.
    #[must_use]
    pub fn read_by(&self, pass: Pass<Work>) -> Pass<Work> {
        self.counted_by(pass).bind("point_primaries", self.cut.primaries.keys, Access::ComputeRead).bind(
            "primary_leaves",
            self.leaves,
            Access::ComputeRead,
        )
    }
}

/// Adds the pass that chooses leaves of primary points.
pub fn choose_leaves(frame: &mut Frame, points: &Points, cut: PointCut) -> PlacedPoints {
    let bytes = 4 * u64::from(POINT_LEAVES) * u64::from(cut.primaries.capacity);
    let placed = PlacedPoints { cut, leaves: frame.graph.transient_buffer("primary_leaves", bytes) };
    let work = frame.ray_shader("micro_buffers/choose_leaves", cut.primaries.dispatch(POINT_DISPATCH_GROUP_OF_FOUR));
    let pass = frame
        .compute("micro_buffers/choose_leaves", work)
        .with(|pass| placed.counted_by(pass))
        .bind("point_primaries", cut.primaries.keys, Access::ComputeRead)
        .bind("point_nodes", points.nodes, Access::ComputeSampled)
        .bind("primary_leaves", placed.leaves, Access::ComputeWrite);
    frame.graph.add_pass(pass);
    placed
}

/// What primary points see.
#[derive(Clone, Copy, Debug)]
pub struct MicroBuffers {
    /// For each primary point its texels.
    pub texels: BufferHandle,
    /// One bit for each key: whether any of them sees it.
    pub seen_bits: BufferHandle,
    /// For each key that rays have seen `POINT_LEAVES` words with texels that see it.
    pub seen_texels: Option<BufferHandle>,
    /// What is kept from the frame before.
    pub kept: Option<Kept>,
}

/// Adds the pass.
pub fn add(
    frame: &mut Frame,
    shape: &PbgiShape,
    points: &Points,
    primaries: &PlacedPoints,
    tables: &GatherTables,
) -> MicroBuffers {
    let bytes = 4 * u64::from(PRIMARY_TEXELS) * u64::from(primaries.cut.primaries.capacity);
    let texels = frame.graph.transient_buffer("micro_texels", bytes);
    let seen_bits = points.side_bits(frame, "seen_bits");
    frame.clear(&[(seen_bits, 0)]);
    let kept = shape.reuse.then(|| point_reuse::match_primaries(frame, points, primaries, shape.micro));
    let suffix = if kept.is_some() { "_kept" } else { "" };
    let mut seen_texels = None;
    let mut pass = match shape.micro {
        MicroFill::Rays => {
            let texels = *seen_texels.insert(declare_seen_texels(frame, points, kept.as_ref()));
            let work = frame.ray_shader(&format!("micro_buffers/trace_texels{suffix}"), primaries.per_point());
            frame.compute("micro_buffers/trace_texels", work).with(|pass| points.hit_by(pass)).bind(
                "seen_texels",
                texels,
                Access::ComputeReadWrite,
            )
        }
        MicroFill::Points => {
            let work = shader(&format!("micro_buffers/splat_points{suffix}"), primaries.per_point());
            let work = ComputeWork { constants: vec![shape.binary_coverage()], ..work };
            frame.compute("micro_buffers/splat_points", work)
        }
    };
    if let Some(kept) = &kept {
        pass = kept.kept_by(pass);
    }
    let pass = pass
        .with(|pass| primaries.read_by(pass))
        .bind("point_nodes", points.nodes, Access::ComputeSampled)
        .bind("micro_table", tables.primary, Access::ComputeRead)
        .bind("micro_texels", texels, Access::ComputeWrite)
        .bind("seen_bits", seen_bits, Access::ComputeReadWrite);
    frame.graph.add_pass(pass);
    MicroBuffers { texels, seen_bits, seen_texels, kept }
}

/// Declares what says where sides are lit.
fn declare_seen_texels(frame: &mut Frame, points: &Points, kept: Option<&Kept>) -> BufferHandle {
    let texels = match kept.and_then(|kept| kept.seen_texels) {
        Some(texels) => texels.current,
        None => frame.graph.transient_buffer("seen_texels", seen_texels_bytes(points)),
    };
    frame.clear(&[(texels, u32::MAX)]);
    texels
}

/// Size of [`MicroBuffers::seen_texels`].
pub(super) fn seen_texels_bytes(points: &Points) -> u64 {
    4 * u64::from(POINT_LEAVES) * 2 * u64::from(points.node_count())
}

impl MicroBuffers {
    /// A compute pass that looks at what primary points see.
    #[must_use]
    pub fn read_by(&self, pass: Pass<Work>, tables: &GatherTables) -> Pass<Work> {
        tables.primary_read_by(pass).bind("micro_texels", self.texels, Access::ComputeRead)
    }
}
