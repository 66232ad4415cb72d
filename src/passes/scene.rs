//! The scene as resources of the frame. Shaders reach it through descriptor set 1; what a pass declares here is what
//! it waits for when another pass writes to the scene.

use ash::vk;

use crate::gpu::{ENVIRONMENT_FORMAT, ScenePart, Work};
use crate::graph::{Access, BufferHandle, Graph, ImageHandle, Pass};
use crate::settings::Rays;

/// Four words in a texel.
const WORDS: vk::Format = vk::Format::R32G32B32A32_UINT;

/// The scene's parts, which every frame of every graph shares.
#[derive(Clone, Copy, Debug)]
pub struct SceneParts {
    /// Scene vertices.
    pub vertices: BufferHandle,
    /// Packed tangents of the vertices up to the last that has one.
    pub tangents: BufferHandle,
    /// The vertices of the frame before; `None` where they are the same in all frames, or are not needed.
    pub previous_vertices: Option<BufferHandle>,
    /// Three indices per triangle.
    pub indices: BufferHandle,
    /// `GpuMaterial`s.
    pub materials: BufferHandle,
    /// `PunctualLight`s, directional and spot lights first.
    pub lights: BufferHandle,
    /// `Emitter`s.
    pub emitters: BufferHandle,
    /// Light from all around.
    pub environment: ImageHandle,
    /// What directions of the environment are drawn from.
    pub environment_table: BufferHandle,
    /// BVH triangles in leaf order.
    pub triangles: ImageHandle,
    /// What rays walk through.
    pub walked: Walked,
}

/// What rays walk through to find triangles.
#[derive(Clone, Copy, Debug)]
pub enum Walked {
    /// BVH nodes.
    Bvh(ImageHandle),
    /// The top acceleration structure, the bottom one, and the places of its triangles in the BVH.
    Structures([BufferHandle; 3]),
}

impl SceneParts {
    /// Declares the scene, with what these rays walk through.
    pub fn declare(graph: &mut Graph<Work>, rays: Rays) -> Self {
        let mut buffer = |part: ScenePart| graph.imported_buffer(part.name());
        let [vertices, indices, materials, lights] =
            [ScenePart::Vertices, ScenePart::Indices, ScenePart::Materials, ScenePart::Lights].map(&mut buffer);
        let tangents = buffer(ScenePart::Tangents);
        let emitters = buffer(ScenePart::Emitters);
        let environment_table = buffer(ScenePart::EnvironmentTable);
        let structures = [ScenePart::TopStructure, ScenePart::BottomStructure, ScenePart::StructureTriangles];
        let structures = (rays == Rays::Query).then(|| structures.map(&mut buffer));
        let environment = graph.imported_image(ScenePart::EnvironmentMap.name(), ENVIRONMENT_FORMAT);
        let mut image = |part: ScenePart| graph.imported_image(part.name(), WORDS);
        let triangles = image(ScenePart::Triangles);
        let walked = structures.map_or_else(|| Walked::Bvh(image(ScenePart::Nodes)), Walked::Structures);
        let previous_vertices = None;
        Self {
            vertices,
            tangents,
            previous_vertices,
            indices,
            materials,
            lights,
            emitters,
            environment,
            environment_table,
            triangles,
            walked,
        }
    }

    /// Declares the vertices of the frame before.
    pub fn declare_previous(&mut self, graph: &mut Graph<Work>) -> BufferHandle {
        let part = ScenePart::PreviousVertices.name();
        *self.previous_vertices.get_or_insert_with(|| graph.imported_buffer(part))
    }

    /// Declares the BVH's nodes beside acceleration structures.
    pub fn declare_nodes(&self, graph: &mut Graph<Work>) -> ImageHandle {
        match self.walked {
            Walked::Bvh(nodes) => nodes,
            Walked::Structures(_) => graph.imported_image(ScenePart::Nodes.name(), WORDS),
        }
    }

    /// A compute pass that traces rays, looks at what they hit, and reads the scene's lights and environment.
    #[must_use]
    pub fn read_by(&self, pass: Pass<Work>) -> Pass<Work> {
        let buffers = [self.vertices, self.indices, self.materials, self.lights, self.emitters, self.environment_table];
        let pass = buffers.into_iter().fold(pass, |pass, buffer| pass.uses(buffer, Access::ComputeRead));
        let images = [self.triangles, self.environment];
        let pass = images.into_iter().fold(pass, |pass, image| pass.uses(image, Access::ComputeSampled));
        match self.walked {
            Walked::Bvh(nodes) => pass.uses(nodes, Access::ComputeSampled),
            Walked::Structures([top, bottom, triangles]) => pass
                .uses(top, Access::ComputeTrace)
                .uses(bottom, Access::ComputeTrace)
                .uses(triangles, Access::ComputeRead),
        }
    }

    /// A pass that draws the scene.
    #[must_use]
    pub fn drawn_by(&self, pass: Pass<Work>) -> Pass<Work> {
        pass.uses(self.vertices, Access::VertexBuffer)
            .bind(ScenePart::Tangents.name(), self.tangents, Access::VertexRead)
            .uses(self.indices, Access::IndexBuffer)
            .uses(self.materials, Access::FragmentRead)
    }
}
