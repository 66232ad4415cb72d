//! Structs that shaders read as texels of four words: nodes and triangles of the bounding volume hierarchy, nodes of the
//! points' tree.

use std::mem::offset_of;

use bytemuck::{Pod, Zeroable};

use super::table::{FieldInfo, FieldType, SharedStruct, StructInfo, shared_structs};

shared_structs! {
    /// One node of the eight-wide tree as obvhs makes it, node 0 the root (Ylitie et al. 2017; here with the children's
    /// lower and upper planes side by side per axis). Bytes of a word are read from the lowest.
    pub struct BvhNode as "BvhNode" {
        /// Origin of the children's quantised planes.
        pub origin: [f32; 3],
        /// Three bytes: biased exponents of the planes' unit per axis; a byte: which children are inner nodes.
        pub exponents_and_inner: u32,
        /// The first inner child; the others follow.
        pub first_child: u32,
        /// The first triangle of the leaves.
        pub first_triangle: u32,
        /// A byte per child: 0 for none; inner `001` and 24 + slot; leaf: triangles in unary, offset of the first.
        pub meta: [u32; 2],
        /// Lower x of eight children, then upper x.
        pub x: [u32; 4],
        /// The same for y.
        pub y: [u32; 4],
        /// The same for z.
        pub z: [u32; 4],
    }

    /// One triangle in the order of the tree.
    pub struct BvhTriangle as "BvhTriangle" {
        /// First corner, world space.
        pub v0: [f32; 3],
        /// Triangle of the scene: its corners are `indices[3 * triangle_index ..]`.
        pub triangle_index: u32,
        /// Second corner minus first.
        pub edge1: [f32; 3],
        /// Index into the scene's materials.
        pub material: u32,
        /// Third corner minus first.
        pub edge2: [f32; 3],
        /// `TRIANGLE_ALPHA_MASKED` or 0.
        pub flags: u32,
    }

    /// One node of the tree of points that stand for the scene's surfaces. What the packed words hold:
    /// `points::Node`, `common/points.glsl`.
    pub struct PackedNode as "PackedNode" {
        /// Mean position of its leaves, world space.
        pub centroid_ws: [f32; 3],
        /// Radius about the centroid that encloses the discs of all its leaves.
        pub radius: f32,
        /// Mean normal, octahedral.
        pub normal_oct: u32,
        /// Area of its leaves.
        pub area: f32,
        /// From the lowest bit: 8 bits length of the mean of its leaves' normals; 8 bits cosine of the widest angle between
        /// one of them and the mean normal; 16 bits half-thickness along the mean normal, over the radius.
        pub spread: u32,
        /// Representative leaf (`POINT_LEAF_MASK`) and flags (`POINT_IS_SOLID`, `POINT_IS_TURNED`).
        pub leaf_and_flags: u32,
    }
}

const _: () = assert!(size_of::<BvhNode>() == 80 && size_of::<BvhTriangle>() == 48 && size_of::<PackedNode>() == 32);
