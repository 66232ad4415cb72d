//! `readback`: what the host learns of every frame of a window, without a wait.

use super::FrameOutputs;
use crate::gpu::{TransferOp, Work};
use crate::graph::{Access, BufferHandle, Graph, Handle, Pass, ResourceInfo};

/// Where in a frame's readback each part is, in bytes.
#[derive(Clone, Copy, Debug)]
pub struct Readback {
    /// One float: the exposure, or the upper end of a view's scale.
    pub exposure: usize,
    /// Two words: rays of light paths, shadow rays.
    pub ray_count: usize,
    /// Four words: all lights of S0, the VPLs among them, ...
    pub light_counts: Option<usize>,
    /// Two words for each level from 0 on: where its lights begin, how many they are.
    pub level_table: Option<usize>,
    /// An [`InspectedPixel`](crate::shared::InspectedPixel).
    pub inspected: Option<usize>,
}

/// Adds the passes.
pub fn add(graph: &mut Graph<Work>, outputs: &FrameOutputs) -> Readback {
    let mut copies: Vec<(BufferHandle, u64)> = Vec::new();
    let mut end = 0;
    let mut copy = |graph: &Graph<Work>, from: BufferHandle| {
        let offset = end;
        copies.push((from, offset));
        end += size_bytes(graph, from);
        offset as usize
    };
    let hierarchy = outputs.hierarchy.as_ref();
    let layout = Readback {
        exposure: copy(graph, outputs.tone_mapped.exposure),
        ray_count: copy(graph, outputs.ray_count),
        light_counts: hierarchy.map(|h| copy(graph, h.lights.counts)),
        level_table: hierarchy.map(|h| copy(graph, h.grid.level_table)),
        inspected: outputs.inspected.map(|inspected| copy(graph, inspected)),
    };
    let to = graph.readback_buffer("readback", end);
    let ops =
        copies.iter().map(|(from, offset_bytes)| TransferOp::Copy { from: *from, to, offset_bytes: *offset_bytes });
    let pass = Pass::new("readback", Work::Transfer(ops.collect())).uses(to, Access::TransferWrite);
    graph.add_pass(copies.iter().fold(pass, |pass, (from, _)| pass.uses(*from, Access::TransferRead)));
    graph.add_pass(Pass::new("readback/to_host", Work::Transfer(Vec::new())).uses(to, Access::HostRead));
    layout
}

fn size_bytes(graph: &Graph<Work>, buffer: BufferHandle) -> u64 {
    match graph.resources()[Handle::from(buffer).index()].info {
        ResourceInfo::Buffer(info) => info.size_bytes,
        ResourceInfo::Image(_) => 0,
    }
}
