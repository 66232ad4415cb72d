//! An independent judge of plans: plays frames through Vulkan's memory model and reports the first hazard.
//!
//! A buffer is one part, an image one for each mip level, laid one after the other in the image's memory. Memory is cut
//! into cells at the ends of placed parts, so that parts sharing memory share cells. A cell remembers past operations
//! and the part each went through. A barrier works on the cells of its parts: operations in its source scope (or
//! already ordered before a stage in it) become ordered before its destination stages, whichever part they went
//! through. Its memory side is that of its own parts: writes through them become available if the access is named, and
//! available writes become visible to the destination. Only a planned memory barrier does that for writes through
//! others. A layout transition is itself a write that is available at once. Barriers of one batch do not follow each
//! other.

use std::collections::HashSet;
use std::ops::Range;

use ash::vk::{AccessFlags2 as Mask, ImageLayout, PipelineStageFlags2 as Stage};
use gridlight::graph::{
    AliasPlan, Barrier, Graph, Handle, ImageLevel, Kind, Lifetime, MemoryBarrier, Pass, Plan, Requirement, Resource,
    ResourceInfo, Use,
};

#[derive(Clone, Debug)]
struct Op {
    /// The part it went through.
    through: usize,
    stage: u64,
    /// 0 for reads.
    write: u64,
    ordered: u64,
    /// What `ordered` was before the batch of barriers that is played.
    ordered_before: u64,
    available: bool,
    visible: HashSet<(u64, u64)>,
}

#[derive(Clone, Debug, Default)]
struct Cell {
    ops: Vec<Op>,
    /// Which part's contents the cell holds.
    owner: Option<usize>,
}

/// Where resources lie that share memory.
pub type Placed<'a> = Option<(&'a AliasPlan, &'a [Option<Requirement>])>;

/// What memory and images are like at some point of a frame.
struct Machine<'a, P> {
    graph: &'a Graph<P>,
    cells: Vec<Cell>,
    /// Parts of each resource.
    parts_of: Vec<Range<usize>>,
    /// Which cells each part has.
    cells_of: Vec<Range<usize>>,
    /// Layout of each part.
    layouts: Vec<ImageLayout>,
    /// Which physical part stands in the place of each; those of a history change places.
    places: Vec<usize>,
}

/// Plays four frames in a row; the text of an error says what went wrong where.
pub fn check<P>(graph: &Graph<P>, plan: &Plan, placed: Placed<'_>) -> Result<(), String> {
    let mut machine = Machine::new(graph, plan, placed);
    for frame in 0..4 {
        machine.begin_frame(frame);
        for (pass, planned) in graph.passes().iter().zip(&plan.passes) {
            let at = |(what, resource): Hazard| {
                let resource = resource.map_or("memory", |index| &graph.resources()[index].name);
                format!("frame {frame}, pass {}, {resource}: {what}", pass.name)
            };
            machine.batch(planned.takeover.as_ref(), &planned.barriers).map_err(at)?;
            machine.run(pass).map_err(at)?;
            for _ in 0..if pass.repeats { 2 } else { 0 } {
                machine.batch(None, &planned.between).map_err(at)?;
                machine.run(pass).map_err(at)?;
            }
        }
        let at = |(what, resource): Hazard| {
            let resource = resource.map_or("memory", |index| &graph.resources()[index].name);
            format!("frame {frame}, after its passes, {resource}: {what}")
        };
        machine.batch(None, &plan.release).map_err(at)?;
        machine.hand_over().map_err(at)?;
    }
    Ok(())
}

/// What is wrong, with the resource's index.
type Hazard = (&'static str, Option<usize>);

impl<'a, P> Machine<'a, P> {
    fn new(graph: &'a Graph<P>, plan: &Plan, placed: Placed<'_>) -> Self {
        let parts_of = parts_of(graph.resources());
        let count = parts_of.last().map_or(0, |parts| parts.end);
        let (cells_of, cell_count) = cut(&parts_of, placed);
        let mut machine = Self {
            graph,
            cells: vec![Cell::default(); cell_count],
            parts_of,
            cells_of,
            layouts: vec![ImageLayout::UNDEFINED; count],
            places: (0..count).collect(),
        };
        for &(ImageLevel { image, level }, layout) in &plan.initial {
            let part = machine.parts_of[Handle::from(image).index()].start + level as usize;
            machine.layouts[part] = layout;
        }
        for (index, resource) in graph.resources().iter().enumerate() {
            for part in machine.parts_of[index].clone() {
                if resource.lifetime == Lifetime::Imported {
                    machine.layouts[part] = resting_layout(resource);
                }
                if resource.lifetime != Lifetime::Transient {
                    machine.cells_of(part).iter_mut().for_each(|cell| cell.owner = Some(part));
                }
            }
        }
        machine
    }

    /// The parts that a use or a barrier of some levels is about.
    fn parts(&self, resource: usize, levels: Range<u32>) -> Range<usize> {
        let first = self.parts_of[resource].start;
        first + levels.start as usize..first + levels.end as usize
    }

    fn parts_of_use(&self, used: &Use) -> Range<usize> {
        let index = used.resource.index();
        self.parts(index, self.graph.resources()[index].info.levels(used.level))
    }

    /// Cells of a physical part.
    fn cells_of(&mut self, place: usize) -> &mut [Cell] {
        &mut self.cells[self.cells_of[place].clone()]
    }

    /// What is handed over anew, and what changes places.
    fn begin_frame(&mut self, frame: usize) {
        for (index, resource) in self.graph.resources().iter().enumerate() {
            for part in self.parts_of[index].clone() {
                let (layout, cell) = match resource.lifetime {
                    Lifetime::Acquired => (ImageLayout::UNDEFINED, acquired(part)),
                    Lifetime::Continued => (ImageLayout::COLOR_ATTACHMENT_OPTIMAL, continued(part)),
                    Lifetime::Readback => (ImageLayout::UNDEFINED, Cell::default()),
                    Lifetime::Imported => (self.layouts[part], read_anywhere(part)),
                    Lifetime::Current { previous } => {
                        let before = part - self.parts_of[index].start + self.parts_of[previous.index()].start;
                        if frame > 0 {
                            self.places.swap(before, part);
                        }
                        // What it wrote two frames ago means nothing.
                        let place = self.places[part];
                        self.cells_of(place).iter_mut().for_each(|cell| cell.owner = None);
                        continue;
                    }
                    Lifetime::Transient | Lifetime::Persistent | Lifetime::Previous { .. } => continue,
                };
                self.layouts[part] = layout;
                self.cells_of(part).fill(cell);
            }
        }
    }

    /// What other graphs, which have no barriers for it, expect of imported resources.
    fn hand_over(&self) -> Result<(), Hazard> {
        for (index, resource) in self.graph.resources().iter().enumerate() {
            if resource.lifetime != Lifetime::Imported {
                continue;
            }
            for part in self.parts_of[index].clone() {
                if self.layouts[part] != resting_layout(resource) {
                    return Err(("left in another layout than others expect", Some(index)));
                }
                for cell in &self.cells[self.cells_of[part].clone()] {
                    judge(cell, Stage::ALL_COMMANDS, Mask::MEMORY_READ, true, false)
                        .map_err(|what| (what, Some(index)))?;
                }
            }
        }
        Ok(())
    }

    /// Plays one batch of barriers.
    fn batch(&mut self, takeover: Option<&MemoryBarrier>, barriers: &[Barrier]) -> Result<(), Hazard> {
        let ops = self.cells.iter_mut().flat_map(|cell| &mut cell.ops);
        ops.for_each(|op| op.ordered_before = op.ordered);
        if let Some(barrier) = takeover {
            self.cells.iter_mut().for_each(|cell| apply_takeover(barrier, cell));
        }
        for barrier in barriers {
            let index = barrier.resource.index();
            for part in self.parts(index, barrier.levels()) {
                let place = self.places[part];
                let cells = &mut self.cells[self.cells_of[place].clone()];
                apply(barrier, place, &mut self.layouts[place], cells).map_err(|what| (what, Some(index)))?;
            }
        }
        Ok(())
    }

    /// Plays the work of a pass.
    fn run(&mut self, pass: &Pass<P>) -> Result<(), Hazard> {
        for used in &pass.uses {
            for part in self.parts_of_use(used) {
                self.judge_use(used, part).map_err(|what| (what, Some(used.resource.index())))?;
            }
        }
        let mut written: HashSet<usize> = HashSet::new();
        for used in pass.uses.iter().filter(|used| used.access.is_write()) {
            written.extend(self.parts_of_use(used));
        }
        let mut cleared = HashSet::new();
        for used in &pass.uses {
            let scope = used.access.sync(self.graph.resources()[used.resource.index()].info.kind());
            for part in self.parts_of_use(used) {
                let fresh = written.contains(&part) && cleared.insert(part);
                let place = self.places[part];
                for cell in self.cells_of(place) {
                    if fresh {
                        // Every earlier operation is ordered before this write, so it stands for them all.
                        cell.ops.clear();
                        cell.owner = Some(place);
                    }
                    record(cell, place, scope.stages, scope.access, used.access.is_write());
                }
            }
        }
        Ok(())
    }

    fn judge_use(&self, used: &Use, part: usize) -> Result<(), &'static str> {
        let kind = self.graph.resources()[used.resource.index()].info.kind();
        let scope = used.access.sync(kind);
        let place = self.places[part];
        if kind != Kind::Buffer && self.layouts[place] != scope.layout {
            return Err("wrong layout");
        }
        for cell in &self.cells[self.cells_of[place].clone()] {
            if used.access.is_read() && cell.owner != Some(place) {
                return Err("reads contents that are gone");
            }
            judge(cell, scope.stages, scope.access, used.access.is_read(), used.access.is_write())?;
        }
        Ok(())
    }
}

fn parts_of(resources: &[Resource]) -> Vec<Range<usize>> {
    let mut end = 0;
    let parts = resources.iter().map(|resource| {
        let start = end;
        end += resource.info.level_count() as usize;
        start..end
    });
    parts.collect()
}

/// Memory that another queue was using until a semaphore, which is waited for before colours are written.
fn acquired(through: usize) -> Cell {
    let mut cell = Cell::default();
    record(&mut cell, through, Stage::COLOR_ATTACHMENT_OUTPUT, Mask::NONE, false);
    cell
}

/// Contents that every other graph on the queue may have read anywhere, and all see.
fn read_anywhere(owner: usize) -> Cell {
    let mut cell = Cell { ops: Vec::new(), owner: Some(owner) };
    record(&mut cell, owner, Stage::ALL_COMMANDS, Mask::NONE, false);
    cell
}

/// Layout of an imported resource between frames.
fn resting_layout(resource: &Resource) -> ImageLayout {
    match resource.info {
        ResourceInfo::Buffer(_) => ImageLayout::UNDEFINED,
        ResourceInfo::Image(_) => ImageLayout::SHADER_READ_ONLY_OPTIMAL,
    }
}

/// Memory that another graph on the same queue has drawn to.
fn continued(owner: usize) -> Cell {
    let (stage, write) = (Stage::COLOR_ATTACHMENT_OUTPUT, Mask::COLOR_ATTACHMENT_WRITE);
    let mut cell = Cell { ops: Vec::new(), owner: Some(owner) };
    record(&mut cell, owner, stage, write, true);
    cell
}

fn cut(parts_of: &[Range<usize>], placed: Placed<'_>) -> (Vec<Range<usize>>, usize) {
    // Memory of each part: the class, and the first and the last byte.
    let block = |index: usize, part: usize| {
        let (alias, requirements) = placed?;
        let placement = alias.placements[index]?;
        let parts = &parts_of[index];
        let end_of = |parts_before: usize| {
            placement.offset_bytes
                + requirements[index].map_or(0, |r| r.size_bytes) * parts_before as u64 / parts.len() as u64
        };
        let before = part - parts.start;
        Some(((placement.class, end_of(before)), (placement.class, end_of(before + 1))))
    };
    let all = || parts_of.iter().enumerate().flat_map(|(index, parts)| parts.clone().map(move |part| (index, part)));
    let mut cuts: Vec<(u32, u64)> =
        all().filter_map(|(index, part)| block(index, part)).flat_map(|(start, end)| [start, end]).collect();
    cuts.sort_unstable();
    cuts.dedup();
    let position = |cut| cuts.binary_search(&cut).expect("every end of a block is a cut");
    let ranges = all().map(|(index, part)| {
        let private = cuts.len() + part;
        block(index, part).map_or(private..private + 1, |(start, end)| position(start)..position(end))
    });
    let ranges: Vec<_> = ranges.collect();
    (ranges, cuts.len() + parts_of.last().map_or(0, |parts| parts.end))
}

fn apply_takeover(barrier: &MemoryBarrier, cell: &mut Cell) {
    let seen = pairs(barrier.dst_stage, barrier.dst_access);
    for op in &mut cell.ops {
        if reaches(op, barrier.src_stage) {
            op.ordered |= all_of(barrier.dst_stage);
            make_visible(op, barrier.src_stage, barrier.src_access, &seen);
        }
    }
}

fn apply(barrier: &Barrier, through: usize, layout: &mut ImageLayout, cells: &mut [Cell]) -> Result<(), &'static str> {
    let seen = pairs(barrier.dst_stage, barrier.dst_access);
    let transition = barrier.old_layout != barrier.new_layout;
    if transition {
        if barrier.old_layout != ImageLayout::UNDEFINED && barrier.old_layout != *layout {
            return Err("transition from a layout the image is not in");
        }
        *layout = barrier.new_layout;
    }
    let ordered = all_of(barrier.dst_stage);
    for cell in cells {
        for op in &mut cell.ops {
            if !reaches(op, barrier.src_stage) {
                if transition {
                    return Err("transition not ordered after an earlier use");
                }
                continue;
            }
            op.ordered |= ordered;
            if op.through == through {
                make_visible(op, barrier.src_stage, barrier.src_access, &seen);
            }
            if transition && op.write != 0 && !op.available {
                return Err("transition of contents not made available");
            }
        }
        if transition {
            if barrier.old_layout == ImageLayout::UNDEFINED {
                cell.owner = None;
            }
            let visible = seen.clone();
            let (write, available) = (u64::MAX, true);
            cell.ops = vec![Op { through, stage: 0, write, ordered, ordered_before: 0, available, visible }];
        }
    }
    Ok(())
}

/// Whether the source stages of a barrier cover an operation, itself or by an earlier barrier.
fn reaches(op: &Op, src: Stage) -> bool {
    (op.stage | op.ordered_before) & all_of(src) != 0
}

fn make_visible(op: &mut Op, src: Stage, access: Mask, seen: &HashSet<(u64, u64)>) {
    op.available |= op.stage & all_of(src) != 0 && op.write & access.as_raw() != 0;
    if op.write != 0 && op.available {
        op.visible.extend(seen);
    }
}

fn judge(cell: &Cell, stages: Stage, access: Mask, reads: bool, writes: bool) -> Result<(), &'static str> {
    let stages_raw = stages.as_raw();
    let reading = if reads { pairs(stages, access) } else { HashSet::new() };
    for op in cell.ops.iter().filter(|op| writes || op.write != 0) {
        if op.ordered & stages_raw != stages_raw {
            return Err("not ordered after an earlier use");
        }
        if op.write != 0 && !op.available {
            return Err("earlier write not available");
        }
        // A barrier for all reads of all commands leaves nothing to be made visible.
        let everything = op.visible.contains(&(Stage::ALL_COMMANDS.as_raw(), Mask::MEMORY_READ.as_raw()));
        let mut read = reading.iter().filter(|&&(_, mask)| mask & writing() == 0);
        if reads && op.write != 0 && !everything && !read.all(|pair| op.visible.contains(pair)) {
            return Err("earlier write not visible");
        }
    }
    Ok(())
}

fn record(cell: &mut Cell, through: usize, stages: Stage, access: Mask, write: bool) {
    let write = if write { access.as_raw() & writing() } else { 0 };
    for stage in bits(stages.as_raw()) {
        let visible = HashSet::new();
        cell.ops.push(Op { through, stage, write, ordered: 0, ordered_before: 0, available: false, visible });
    }
}

/// The stages that a barrier names: one of all commands names every single one.
fn all_of(stages: Stage) -> u64 {
    if stages.contains(Stage::ALL_COMMANDS) { u64::MAX } else { stages.as_raw() }
}

fn writing() -> u64 {
    (Mask::SHADER_STORAGE_WRITE
        | Mask::COLOR_ATTACHMENT_WRITE
        | Mask::DEPTH_STENCIL_ATTACHMENT_WRITE
        | Mask::ACCELERATION_STRUCTURE_WRITE_KHR
        | Mask::TRANSFER_WRITE)
        .as_raw()
}

fn bits(raw: u64) -> impl Iterator<Item = u64> {
    (0..64).map(|bit| 1 << bit).filter(move |bit| raw & bit != 0)
}

/// Stage and access pairs; depth accesses belong to the depth tests, sampling to shaders, the rest to any stage.
fn pairs(stages: Stage, access: Mask) -> HashSet<(u64, u64)> {
    let tests = (Stage::EARLY_FRAGMENT_TESTS | Stage::LATE_FRAGMENT_TESTS).as_raw();
    let depth = (Mask::DEPTH_STENCIL_ATTACHMENT_READ | Mask::DEPTH_STENCIL_ATTACHMENT_WRITE).as_raw();
    bits(stages.as_raw())
        .flat_map(|stage| bits(access.as_raw()).map(move |mask| (stage, mask)))
        .filter(|(stage, mask)| (stage & tests != 0) == (mask & depth != 0))
        .collect()
}
