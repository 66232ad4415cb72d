//! An independent judge of plans: plays frames through Vulkan's memory model and reports the first hazard.
//!
//! Memory is cut into cells at the ends of placed resources, so that resources sharing memory share cells. A cell
//! remembers past operations. A barrier on a resource works on the cells of that resource: operations in its source
//! scope (or already ordered before a stage in it) become ordered before its destination stages; their writes become
//! available if the access is named, and available writes become visible to the destination. A layout transition is
//! itself a write that is available at once.

use std::collections::HashSet;
use std::ops::Range;

use ash::vk::{AccessFlags2 as Mask, ImageLayout, PipelineStageFlags2 as Stage};
use gridlight::graph::{AliasPlan, Barrier, Graph, Handle, Kind, Lifetime, Plan, Requirement};

#[derive(Clone, Debug)]
struct Op {
    stage: u64,
    /// 0 for reads.
    write: u64,
    ordered: u64,
    available: bool,
    visible: HashSet<(u64, u64)>,
}

#[derive(Clone, Debug, Default)]
struct Cell {
    ops: Vec<Op>,
    /// Which resource's contents the cell holds.
    owner: Option<usize>,
}

/// Plays three frames in a row; the text of an error says what went wrong where.
pub fn check<P>(
    graph: &Graph<P>,
    plan: &Plan,
    placed: Option<(&AliasPlan, &[Option<Requirement>])>,
) -> Result<(), String> {
    let (cells_of, count) = cut(graph.resources().len(), placed);
    let mut cells = vec![Cell::default(); count];
    let mut layouts = vec![ImageLayout::UNDEFINED; graph.resources().len()];
    for &(image, layout) in &plan.initial {
        layouts[Handle::from(image).index()] = layout;
    }
    for (index, resource) in graph.resources().iter().enumerate() {
        if resource.lifetime != Lifetime::Transient {
            cells[cells_of[index].clone()].iter_mut().for_each(|cell| cell.owner = Some(index));
        }
    }
    for frame in 0..3 {
        for (index, resource) in graph.resources().iter().enumerate() {
            let cells = &mut cells[cells_of[index].clone()];
            match resource.lifetime {
                Lifetime::Acquired => {
                    layouts[index] = ImageLayout::UNDEFINED;
                    cells.iter_mut().for_each(|cell| *cell = acquired());
                }
                Lifetime::Continued => {
                    layouts[index] = ImageLayout::COLOR_ATTACHMENT_OPTIMAL;
                    cells.iter_mut().for_each(|cell| *cell = continued(index));
                }
                Lifetime::Readback => cells.iter_mut().for_each(|cell| *cell = Cell::default()),
                Lifetime::Transient | Lifetime::Persistent | Lifetime::Imported => {}
            }
        }
        for (pass, planned) in graph.passes().iter().zip(&plan.passes) {
            let context = |what: &str, resource: usize| {
                format!("frame {frame}, pass {}, {}: {what}", pass.name, graph.resources()[resource].name)
            };
            for barrier in &planned.barriers {
                let index = barrier.resource.index();
                let cells = &mut cells[cells_of[index].clone()];
                apply(barrier, &mut layouts[index], cells).map_err(|what| context(what, index))?;
            }
            for used in &pass.uses {
                let index = used.resource.index();
                let kind = graph.resources()[index].info.kind();
                let scope = used.access.sync(kind);
                if kind != Kind::Buffer && layouts[index] != scope.layout {
                    return Err(context("wrong layout", index));
                }
                for cell in &cells[cells_of[index].clone()] {
                    if used.access.is_read() && cell.owner != Some(index) {
                        return Err(context("reads contents that are gone", index));
                    }
                    judge(cell, scope.stages, scope.access, used.access.is_read(), used.access.is_write())
                        .map_err(|what| context(what, index))?;
                }
            }
            let writes = |index: usize| pass.uses.iter().any(|u| u.resource.index() == index && u.access.is_write());
            let mut cleared = HashSet::new();
            for used in &pass.uses {
                let index = used.resource.index();
                let scope = used.access.sync(graph.resources()[index].info.kind());
                let fresh = writes(index) && cleared.insert(index);
                for cell in &mut cells[cells_of[index].clone()] {
                    if fresh {
                        // Every earlier operation is ordered before this write, so it stands for them all.
                        cell.ops.clear();
                        cell.owner = Some(index);
                    }
                    record(cell, scope.stages, scope.access, used.access.is_write());
                }
            }
        }
    }
    Ok(())
}

/// Memory that another queue was using until a semaphore, which is waited for before colours are written.
fn acquired() -> Cell {
    let stage = Stage::COLOR_ATTACHMENT_OUTPUT.as_raw();
    let waited = Op { stage, write: 0, ordered: 0, available: true, visible: HashSet::new() };
    Cell { ops: vec![waited], owner: None }
}

/// Memory that another graph on the same queue has drawn to.
fn continued(owner: usize) -> Cell {
    let (stage, write) = (Stage::COLOR_ATTACHMENT_OUTPUT, Mask::COLOR_ATTACHMENT_WRITE);
    let mut cell = Cell { ops: Vec::new(), owner: Some(owner) };
    record(&mut cell, stage, write, true);
    cell
}

fn cut(resources: usize, placed: Option<(&AliasPlan, &[Option<Requirement>])>) -> (Vec<Range<usize>>, usize) {
    let block = |index: usize| {
        let (alias, requirements) = placed?;
        let placement = alias.placements[index]?;
        let start = (placement.class, placement.offset_bytes);
        Some((start, (placement.class, placement.offset_bytes + requirements[index]?.size_bytes)))
    };
    let mut cuts: Vec<(u32, u64)> = (0..resources).filter_map(block).flat_map(|(start, end)| [start, end]).collect();
    cuts.sort_unstable();
    cuts.dedup();
    let position = |cut| cuts.binary_search(&cut).expect("every end of a block is a cut");
    let ranges = (0..resources)
        .map(|index| {
            let private = cuts.len() + index;
            block(index).map_or(private..private + 1, |(start, end)| position(start)..position(end))
        })
        .collect();
    (ranges, cuts.len() + resources)
}

fn apply(barrier: &Barrier, layout: &mut ImageLayout, cells: &mut [Cell]) -> Result<(), &'static str> {
    let (src, dst) = (barrier.src_stage.as_raw(), barrier.dst_stage.as_raw());
    let seen = pairs(barrier.dst_stage, barrier.dst_access);
    let transition = barrier.old_layout != barrier.new_layout;
    if transition {
        if barrier.old_layout != ImageLayout::UNDEFINED && barrier.old_layout != *layout {
            return Err("transition from a layout the image is not in");
        }
        *layout = barrier.new_layout;
    }
    for cell in cells {
        for op in &mut cell.ops {
            let covered = (op.stage | op.ordered) & src != 0;
            if transition && !covered {
                return Err("transition not ordered after an earlier use");
            }
            if !covered {
                continue;
            }
            op.available |= op.stage & src != 0 && op.write & barrier.src_access.as_raw() != 0;
            op.ordered |= dst;
            if op.write != 0 && op.available {
                op.visible.extend(&seen);
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
            cell.ops = vec![Op { stage: 0, write: u64::MAX, ordered: dst, available: true, visible }];
        }
    }
    Ok(())
}

fn judge(cell: &Cell, stages: Stage, access: Mask, reads: bool, writes: bool) -> Result<(), &'static str> {
    let stages_raw = stages.as_raw();
    for op in cell.ops.iter().filter(|op| writes || op.write != 0) {
        if op.ordered & stages_raw != stages_raw {
            return Err("not ordered after an earlier use");
        }
        if op.write != 0 && !op.available {
            return Err("earlier write not available");
        }
        let mut read = pairs(stages, access).into_iter().filter(|&(_, mask)| mask & writing() == 0);
        if reads && op.write != 0 && !read.all(|pair| op.visible.contains(&pair)) {
            return Err("earlier write not visible");
        }
    }
    Ok(())
}

fn record(cell: &mut Cell, stages: Stage, access: Mask, write: bool) {
    let write = if write { access.as_raw() & writing() } else { 0 };
    for stage in bits(stages.as_raw()) {
        cell.ops.push(Op { stage, write, ordered: 0, available: false, visible: HashSet::new() });
    }
}

fn writing() -> u64 {
    (Mask::SHADER_STORAGE_WRITE
        | Mask::COLOR_ATTACHMENT_WRITE
        | Mask::DEPTH_STENCIL_ATTACHMENT_WRITE
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
