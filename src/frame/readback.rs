//! `readback`: what the host learns of every frame of a window, without a wait.

use std::ops::Range;

use crate::gpu::{TransferOp, Work};
use crate::graph::{Access, BufferHandle, Graph, Handle, Pass, ResourceInfo};

/// Adds the passes that copy buffers to the host; gives where each is in a frame's readback, in bytes.
pub fn add(graph: &mut Graph<Work>, buffers: &[BufferHandle]) -> Vec<Range<usize>> {
    let sizes: Vec<u64> = buffers.iter().map(|buffer| size_bytes(graph, *buffer)).collect();
    let ends: Vec<u64> = sizes
        .iter()
        .scan(0, |end, size| {
            *end += size;
            Some(*end)
        })
        .collect();
    let to = graph.readback_buffer("readback", ends.last().copied().unwrap_or(0));
    let ranges = ends.iter().zip(&sizes).map(|(end, size)| end - size..*end);
    let ops = buffers.iter().zip(ranges.clone());
    let ops = ops.map(|(from, range)| TransferOp::Copy { from: *from, to, offset_bytes: range.start });
    let pass = Pass::new("readback", Work::Transfer(ops.collect())).uses(to, Access::TransferWrite);
    graph.add_pass(buffers.iter().fold(pass, |pass, from| pass.uses(*from, Access::TransferRead)));
    graph.add_pass(Pass::new("readback/to_host", Work::Transfer(Vec::new())).uses(to, Access::HostRead));
    ranges.map(|range| range.start as usize..range.end as usize).collect()
}

fn size_bytes(graph: &Graph<Work>, buffer: BufferHandle) -> u64 {
    match graph.resources()[Handle::from(buffer).index()].info {
        ResourceInfo::Buffer(info) => info.size_bytes,
        ResourceInfo::Image(_) => 0,
    }
}
