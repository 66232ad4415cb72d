//! A frame run pass by pass, with what every pass wrote read back: how dumps are made.
//!
//! Transient resources share memory, so that after the frame most of them are gone; right after its pass each is
//! there, and an image is in the layout that the pass used it in.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::buffer::Buffer;
use super::device::Device;
use super::executor::Executor;
use super::physical::Physical;
use super::runner::Policy;
use super::scene_set::SceneSet;
use super::transfer;
use super::work::{TransferOp, Work};
use crate::error::Result;
use crate::graph::{Access, Handle, Lifetime, ResourceInfo, Use};

/// What one resource held right after a pass that wrote to it.
#[derive(Clone, Debug)]
pub struct Written {
    /// Position in the graph's resource list.
    pub resource: usize,
    /// Which level of an image.
    pub level: u32,
    /// The whole buffer, or the level's texels: rows, slices and layers packed.
    pub bytes: Vec<u8>,
}

/// The scene's buffers as shaders read them; a short one is padded to 64 bytes.
#[derive(Clone, Debug)]
pub struct SceneBytes {
    /// Scene vertices.
    pub vertices: Vec<u8>,
    /// Packed tangents of the vertices up to the last that has one; a word where there are none.
    pub tangents: Vec<u8>,
    /// `BvhNode`s.
    pub nodes: Vec<u8>,
    /// `BvhTriangle`s in leaf order.
    pub triangles: Vec<u8>,
    /// `GpuMaterial`s.
    pub materials: Vec<u8>,
    /// `PunctualLight`s, directional and spot lights first.
    pub lights: Vec<u8>,
}

impl Executor {
    /// What the last frame has read of the one before it: all of its history that some pass uses. Call it before
    /// [`Self::run_and_read`].
    ///
    /// # Errors
    /// When the device is lost or has no memory.
    pub fn read_history(&self) -> Result<Vec<Written>> {
        self.gpu.wait_idle()?;
        let resources = self.frame.graph.resources();
        let uses = self.frame.graph.passes().iter().flat_map(|pass| &pass.uses);
        // Of several uses the last one, which has left it in its layout.
        let of_history =
            uses.filter(|used| matches!(resources[used.resource.index()].lifetime, Lifetime::Previous { .. }));
        let last_uses: BTreeMap<usize, Use> = of_history.map(|used| (used.resource.index(), *used)).collect();
        let levels = last_uses
            .into_values()
            .flat_map(|used| resources[used.resource.index()].info.levels(used.level).map(move |level| (used, level)));
        levels.map(|(used, level)| self.read_after(used, level)).collect()
    }

    /// Runs the last frame once more, pass by pass, each waited for, and gives `visit` every pass's index with what it
    /// wrote. Pairs of its history keep their places, so that it writes what it wrote before.
    /// Buffers that a pass only clears for a later one are left out.
    ///
    /// # Errors
    /// When the device is lost or has no memory, and those of `visit`.
    pub fn run_and_read(
        &self,
        frame_data: &[u8],
        mut visit: impl FnMut(usize, Vec<Written>) -> Result<()>,
    ) -> Result<()> {
        self.gpu.wait_idle()?;
        self.frame.rewind_history()?;
        let mut read = |index| {
            let written = self.shown_after(index).into_iter().map(|(used, level)| self.read_after(used, level));
            visit(index, written.collect::<Result<_>>()?)
        };
        self.run(0, frame_data, Policy::PassByPass { visit: &mut read }).map(drop)
    }

    /// The uses of a pass whose contents tell something, with each level of what they use: what it writes, but of what it
    /// clears only that which no later pass writes, and no image that the next pass goes on with.
    fn shown_after(&self, index: usize) -> Vec<(Use, u32)> {
        let passes = self.frame.graph.passes();
        let pass = &passes[index];
        let written_later =
            |resource: Handle| passes[index + 1..].iter().flat_map(|p| &p.uses).any(|u| writes(u, resource));
        let only_cleared = |resource: Handle| match &pass.payload {
            Work::Transfer(ops) => {
                ops.iter().any(|op| matches!(op, TransferOp::Fill { buffer, .. } if Handle::from(*buffer) == resource))
            }
            _ => false,
        };
        // New lights of the scene come between frames, and a dump has the scene's parts apart.
        let is_scene_update = |resource: Handle| match &pass.payload {
            Work::Transfer(ops) => ops
                .iter()
                .any(|op| matches!(op, TransferOp::SceneLights { buffer } if Handle::from(*buffer) == resource)),
            _ => false,
        };
        let continued = |resource: Handle| {
            let image = matches!(self.frame.graph.resources()[resource.index()].info, ResourceInfo::Image(_));
            let mut next = passes.get(index + 1).into_iter().flat_map(|p| &p.uses);
            image && next.any(|u| u.resource == resource && u.access == Access::ComputeReadWrite)
        };
        let mut shown: Vec<(Use, u32)> = Vec::new();
        for used in pass.uses.iter().filter(|used| used.access.is_write()) {
            let tells_nothing = only_cleared(used.resource) && written_later(used.resource)
                || continued(used.resource)
                || is_scene_update(used.resource);
            let levels = self.frame.graph.resources()[used.resource.index()].info.levels(used.level);
            for level in levels.filter(|_| !tells_nothing) {
                let known = |(other, at): &(Use, u32)| other.resource == used.resource && *at == level;
                if !shown.iter().any(known) {
                    shown.push((*used, level));
                }
            }
        }
        shown
    }

    fn read_after(&self, used: Use, level: u32) -> Result<Written> {
        let resource = used.resource.index();
        let bytes = match self.frame.resources.list[resource] {
            Physical::Buffer { raw, size_bytes } => transfer::download_buffer(&self.gpu, raw, size_bytes)?,
            Physical::Image { raw, info, .. } => {
                let layout = used.access.sync(self.frame.graph.resources()[resource].info.kind()).layout;
                transfer::download_image(&self.gpu, raw, &info, level, layout)?
            }
        };
        Ok(Written { resource, level, bytes })
    }
}

fn writes(used: &Use, resource: Handle) -> bool {
    used.resource == resource && used.access.is_write()
}

impl SceneSet {
    /// Reads them back; waits.
    ///
    /// # Errors
    /// When the device is lost or has no memory.
    pub fn read_back(&self, gpu: &Arc<Device>) -> Result<SceneBytes> {
        let read = |buffer: &Buffer| transfer::download_buffer(gpu, buffer.raw, buffer.size_bytes);
        let [materials, lights] = &self.buffers;
        Ok(SceneBytes {
            vertices: read(&self.vertices)?,
            tangents: read(&self.tangents)?,
            nodes: self.nodes.read_back(gpu)?,
            triangles: self.triangles.read_back(gpu)?,
            materials: read(materials)?,
            lights: read(lights)?,
        })
    }
}
