//! Builds the scene's acceleration structures anew, after passes that have moved vertices.

use super::scene::{SceneParts, Walked};
use crate::gpu::{SceneSet, StructureLevel, Work};
use crate::graph::{Access, Graph, Pass};

/// Adds the pass `structures/bottom` over the triangles, and `structures/top` over its new bounds. Adds nothing where rays
/// do not walk through structures.
pub fn add(graph: &mut Graph<Work>, scene: &SceneParts, set: &SceneSet) {
    let Walked::Structures([top, bottom, _]) = scene.walked else { return };
    let mut build = |name: &str, level: StructureLevel| {
        let size_bytes = set.scratch_bytes(level).unwrap_or(1);
        let scratch = graph.transient_buffer(&format!("{}_scratch", level.name().replace(' ', "_")), size_bytes);
        Pass::new(name, Work::BuildStructure { level, scratch }).uses(scratch, Access::StructureScratch)
    };
    let build_bottom = build("structures/bottom", StructureLevel::Bottom)
        .uses(scene.vertices, Access::StructureInput)
        .uses(bottom, Access::StructureBuild);
    let build_top = build("structures/top", StructureLevel::Top)
        .uses(bottom, Access::StructureReference)
        .uses(top, Access::StructureBuild);
    graph.add_pass(build_bottom);
    graph.add_pass(build_top);
}
