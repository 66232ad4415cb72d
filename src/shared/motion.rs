//! Structs that the passes which move a scene read and write (`passes::motion`, `passes::refit`), declared as those of
//! [`structs`](super::structs).

use std::mem::offset_of;

use bytemuck::{Pod, Zeroable};

use super::table::{FieldInfo, FieldType, SharedStruct, StructInfo, shared_structs};

shared_structs! {
    /// A mesh that moves (`scene::motion::device`).
    pub struct MovingBody as "MovingBody" {
        /// First of its vertices in the scene.
        pub first_vertex: u32,
        /// First of its vertices among those that move.
        pub first_rest: u32,
        /// Where in the pose its matrix begins, or that of its skin's first joint.
        pub first_matrix: u32,
        /// Where in the pose the weights of its morph targets begin.
        pub first_weight: u32,
        /// Joints that each vertex follows; 0 where a node carries it.
        pub joints_per_vertex: u32,
        /// `BODY_IS_TURNED`, `BODY_HAS_TANGENTS`, `BODY_IS_FLAT`.
        pub flags: u32,
        /// Unused.
        pub padding: [u32; 2],
    }

    /// A vertex that moves, as it is in mesh space.
    pub struct RestVertex as "RestVertex" {
        /// Where it is.
        pub position: [f32; 3],
        /// The body it belongs to.
        pub body: u32,
        /// Its normal; 0 where it has that of its triangle.
        pub normal: [f32; 3],
        /// First of its morph offsets; those of the next vertex follow.
        pub first_offset: u32,
        /// Its tangent, with the side of the bitangent in w.
        pub tangent: [f32; 4],
        /// A triangle at it, by corners among the vertices that move.
        pub corners: [u32; 3],
        /// First of its joint weights.
        pub first_joint: u32,
    }

    /// How much of a vertex follows a joint.
    pub struct JointWeight as "JointWeight" {
        /// Which of its skin's joints.
        pub joint: u32,
        /// Those of a vertex add up to 1.
        pub weight: f32,
    }

    /// What a morph target adds to a vertex.
    pub struct MorphOffset as "MorphOffset" {
        /// To its position.
        pub position: [f32; 3],
        /// Which of its body's targets.
        pub target: u32,
        /// To its normal.
        pub normal: [f32; 3],
        /// Unused.
        pub padding: u32,
        /// To its tangent.
        pub tangent: [f32; 3],
        /// Unused.
        pub padding_1: u32,
    }

    /// The box around all triangles below a node of the BVH.
    pub struct NodeBox as "NodeBox" {
        /// Smallest corner.
        pub min: [f32; 3],
        /// What its children cost rays: areas of boxes, halves of them.
        pub cost: f32,
        /// Largest corner.
        pub max: [f32; 3],
        /// Unused.
        pub padding: u32,
    }

    /// What is to be known of a tree whose triangles have moved.
    pub struct MovedTree as "MovedTree" {
        /// Longest edge of the bounding box of any triangle that moves, as bits.
        pub largest_triangle: u32,
        /// What the tree costs rays, over the area of its root.
        pub cost: f32,
    }
}
