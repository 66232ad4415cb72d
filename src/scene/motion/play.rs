//! A scene while its animations play.

use super::clip::MOMENTS_PER_CLIP;
use super::{Motion, Moves};
use crate::scene::gltf_mesh::within_reach;
use crate::scene::{Aabb, Light, Scene};
use crate::{Error, Result};

/// Most keys that bounds are looked at; clips of more keys are sampled at every so many.
const MOST_KEYS: usize = 1024;

impl Scene {
    /// Chooses what plays: a name, an index, `all` or `none`; the first animation when nothing is asked for. What is
    /// constant for a run, the scene's bounds, is then that of all moments.
    ///
    /// # Errors
    /// [`Error::Usage`] when there is no such animation.
    pub fn play(&mut self, wanted: Option<&str>) -> Result<()> {
        let names: Vec<&str> = self.motion.names().collect();
        let index = |name: &str| name.parse::<usize>().ok().filter(|index| *index < names.len());
        let playing = match wanted {
            None => (0..names.len().min(1)).collect(),
            Some("none") => Vec::new(),
            Some("all") => (0..names.len()).collect(),
            Some(name) => match names.iter().position(|known| *known == name).or_else(|| index(name)) {
                Some(index) => vec![index],
                None if names.is_empty() => {
                    return Err(Error::Usage(format!("--animation {name} is not in the scene, which has none")));
                }
                None => {
                    let names = names.join(", ");
                    return Err(Error::Usage(format!(
                        "--animation {name} is not in the scene; its animations are {names}"
                    )));
                }
            },
        };
        self.motion.playing = playing;
        (self.motion.posed_s, self.motion.vertices_s) = (None, None);
        self.motion.brightest = self.motion.brightest_lights();
        if self.motion.moves().geometry {
            self.bounds = self.motion.swept_bounds(self);
        }
        Ok(())
    }

    /// Bounds of the places of all point lights, at all moments; [`Aabb::EMPTY`] without any.
    #[must_use]
    pub fn lamp_bounds(&self) -> Aabb {
        let place = |light: &Light| match light {
            Light::Point { position_ws, .. } => Some(*position_ws),
            _ => None,
        };
        let standing = self.lights.iter().filter_map(place).fold(Aabb::EMPTY, |all, place| all.with(place));
        let motion = &self.motion;
        if !motion.moves().lights {
            return standing;
        }
        motion.moments_s().into_iter().fold(standing, |all, time_s| {
            let posed = motion.hierarchy.pose(motion.playing_clips(), time_s);
            let carried = motion.lights.iter().map(|carried| carried.at_rest.carried_to(&posed.worlds[carried.node]));
            carried.filter_map(|light| place(&light)).fold(all, |all, place| all.with(place))
        })
    }

    /// Puts everything that moves where it is at a moment.
    pub fn pose(&mut self, time_s: f64) {
        self.pose_without_vertices(time_s);
        self.pose_vertices();
    }

    /// Puts vertices, which may be behind, where they are at the moment that everything else is at.
    pub fn pose_vertices(&mut self) {
        let motion = &self.motion;
        if motion.vertices_s == motion.posed_s {
            return;
        }
        let posed = motion.posed();
        for body in motion.moving_bodies() {
            body.pose(&posed, &motion.skins, &mut self.vertices, &mut self.tangents);
        }
        self.motion.vertices_s = self.motion.posed_s;
    }

    /// Puts cameras and lights that move where they are at a moment, and leaves vertices to a device ([`super::MovingMeshes`]).
    pub fn pose_without_vertices(&mut self, time_s: f64) {
        if !self.motion.moves().any() {
            return;
        }
        self.motion.posed_s = Some(time_s);
        let motion = &self.motion;
        let posed = motion.posed();
        let moved = motion.moved_by(motion.playing_clips());
        let (lamps, lenses) = (motion.lamps_at(time_s), motion.fields_of_view_at(time_s));
        for (camera, carried) in self.cameras.iter_mut().zip(&motion.cameras) {
            if moved[carried.node] {
                *camera = carried.at_rest.carried_to(&posed.worlds[carried.node]);
            }
            if let Some(yfov_rad) = lenses.get(&carried.index) {
                camera.yfov_rad = *yfov_rad;
            }
        }
        let changes = motion.changing_lamps();
        for (light, carried) in self.lights.iter_mut().zip(&motion.lights) {
            if moved[carried.node] || changes.contains(&carried.index) {
                *light = motion.light_at(carried, &posed, &lamps);
            }
        }
    }
}

impl Motion {
    /// What moves while the chosen clips play.
    #[must_use]
    pub fn moves(&self) -> Moves {
        let moved = self.moved_by(self.playing_clips());
        let (lamps, lenses) = (self.changing_lamps(), self.fields_of_view_at(0.0));
        Moves {
            geometry: self.bodies.iter().any(|body| self.body_moves(body, &moved)),
            lights: self.lights.iter().any(|light| moved[light.node] || lamps.contains(&light.index)),
            cameras: self.cameras.iter().any(|camera| moved[camera.node] || lenses.contains_key(&camera.index)),
        }
    }

    /// Whether a light of the scene moves or changes while the chosen clips play.
    #[must_use]
    pub fn moves_light(&self, index: usize) -> bool {
        let moved = self.moved_by(self.playing_clips());
        self.lights.get(index).is_some_and(|light| moved[light.node] || self.changing_lamps().contains(&light.index))
    }

    pub(super) fn moving_bodies(&self) -> Vec<&super::Body> {
        let moved = self.moved_by(self.playing_clips());
        self.bodies.iter().filter(|body| self.body_moves(body, &moved)).collect()
    }

    /// Which of a scene's vertices move.
    #[must_use]
    pub fn moving_vertices(&self, count: usize) -> Vec<bool> {
        let mut moves = vec![false; count];
        for body in self.moving_bodies() {
            moves[body.first_vertex..body.first_vertex + body.vertex_count()].fill(true);
        }
        moves
    }

    /// Bounds of all vertices that triangles use at all moments.
    fn swept_bounds(&self, scene: &Scene) -> Aabb {
        let moving = self.moving_bodies();
        let moves = self.moving_vertices(scene.vertices.len());
        let standing = scene.indices.iter().map(|index| *index as usize).filter(|index| !moves[*index]);
        let mut bounds = standing.fold(Aabb::EMPTY, |all, index| all.with(scene.vertices[index].position_ws.into()));
        for time_s in self.moments_s() {
            let posed = self.hierarchy.pose(self.playing_clips(), time_s);
            bounds = moving.iter().fold(bounds, |all, body| all.union(&body.bounds(&posed, &self.skins)));
        }
        Aabb { min: within_reach(bounds.min), max: within_reach(bounds.max) }
    }

    /// The moments that stand for all of the clips that play: keys, and some between.
    fn moments_s(&self) -> Vec<f64> {
        let samplers = self.playing_clips().flat_map(|clip| &clip.channels).map(|channel| &channel.sampler);
        let mut keys_s: Vec<f32> = samplers.flat_map(|sampler| sampler.times_s()).copied().collect();
        keys_s.sort_by(f32::total_cmp);
        keys_s.dedup();
        let every = keys_s.len().div_ceil(MOST_KEYS).max(1);
        let keys = keys_s.into_iter().step_by(every).map(f64::from);
        let step_s = |clip: &super::Clip| clip.duration_s / f64::from(MOMENTS_PER_CLIP);
        let even =
            self.playing_clips().flat_map(|clip| (0..MOMENTS_PER_CLIP).map(move |i| f64::from(i) * step_s(clip)));
        // The end of a clip is its beginning when it repeats, so it is looked at from just before.
        let ends = self.playing_clips().map(|clip| clip.duration_s * (1.0 - 1e-9));
        keys.chain(even).chain(ends).collect()
    }
}
