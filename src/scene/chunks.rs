//! Runs of triangles with their bounds, so that a frame draws only those that may be in sight.

use glam::{Mat4, Vec3, Vec4};

use super::{Aabb, Draw, Material, Scene};

/// Triangles of a run: few enough that runs out of sight are many, enough that testing one is little beside drawing it.
const CHUNK_TRIANGLES: u32 = 128;
/// How far out of sight a run must be, in its distance: more than rounding.
const MARGIN: f32 = 1e-3;

/// What a pipeline has to do for a material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Surfaces {
    /// One or no texture, and nothing cut out.
    Plain,
    /// All that a material can have: normal maps, vertex colours, cut-outs.
    Detailed,
}

impl Surfaces {
    /// Those that a material needs.
    fn of(material: &Material) -> Self {
        let is_plain =
            material.normal_texture.is_none() && !material.has_vertex_colors && material.alpha_cutoff.is_none();
        if is_plain { Self::Plain } else { Self::Detailed }
    }
}

/// A run of indices with one material, and what they enclose.
#[derive(Clone, Debug, PartialEq)]
pub struct Chunk {
    /// The run.
    pub draw: Draw,
    /// What its material needs.
    pub surfaces: Surfaces,
    /// Bounds of its vertices in world space.
    pub bounds: Aabb,
}

/// All draws of a scene in short runs, in their order.
#[must_use]
pub fn chunks(scene: &Scene) -> Vec<Chunk> {
    let moves = scene.motion.moving_vertices(scene.vertices.len());
    let bounds = |draw: &Draw| {
        let indices = &scene.indices[draw.first_index as usize..][..draw.index_count as usize];
        if indices.iter().any(|index| moves[*index as usize]) {
            // Wherever it goes, it is among what the scene's bounds enclose.
            return scene.bounds;
        }
        let empty = Aabb { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };
        indices
            .iter()
            .map(|index| Vec3::from_array(scene.vertices[*index as usize].position_ws))
            .fold(empty, |all, at| Aabb { min: all.min.min(at), max: all.max.max(at) })
    };
    let surfaces = |draw: &Draw| Surfaces::of(&scene.materials[draw.material as usize]);
    let chunk = |draw| Chunk { bounds: bounds(&draw), surfaces: surfaces(&draw), draw };
    scene.draws.iter().flat_map(parts).map(chunk).collect()
}

fn parts(draw: &Draw) -> impl Iterator<Item = Draw> {
    let Draw { first_index, index_count, material } = *draw;
    let step = 3 * CHUNK_TRIANGLES;
    let part =
        move |start| Draw { first_index: first_index + start, index_count: step.min(index_count - start), material };
    (0..index_count).step_by(step as usize).map(part)
}

/// What of the runs of some surfaces may be in sight, in their order: neighbours are one draw again. The near plane is where
/// clip space has z = w, and there is no far one.
pub fn in_sight(chunks: &[Chunk], surfaces: Surfaces, clip_from_world: &Mat4) -> Vec<Draw> {
    let mut draws: Vec<Draw> = Vec::new();
    let is_drawn = |chunk: &&Chunk| chunk.surfaces == surfaces && may_be_in_sight(&chunk.bounds, clip_from_world);
    for Chunk { draw, .. } in chunks.iter().filter(is_drawn) {
        match draws.last_mut() {
            Some(last) if follows(last, draw) => last.index_count += draw.index_count,
            _ => draws.push(*draw),
        }
    }
    draws
}

fn follows(before: &Draw, draw: &Draw) -> bool {
    before.material == draw.material && before.first_index + before.index_count == draw.first_index
}

/// False only where all of a box lies beyond one of the planes that bound what is in sight.
fn may_be_in_sight(bounds: &Aabb, clip_from_world: &Mat4) -> bool {
    let corner = |i: u32| {
        let pick = |axis: usize| if i >> axis & 1 == 0 { bounds.min[axis] } else { bounds.max[axis] };
        *clip_from_world * Vec3::new(pick(0), pick(1), pick(2)).extend(1.0)
    };
    let corners: [Vec4; 8] = std::array::from_fn(|i| corner(i as u32));
    let beyond = |plane: fn(&Vec4) -> f32| corners.iter().all(|c| plane(c) < -MARGIN * c.abs().max_element());
    let planes: [fn(&Vec4) -> f32; 5] = [|c| c.w + c.x, |c| c.w - c.x, |c| c.w + c.y, |c| c.w - c.y, |c| c.w - c.z];
    !planes.into_iter().any(beyond)
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::*;
    use crate::camera::{self, Camera, View};
    use crate::random::{hash, unit_float};
    use crate::scene::testing::plane;

    /// Small boxes at random places around the origin.
    fn boxes(count: u32) -> Vec<Chunk> {
        let at = |i: u32| 20.0 * Vec3::from_array([0, 1, 2].map(|axis| unit_float(hash(3 * i + axis)) - 0.5));
        let chunk = |i: u32| Chunk {
            draw: Draw { first_index: 3 * i, index_count: 3, material: i % 2 },
            surfaces: if i.is_multiple_of(2) { Surfaces::Plain } else { Surfaces::Detailed },
            bounds: Aabb { min: at(i) - 0.5, max: at(i) + 0.5 },
        };
        (0..count).map(chunk).collect()
    }

    fn clip_from_world(azimuth_rad: f32) -> Mat4 {
        let camera = camera::turned(&plane(1.0).cameras[0], azimuth_rad, 0.3);
        View::new(&Camera { position_ws: Vec3::ZERO, ..camera }, 320, 180, Vec2::ZERO).clip_from_world
    }

    /// Whether any of many points of a box is in the picture.
    fn shows(bounds: &Aabb, clip_from_world: &Mat4) -> bool {
        let inside = |i: u32| {
            let share = Vec3::new((i % 9) as f32, (i / 9 % 9) as f32, (i / 81) as f32) / 8.0;
            let clip = *clip_from_world * (bounds.min + (bounds.max - bounds.min) * share).extend(1.0);
            clip.x.abs() <= clip.w && clip.y.abs() <= clip.w && clip.z <= clip.w
        };
        (0..729).any(inside)
    }

    #[test]
    fn nothing_in_sight_is_left_out_and_most_of_the_rest_is() {
        for turn in 0..8 {
            let clip_from_world = clip_from_world(0.8 * turn as f32);
            let all = boxes(400);
            let both = [Surfaces::Plain, Surfaces::Detailed].map(|surfaces| in_sight(&all, surfaces, &clip_from_world));
            assert!(both.iter().zip(0..).all(|(draws, material)| draws.iter().all(|draw| draw.material == material)));
            let drawn = both.concat();
            let is_drawn = |draw: &Draw| {
                drawn.iter().any(|d| (d.first_index..d.first_index + d.index_count).contains(&draw.first_index))
            };
            let (mut hidden, mut left_out) = (0, 0);
            for Chunk { draw, bounds, .. } in &all {
                if shows(bounds, &clip_from_world) {
                    assert!(is_drawn(draw), "{bounds:?} is in sight");
                } else {
                    hidden += 1;
                    left_out += u32::from(!is_drawn(draw));
                }
            }
            assert!(hidden > 200 && left_out * 4 > hidden * 3, "{left_out} of {hidden} are left out");
        }
    }

    #[test]
    fn runs_are_the_draws_in_their_order() {
        let mut scene = plane(1.0);
        scene.indices = scene.indices.repeat(300);
        let colored = Material { has_vertex_colors: true, ..scene.materials[0].clone() };
        scene.materials.push(colored);
        let count = scene.indices.len() as u32;
        scene.draws = vec![
            Draw { first_index: 0, index_count: 900, material: 0 },
            Draw { first_index: 900, index_count: count - 900, material: 1 },
        ];
        let chunks = chunks(&scene);
        assert!(chunks.iter().all(|chunk| chunk.draw.index_count <= 3 * CHUNK_TRIANGLES));
        assert!(chunks.iter().all(|chunk| chunk.bounds == scene.bounds), "each has all of the plane");
        // Everything is in sight of a matrix that brings it to the middle.
        let middle = Mat4::from_cols(Vec4::ZERO, Vec4::ZERO, Vec4::ZERO, Vec4::new(0.0, 0.0, 0.5, 1.0));
        assert_eq!(in_sight(&chunks, Surfaces::Plain, &middle), scene.draws[..1]);
        assert_eq!(in_sight(&chunks, Surfaces::Detailed, &middle), scene.draws[1..]);
    }
}
