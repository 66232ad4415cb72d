//! Fewer batches of barriers: what a pass waits for is recorded earlier, where others wait as well.
//!
//! A barrier does its duty anywhere between the last earlier use that it must follow and the pass that needs it. The
//! fewest points that hit all these intervals are found by always taking the end of the one that ends first.

use super::builder::{Graph, Use};
use super::plan::{Barrier, MemoryBarrier, Plan, PlannedPass, meet};
use super::resource::Lifetime;

/// Something recorded before a pass, and the passes before which it may be recorded instead.
struct Movable {
    earliest: usize,
    latest: usize,
    what: What,
}

#[derive(Clone, Copy)]
enum What {
    Barrier(Barrier),
    Takeover(MemoryBarrier),
}

/// Moves barriers to earlier passes, so that as few passes as possible have any before them: the last step of a
/// plan, after [`add_alias_barriers`](super::add_alias_barriers).
pub fn hoist<P>(plan: &mut Plan, graph: &Graph<P>) {
    let movable = movable(plan, graph);
    for pass in &mut plan.passes {
        pass.barriers.clear();
        pass.takeover = None;
    }
    let mut batch = None;
    // In the order of their passes, that is of the ends of their intervals.
    for Movable { earliest, latest, what } in movable {
        let at = batch.filter(|&at| at >= earliest).unwrap_or(latest);
        batch = Some(at);
        place(&mut plan.passes[at], what);
    }
}

fn movable<P>(plan: &Plan, graph: &Graph<P>) -> Vec<Movable> {
    let mut all = Vec::new();
    for (latest, pass) in plan.passes.iter().enumerate() {
        if let Some(takeover) = pass.takeover {
            let taken_over = plan.lifetimes.iter().enumerate();
            let starting = taken_over.filter(|(_, life)| life.is_some_and(|(first, _)| first == latest));
            let earliest = starting.map(|(index, _)| after_former_owners(plan, index, latest)).max();
            all.push(Movable { earliest: earliest.unwrap_or(latest), latest, what: What::Takeover(takeover) });
        }
        for barrier in &pass.barriers {
            let earliest = earliest(plan, graph, barrier, latest);
            all.push(Movable { earliest, latest, what: What::Barrier(*barrier) });
        }
    }
    all
}

/// The first pass that the barrier of pass `latest` may be recorded before.
fn earliest<P>(plan: &Plan, graph: &Graph<P>, barrier: &Barrier, latest: usize) -> usize {
    let resource = barrier.resource;
    if graph.resources()[resource.index()].lifetime.is_acquired() {
        // Nobody may touch it before the submission that waits for its semaphore, which begins with its first pass.
        return latest;
    }
    if graph.resources()[resource.index()].lifetime == Lifetime::Imported && barrier.is_transition() {
        // Others may read the image between the submissions of this frame, until its own pass.
        return latest;
    }
    let info = graph.resources()[resource.index()].info;
    let is_meant = |used: &&Use| used.resource == resource && meet(&info.levels(used.level), &barrier.levels());
    let uses = |pass: usize| graph.passes()[pass].uses.iter().filter(is_meant);
    let writes = |pass: usize| uses(pass).any(|used| used.access.is_write());
    // What only makes contents visible to a reader goes before other readers, too.
    let follows_readers = barrier.is_transition() || writes(latest);
    let transitions =
        |pass: usize| plan.passes[pass].barriers.iter().any(|other| other.is_transition() && barrier.meets(other));
    let follows = |pass: &usize| {
        if follows_readers { uses(*pass).next().is_some() } else { writes(*pass) || transitions(*pass) }
    };
    let after_own = (0..latest).rev().find(follows).map_or(0, |pass| pass + 1);
    after_own.max(after_former_owners(plan, resource.index(), latest))
}

/// The first pass after those in the frame before pass `latest` that use memory which the resource shares.
fn after_former_owners(plan: &Plan, resource: usize, latest: usize) -> usize {
    let lasts = plan.sharing[resource].iter().filter_map(|&other| plan.lifetimes[other]).map(|(_, last)| last);
    lasts.filter(|&last| last < latest).map(|last| last + 1).max().unwrap_or(0)
}

/// Adds to the batch before a pass; two barriers for readers of the same levels of one resource become one.
fn place(pass: &mut PlannedPass, what: What) {
    let barrier = match what {
        What::Takeover(takeover) => return *pass.takeover.get_or_insert_default() |= takeover,
        What::Barrier(barrier) => barrier,
    };
    let alone = |other: &Barrier| !other.meets(&barrier) || !(other.is_transition() || barrier.is_transition());
    debug_assert!(pass.barriers.iter().all(alone), "a transition follows every use");
    let same = |other: &&mut Barrier| other.resource == barrier.resource && other.levels() == barrier.levels();
    match pass.barriers.iter_mut().find(same) {
        Some(other) => {
            other.src_stage |= barrier.src_stage;
            other.src_access |= barrier.src_access;
            other.dst_stage |= barrier.dst_stage;
            other.dst_access |= barrier.dst_access;
        }
        None => pass.barriers.push(barrier),
    }
}
