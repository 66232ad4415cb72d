//! How many passes the loops of one invocation may take: the reproducer to what `docs/porting.md` says of lavapipe.

mod common;

use bytemuck::Zeroable;
use common::written::Written;
use gridlight::gpu::{ComputeWork, Executor, Work};
use gridlight::graph::{Access, Graph, Pass};
use gridlight::passes::{shader, threads};
use gridlight::shared::FrameData;

/// Passes of all loops of an invocation together on lavapipe 22.3, the one included with which each of them ends.
const LAVAPIPE_PASSES: u32 = 65_535;

/// The passes that two loops after each other took, which are asked for so many.
fn passes(gpu: &common::GpuTest, asked: [u32; 2]) -> [u32; 2] {
    let mut graph = Graph::new();
    let counts = graph.persistent_buffer("counts", 8);
    let work = ComputeWork { push: asked.to_vec(), ..shader("tests/count_passes", threads(1)) };
    graph.add_pass(Pass::new("count", Work::Compute(work)).bind("counts", counts, Access::ComputeWrite));
    let executor = Executor::new(&gpu.gpu, graph, None).unwrap();
    let found: Vec<u32> = Written::by_graph(&executor, &FrameData::zeroed()).all("count", "counts");
    [found[0], found[1]]
}

/// What lavapipe 22.3 leaves of two loops.
fn ended_early([first, second]: [u32; 2]) -> [u32; 2] {
    let found = first.min(LAVAPIPE_PASSES - 1);
    [found, second.min((LAVAPIPE_PASSES - 1).saturating_sub(found + 1))]
}

#[test]
fn loops_within_the_limit_are_whole_and_longer_ones_end_as_documented() {
    let gpu = common::gpu();
    for asked in [[0, 0], [1, 2], [30_000, 30_000], [10, 65_000]] {
        assert_eq!(passes(&gpu, asked), asked);
        assert_eq!(ended_early(asked), asked);
    }
    for asked in [[70_000, 10], [40_000, 40_000], [65_534, 1]] {
        let found = passes(&gpu, asked);
        println!("asked for {asked:?} passes: {found:?}");
        assert!(found == asked || found == ended_early(asked), "{asked:?} became {found:?}");
        assert_ne!(ended_early(asked), asked);
    }
}
