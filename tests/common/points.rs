//! Frames of point-based global illumination.

use std::ops::ControlFlow;
use std::sync::Arc;

use glam::Vec3;
use gridlight::cpu::micro_buffers::unpack_leaf;
use gridlight::environment::Environment;
use gridlight::points::PointCloud;
use gridlight::renderer::{Job, Renderer, UploadedScene};
use gridlight::scene::bvh::{BinaryBvh, Ray};
use gridlight::scene::{Light, Scene};
use gridlight::settings::{Settings, Size};
use gridlight::shared::PointCounts;

use super::written::Written;

/// A scene under this environment alone.
pub fn under(mut scene: Scene, environment: Environment) -> Scene {
    scene.lights = vec![Light::DARK];
    scene.environment = Some(Arc::new(environment));
    scene
}

/// Under a white sky.
pub fn under_sky(scene: Scene) -> Scene {
    under(scene, Environment::uniform([1.0; 3]))
}

/// What a frame leaves.
pub struct Rendered {
    /// Of every pixel.
    pub radiance: Vec<Vec3>,
    /// What each pass left.
    pub written: Written,
    /// The scene's points.
    pub cloud: PointCloud,
    /// As the frame's constants have it.
    pub largest_triangle: f32,
    /// Likewise.
    pub scene_radius: f32,
}

/// A frame from the scene's first camera.
pub fn render(scene: &Scene, settings: &Settings) -> Rendered {
    let test = super::gpu();
    let mut uploaded = UploadedScene::new(&test.gpu, scene).unwrap();
    uploaded.spread_points(scene, Some(settings.pbgi.points.ilog2())).unwrap();
    let mut renderer = Renderer::new(&Job::new(&test.gpu, &uploaded, &scene.cameras[0], settings)).unwrap();
    renderer.run_in_steps(200.0, &mut |_, _| ControlFlow::Continue(())).unwrap();
    Rendered {
        radiance: renderer.read_radiance().unwrap().chunks_exact(3).map(Vec3::from_slice).collect(),
        written: Written::by(&renderer),
        largest_triangle: renderer.frame_data().largest_triangle,
        scene_radius: renderer.frame_data().scene_radius,
        cloud: (**uploaded.points(settings.pbgi.points.ilog2()).unwrap()).clone(),
    }
}

impl Rendered {
    /// Of its points.
    pub fn counts(&self) -> PointCounts {
        self.written.last::<PointCounts>("point_counts")[0]
    }

    /// Keys of the primary points.
    pub fn primaries(&self) -> Vec<u32> {
        self.written.last::<u32>("point_primaries")[..self.counts().primary_count as usize].to_vec()
    }

    /// Irradiance of every key.
    pub fn irradiance(&self) -> Vec<Vec3> {
        self.written.last::<[f32; 3]>("point_irradiance").into_iter().map(Vec3::from).collect()
    }

    /// Positions and irradiance of the primary points of which the eye sees a leaf.
    pub fn lit(&self) -> Vec<(Vec3, Vec3)> {
        let irradiance = self.irradiance();
        let leaves: Vec<[u32; 4]> = self.written.last("primary_leaves");
        let place = |(key, leaves): (u32, [u32; 4])| {
            let leaf = leaves.into_iter().min().filter(|leaf| *leaf != u32::MAX)?;
            let position = self.cloud.node(unpack_leaf(&self.cloud, leaf) >> 1).centroid_ws;
            Some((position, irradiance[key as usize]))
        };
        self.primaries().into_iter().zip(leaves).filter_map(place).collect()
    }
}

/// Position, and normal of the triangle towards the eye, of what a pixel of the first camera's picture shows.
pub fn surface_at(scene: &Scene, bvh: &BinaryBvh, size: Size, index: usize) -> Option<[Vec3; 2]> {
    let camera = &scene.cameras[0];
    let [x, y] = [index as u32 % size.width, index as u32 / size.width].map(|i| i as f32 + 0.5);
    let half = (camera.yfov_rad * 0.5).tan();
    let across = (x / size.width as f32 * 2.0 - 1.0) * half * size.width as f32 / size.height as f32;
    let up = (1.0 - y / size.height as f32 * 2.0) * half;
    let direction = camera.forward_ws + camera.right_ws * across + camera.up_ws * up;
    let hit = bvh.trace_closest(&Ray { origin: camera.position_ws, direction, t_min: 0.0, t_max: f32::MAX })?;
    let [a, b, c] = [0, 1, 2].map(|corner| {
        let vertex = scene.indices[(3 * hit.triangle_index + corner) as usize];
        Vec3::from(scene.vertices[vertex as usize].position_ws)
    });
    let normal = (b - a).cross(c - a).normalize();
    Some([camera.position_ws + direction * hit.t, -normal * normal.dot(direction).signum()])
}
