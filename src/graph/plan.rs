//! From a declared frame to its barriers, as plain data.
//!
//! Per buffer and per mip level of an image, with all its layers, the plan tracks the last write, the stages that have
//! read since, what the write is already visible to, and the layout. A layout transition counts as a write that is
//! over as soon as it is visible.

use std::ops::{BitOrAssign, Range};

use ash::vk::{AccessFlags2 as Mask, ImageLayout, PipelineStageFlags2 as Stage};

use super::builder::Graph;
use super::check::{Need, PlanError, check};
use super::resource::{Handle, IMPORTED_LAYOUT, ImageHandle, ImageLevel, Lifetime, Resource, ResourceInfo};

const WRITES: Mask = Mask::from_raw(
    Mask::SHADER_STORAGE_WRITE.as_raw()
        | Mask::COLOR_ATTACHMENT_WRITE.as_raw()
        | Mask::DEPTH_STENCIL_ATTACHMENT_WRITE.as_raw()
        | Mask::ACCELERATION_STRUCTURE_WRITE_KHR.as_raw()
        | Mask::TRANSFER_WRITE.as_raw(),
);
/// Everything that anybody on the queue may do.
const EVERYTHING: (Stage, Mask) =
    (Stage::ALL_COMMANDS, Mask::from_raw(Mask::MEMORY_READ.as_raw() | Mask::MEMORY_WRITE.as_raw()));

/// Everything an executor needs to record the frame, over and over on one queue.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The graph's passes, in the same order.
    pub passes: Vec<PlannedPass>,
    /// What to record after the last pass: imported resources that passes have written become visible to every other
    /// graph. Empty where the barriers of this frame's own readers have done so.
    pub release: Vec<Barrier>,
    /// First and last pass that use each resource; `None` for one that no pass uses.
    pub lifetimes: Vec<Option<(usize, usize)>>,
    /// Layout each used level of a persistent image must be brought to once, before the first frame; that transition
    /// (from `UNDEFINED`) must be complete and visible to every stage.
    pub initial: Vec<(ImageLevel, ImageLayout)>,
    /// Per resource, stages and writes of its last uses in a frame: what new contents of its memory must wait for.
    pub(super) last_uses: Vec<(Stage, Mask)>,
    /// Per resource, those that share memory with it.
    pub(super) sharing: Vec<Vec<usize>>,
}

/// One pass of the plan.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlannedPass {
    /// The pass's name.
    pub name: String,
    /// What to record before the pass, in one batch; at most one barrier for each buffer or level of an image.
    pub barriers: Vec<Barrier>,
    /// Recorded in the same batch: a barrier for all memory, where resources first used by this pass (or, after
    /// [`hoist`](super::hoist()), a later one) take over memory from others. Nothing else needs one.
    pub takeover: Option<MemoryBarrier>,
    /// What to record between two repetitions of a pass that repeats; empty for others.
    pub between: Vec<Barrier>,
}

/// One dependency between everything before it and a pass, over all memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MemoryBarrier {
    /// Stages to wait for.
    pub src_stage: Stage,
    /// Writes to make available.
    pub src_access: Mask,
    /// Stages that wait.
    pub dst_stage: Stage,
    /// Accesses that the contents become visible to.
    pub dst_access: Mask,
}

impl BitOrAssign for MemoryBarrier {
    fn bitor_assign(&mut self, other: Self) {
        self.src_stage |= other.src_stage;
        self.src_access |= other.src_access;
        self.dst_stage |= other.dst_stage;
        self.dst_access |= other.dst_access;
    }
}

/// One dependency between earlier uses of a resource and a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Barrier {
    /// The resource.
    pub resource: Handle,
    /// First mip level that it is for; 0 for buffers.
    pub first_level: u32,
    /// How many mip levels it is for; 1 for buffers.
    pub level_count: u32,
    /// Stages to wait for.
    pub src_stage: Stage,
    /// Writes to make available; `NONE` where only the order of execution matters.
    pub src_access: Mask,
    /// Stages that wait.
    pub dst_stage: Stage,
    /// Accesses the contents become visible to.
    pub dst_access: Mask,
    /// Layout the image is in; `UNDEFINED` for buffers, and for images whose contents are dropped.
    pub old_layout: ImageLayout,
    /// Layout the pass needs; `UNDEFINED` for buffers.
    pub new_layout: ImageLayout,
}

impl Barrier {
    /// Whether the image's layout changes.
    #[must_use]
    pub fn is_transition(&self) -> bool {
        self.old_layout != self.new_layout
    }

    /// Whether an image begins with it, its former contents of no use.
    #[must_use]
    pub fn drops_contents(&self) -> bool {
        self.is_transition() && self.old_layout == ImageLayout::UNDEFINED
    }

    /// Whether both are for the same buffer, or for the same level of an image.
    pub(super) fn meets(&self, other: &Self) -> bool {
        self.resource == other.resource && meet(&self.levels(), &other.levels())
    }

    /// Whether `next` is the same for the levels that follow.
    fn continues_with(&self, next: &Self) -> bool {
        let end = self.levels().end;
        next.first_level == end && Self { first_level: end, level_count: next.level_count, ..*self } == *next
    }

    /// The mip levels that it is for.
    #[must_use]
    pub fn levels(&self) -> Range<u32> {
        self.first_level..self.first_level + self.level_count
    }
}

impl PlannedPass {
    /// Whether there is anything to record before the pass.
    #[must_use]
    pub fn has_batch(&self) -> bool {
        !self.barriers.is_empty() || self.takeover.is_some()
    }
}

impl Plan {
    /// Number of barriers of single resources in a frame.
    #[must_use]
    pub fn barrier_count(&self) -> usize {
        self.passes.iter().map(|pass| pass.barriers.len()).sum::<usize>() + self.release.len()
    }

    /// Number of batches of barriers in a frame: before passes, and after the last one.
    #[must_use]
    pub fn batch_count(&self) -> usize {
        self.passes.iter().filter(|pass| pass.has_batch()).count() + usize::from(!self.release.is_empty())
    }
}

/// Checks the graph and plans the barriers of a frame that follows another frame of the same plan.
///
/// # Errors
/// See [`PlanError`]: the first thing found wrong with the graph.
pub fn plan<P>(graph: &Graph<P>) -> Result<Plan, PlanError> {
    let needs = check(graph)?;
    let resources = graph.resources();
    let mut states: Vec<Vec<State>> =
        resources.iter().map(|resource| vec![State::default(); resource.info.level_count() as usize]).collect();
    let mut passes = Vec::new();
    // The first runs find the state a frame leaves behind, two for pairs that change places; the last plans the frame
    // that starts from it.
    for _ in 0..3 {
        begin_frame(resources, &mut states);
        passes.clear();
        for (pass, needs) in graph.passes().iter().zip(&needs) {
            let before = |need: &Need| states[need.resource.index()][need.level as usize].advance(need);
            let barriers = join_levels(needs.iter().filter_map(before));
            let between = if pass.repeats { join_levels(needs.iter().filter_map(repetition)) } else { Vec::new() };
            passes.push(PlannedPass { name: pass.name.clone(), barriers, takeover: None, between });
        }
    }
    let lifetimes = lifetimes(resources.len(), &needs);
    let initial = initial_layouts(resources, &states, &lifetimes);
    let last_uses = states.iter().map(|levels| last_use(levels)).collect();
    let left = states.iter().enumerate().flat_map(|(index, levels)| levels.iter().zip(0..).map(move |l| (index, l)));
    let release = join_levels(left.filter_map(|(index, (state, level))| state.release(Handle(index), level)));
    Ok(Plan { passes, release, lifetimes, initial, last_uses, sharing: vec![Vec::new(); resources.len()] })
}

/// Per resource, the first and the last pass that use it.
type Lifetimes = Vec<Option<(usize, usize)>>;

fn lifetimes(count: usize, needs: &[Vec<Need>]) -> Lifetimes {
    let mut lifetimes: Lifetimes = vec![None; count];
    for (pass, needs) in needs.iter().enumerate() {
        for need in needs {
            lifetimes[need.resource.index()].get_or_insert((pass, pass)).1 = pass;
        }
    }
    lifetimes
}

/// Stages and writes that have to be over before anything else may happen to a resource's memory.
fn last_use(levels: &[State]) -> (Stage, Mask) {
    levels.iter().fold((Stage::NONE, Mask::NONE), |(stages, writes), state| {
        (stages | state.write_stages | state.read_stages, writes | state.write_access)
    })
}

/// Whether two ranges of levels have one in common.
pub(super) fn meet(a: &Range<u32>, b: &Range<u32>) -> bool {
    a.start < b.end && b.start < a.end
}

/// Makes one of barriers that are the same for consecutive levels of an image.
fn join_levels(barriers: impl Iterator<Item = Barrier>) -> Vec<Barrier> {
    let mut joined: Vec<Barrier> = Vec::new();
    for barrier in barriers {
        match joined.last_mut() {
            Some(last) if last.continues_with(&barrier) => last.level_count += barrier.level_count,
            _ => joined.push(barrier),
        }
    }
    joined
}

/// What a frame finds of its resources, from what the frame before left.
fn begin_frame(resources: &[Resource], states: &mut [Vec<State>]) {
    for (index, resource) in resources.iter().enumerate() {
        let drop_contents = |state: &mut State| state.layout = Some(ImageLayout::UNDEFINED);
        match resource.lifetime {
            Lifetime::Transient => states[index].iter_mut().for_each(drop_contents),
            Lifetime::Acquired => states[index].fill(State::acquired()),
            Lifetime::Continued => states[index].fill(State::continued()),
            // The host has waited for the frame that last had this buffer.
            Lifetime::Readback => states[index].fill(State::default()),
            Lifetime::Previous { current } => {
                states.swap(index, current.index());
                // Its contents are two frames old.
                states[current.index()].iter_mut().for_each(drop_contents);
            }
            Lifetime::Imported => states[index].fill(State::imported(resource.info)),
            Lifetime::Persistent | Lifetime::Current { .. } => {}
        }
    }
}

/// The layouts in which the first frame expects the images that keep theirs, from what a frame leaves.
fn initial_layouts(
    resources: &[Resource],
    states: &[Vec<State>],
    lifetimes: &[Option<(usize, usize)>],
) -> Vec<(ImageLevel, ImageLayout)> {
    let used = (0..resources.len()).filter(|index| lifetimes[*index].is_some());
    let left = used.filter_map(|index| match (resources[index].info, resources[index].lifetime) {
        (ResourceInfo::Image(_), Lifetime::Persistent) => Some((index, &states[index])),
        (ResourceInfo::Image(_), Lifetime::Previous { current }) => Some((index, &states[current.index()])),
        _ => None,
    });
    let levels = left.flat_map(|(index, levels)| {
        let layouts = levels.iter().zip(0..);
        layouts.filter_map(move |(state, level)| Some((ImageHandle(index).level(level), state.layout?)))
    });
    levels.collect()
}

/// The barrier between two repetitions of a pass for something it writes.
fn repetition(need: &Need) -> Option<Barrier> {
    need.writes.then_some(Barrier {
        resource: need.resource,
        first_level: need.level,
        level_count: 1,
        src_stage: need.scope.stages,
        src_access: need.scope.access & WRITES,
        dst_stage: need.scope.stages,
        dst_access: need.scope.access,
        old_layout: need.scope.layout,
        new_layout: need.scope.layout,
    })
}

/// What is known of a buffer, or of one level of an image, between two passes.
#[derive(Clone, Debug, Default)]
struct State {
    /// Stages of the last write, or stages that already wait for the last layout transition.
    write_stages: Stage,
    /// Writes not yet made available by a transition.
    write_access: Mask,
    /// Stages that have read since the last write.
    read_stages: Stage,
    /// Stage and access pairs that the last write is visible to.
    visible: Vec<(Stage, Mask)>,
    /// Current layout; `None` before the first use in a persistent resource's life, which takes what it needs.
    layout: Option<ImageLayout>,
    /// Layout to leave behind, of a resource that other graphs use as well.
    shared: Option<ImageLayout>,
}

impl State {
    /// What an acquired image begins a frame with: no contents, and nobody may touch it before the stage at which
    /// the semaphore of its acquisition is waited for.
    fn acquired() -> Self {
        Self { write_stages: Stage::COLOR_ATTACHMENT_OUTPUT, layout: Some(ImageLayout::UNDEFINED), ..Self::default() }
    }

    /// What an image begins with that another graph on the same queue has left as a colour attachment.
    fn continued() -> Self {
        Self {
            write_stages: Stage::COLOR_ATTACHMENT_OUTPUT,
            write_access: Mask::COLOR_ATTACHMENT_WRITE,
            layout: Some(ImageLayout::COLOR_ATTACHMENT_OPTIMAL),
            ..Self::default()
        }
    }

    /// What an imported resource begins with: contents that everybody sees, and readers anywhere.
    fn imported(info: ResourceInfo) -> Self {
        let layout = match info {
            ResourceInfo::Buffer(_) => ImageLayout::UNDEFINED,
            ResourceInfo::Image(_) => IMPORTED_LAYOUT,
        };
        Self { read_stages: EVERYTHING.0, layout: Some(layout), shared: Some(layout), ..Self::default() }
    }

    /// What an imported resource needs at the end of a frame.
    fn release(&self, resource: Handle, first_level: u32) -> Option<Barrier> {
        let new_layout = self.shared?;
        let old_layout = self.layout?;
        let transition = old_layout != new_layout;
        let unseen = !self.write_stages.is_empty() && !self.visible_to_everything();
        (transition || unseen).then_some(Barrier {
            resource,
            first_level,
            level_count: 1,
            src_stage: self.write_stages | if transition { self.read_stages } else { Stage::NONE },
            src_access: self.write_access,
            dst_stage: EVERYTHING.0,
            dst_access: EVERYTHING.1,
            old_layout,
            new_layout,
        })
    }

    fn visible_to_everything(&self) -> bool {
        self.visible.iter().any(|(stage, _)| *stage == EVERYTHING.0)
    }

    /// Moves past one pass; the barrier to record before it, if it needs one.
    fn advance(&mut self, need: &Need) -> Option<Barrier> {
        let scope = need.scope;
        let old_layout = self.layout.unwrap_or(scope.layout);
        let transition = old_layout != scope.layout;
        let unseen = need.reads && !self.sees(need);
        let mut src_stage = Stage::NONE;
        let mut src_access = Mask::NONE;
        if transition || unseen || (need.writes && self.read_stages.is_empty()) {
            src_stage |= self.write_stages;
            src_access |= self.write_access;
        }
        if transition || need.writes {
            src_stage |= self.read_stages;
        }
        // Readers of other graphs have no barrier of their own, so that ours is for them as well.
        let for_all = self.shared.is_some() && !need.writes;
        let (dst_stage, dst_access) = if for_all { EVERYTHING } else { (scope.stages, scope.access) };
        let barrier = (transition || !src_stage.is_empty()).then_some(Barrier {
            resource: need.resource,
            first_level: need.level,
            level_count: 1,
            src_stage,
            src_access,
            dst_stage,
            dst_access,
            old_layout,
            new_layout: scope.layout,
        });

        self.layout = Some(scope.layout);
        if need.writes {
            *self = Self {
                write_stages: scope.stages,
                write_access: scope.access & WRITES,
                layout: self.layout,
                shared: self.shared,
                ..Self::default()
            };
            return barrier;
        }
        if transition {
            // Later barriers must follow the transition, so they wait for the stages that waited for it.
            *self = Self { write_stages: dst_stage, layout: self.layout, shared: self.shared, ..Self::default() };
        }
        if barrier.is_some() {
            self.visible.extend(pairs(dst_stage, dst_access));
        }
        self.read_stages |= scope.stages;
        barrier
    }

    /// Whether everything the pass reads is already visible to it.
    fn sees(&self, need: &Need) -> bool {
        self.write_stages.is_empty()
            || self.visible_to_everything()
            || pairs(need.scope.stages, need.scope.access & !WRITES).all(|pair| self.visible.contains(&pair))
    }
}

/// Every single stage with every single access that it can perform; for everything at once, one pair.
fn pairs(stages: Stage, access: Mask) -> impl Iterator<Item = (Stage, Mask)> {
    let bits = |raw: u64| (0..u64::BITS).map(|bit| 1 << bit).filter(move |bit| raw & bit != 0);
    bits(stages.as_raw())
        .flat_map(move |stage| bits(access.as_raw()).map(move |mask| (Stage::from_raw(stage), Mask::from_raw(mask))))
        .filter(|&(stage, mask)| performs(stage, mask))
}

/// Whether a stage can perform an access, among the stages and accesses the graph knows.
fn performs(stage: Stage, access: Mask) -> bool {
    let tests = Stage::EARLY_FRAGMENT_TESTS | Stage::LATE_FRAGMENT_TESTS;
    match access {
        Mask::MEMORY_READ => stage == Stage::ALL_COMMANDS,
        Mask::ACCELERATION_STRUCTURE_READ_KHR => {
            (Stage::COMPUTE_SHADER | Stage::ACCELERATION_STRUCTURE_BUILD_KHR).contains(stage)
        }
        Mask::ACCELERATION_STRUCTURE_WRITE_KHR | Mask::SHADER_READ => stage == Stage::ACCELERATION_STRUCTURE_BUILD_KHR,
        Mask::DEPTH_STENCIL_ATTACHMENT_READ | Mask::DEPTH_STENCIL_ATTACHMENT_WRITE => tests.contains(stage),
        Mask::COLOR_ATTACHMENT_READ | Mask::COLOR_ATTACHMENT_WRITE => stage == Stage::COLOR_ATTACHMENT_OUTPUT,
        Mask::INDIRECT_COMMAND_READ => stage == Stage::DRAW_INDIRECT,
        Mask::VERTEX_ATTRIBUTE_READ => stage == Stage::VERTEX_ATTRIBUTE_INPUT,
        Mask::INDEX_READ => stage == Stage::INDEX_INPUT,
        Mask::TRANSFER_READ | Mask::TRANSFER_WRITE => stage == Stage::ALL_TRANSFER,
        Mask::HOST_READ => stage == Stage::HOST,
        _ => (Stage::VERTEX_SHADER | Stage::FRAGMENT_SHADER | Stage::COMPUTE_SHADER).contains(stage),
    }
}
