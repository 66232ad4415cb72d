//! Sharing memory between transient resources that are never alive at the same time.
//!
//! The executor's order of work: [`plan`](super::plan()), create the resources, ask for their memory requirements,
//! [`assign`], [`add_alias_barriers`], [`hoist`](super::hoist()), allocate one block per class, bind.

use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::ops::Range;

use super::builder::Graph;
use super::plan::{Barrier, MemoryBarrier, Plan};
use super::resource::Handle;

/// What one transient resource asks of its memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Requirement {
    /// Size in bytes.
    pub size_bytes: u64,
    /// Alignment of the offset in bytes, a power of two.
    pub alignment: u64,
    /// Memory type group: only resources of the same class may share memory. Buffers and images should differ in
    /// class where the device's `bufferImageGranularity` is larger than their alignments.
    pub class: u32,
}

/// Where a resource lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Placement {
    /// Which class's block.
    pub class: u32,
    /// Offset in that block in bytes.
    pub offset_bytes: u64,
}

/// Where every transient resource lies.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct AliasPlan {
    /// Per resource; `None` without a requirement or a lifetime.
    pub placements: Vec<Option<Placement>>,
    /// Size in bytes of the block each class needs.
    pub class_sizes: BTreeMap<u32, u64>,
    /// What the same resources would take without sharing, in bytes.
    pub unaliased_bytes: u64,
}

impl AliasPlan {
    /// Bytes of the memory blocks together.
    #[must_use]
    pub fn aliased_bytes(&self) -> u64 {
        self.class_sizes.values().sum()
    }
}

/// Places every resource that has both a lifetime and a requirement (give one to transient resources only): the
/// largest first, each at the lowest aligned offset that no resource alive at the same time occupies.
#[must_use]
pub fn assign(lifetimes: &[Option<(usize, usize)>], requirements: &[Option<Requirement>]) -> AliasPlan {
    let mut todo: Vec<(usize, (usize, usize), Requirement)> = lifetimes
        .iter()
        .zip(requirements)
        .enumerate()
        .filter_map(|(index, (&lifetime, &requirement))| Some((index, lifetime?, requirement?)))
        .collect();
    todo.sort_by_key(|&(index, _, requirement)| (Reverse(requirement.size_bytes), index));

    let mut plan = AliasPlan { placements: vec![None; lifetimes.len()], ..AliasPlan::default() };
    let mut placed: Vec<(u32, (usize, usize), Range<u64>)> = Vec::new();
    for (index, lifetime, requirement) in todo {
        let mut taken: Vec<&Range<u64>> = placed
            .iter()
            .filter(|(class, other, _)| *class == requirement.class && overlaps(*other, lifetime))
            .map(|(_, _, range)| range)
            .collect();
        taken.sort_by_key(|range| range.start);
        let mut offset_bytes = 0;
        for range in taken {
            if offset_bytes + requirement.size_bytes <= range.start {
                break;
            }
            offset_bytes = offset_bytes.max(range.end.next_multiple_of(requirement.alignment.max(1)));
        }
        let end = offset_bytes + requirement.size_bytes;
        placed.push((requirement.class, lifetime, offset_bytes..end));
        plan.placements[index] = Some(Placement { class: requirement.class, offset_bytes });
        let block = plan.class_sizes.entry(requirement.class).or_default();
        *block = end.max(*block);
        plan.unaliased_bytes += requirement.size_bytes.next_multiple_of(requirement.alignment.max(1));
    }
    plan
}

fn overlaps(a: (usize, usize), b: (usize, usize)) -> bool {
    a.0 <= b.1 && b.0 <= a.1
}

/// Makes the first use of every placed resource also wait for the last uses of those that share its memory, whether
/// they came earlier in the frame or later in the frame before.
///
/// Vulkan limits the memory side of a buffer or image barrier to that one resource, so the dependency becomes the
/// pass's [`takeover`](super::PlannedPass::takeover). The layout transition of an image, a write to that memory, is
/// ordered by its own barrier only: that barrier's source is widened as well.
pub fn add_alias_barriers<P>(
    plan: &mut Plan,
    graph: &Graph<P>,
    requirements: &[Option<Requirement>],
    alias: &AliasPlan,
) {
    let range = |index: usize| {
        let placement = alias.placements.get(index).copied().flatten()?;
        let size_bytes = requirements.get(index).copied().flatten()?.size_bytes;
        Some((placement.class, placement.offset_bytes, placement.offset_bytes + size_bytes))
    };
    for index in 0..graph.resources().len() {
        let (Some((class, start, end)), Some((first, _))) = (range(index), plan.lifetimes[index]) else { continue };
        let sharing: Vec<usize> = (0..graph.resources().len())
            .filter(|&other| other != index)
            .filter(|&other| range(other).is_some_and(|(c, s, e)| c == class && s < end && start < e))
            .collect();
        if !sharing.is_empty() {
            take_over(plan, graph, Handle(index), first, &sharing);
        }
        plan.sharing[index] = sharing;
    }
}

/// Makes pass `first`, the first to use `resource`, wait for the last uses of `former`, whose memory it takes over. Levels
/// of an image that begin later find the memory available, but their transitions wait as well.
fn take_over<P>(plan: &mut Plan, graph: &Graph<P>, resource: Handle, first: usize, former: &[usize]) {
    let mut dependency = MemoryBarrier::default();
    for &other in former {
        let (stages, writes) = plan.last_uses[other];
        dependency.src_stage |= stages;
        dependency.src_access |= writes;
    }
    let kind = graph.resources()[resource.index()].info.kind();
    for used in graph.passes()[first].uses.iter().filter(|used| used.resource == resource) {
        let scope = used.access.sync(kind);
        dependency.dst_stage |= scope.stages;
        dependency.dst_access |= scope.access;
    }
    let begins = |barrier: &&mut Barrier| barrier.resource == resource && barrier.drops_contents();
    for barrier in plan.passes.iter_mut().flat_map(|pass| &mut pass.barriers).filter(begins) {
        barrier.src_stage |= dependency.src_stage;
        barrier.src_access |= dependency.src_access;
    }
    *plan.passes[first].takeover.get_or_insert_default() |= dependency;
}
