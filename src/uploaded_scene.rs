//! A scene on a device, and what is computed of it before it gets there.

use std::sync::{Arc, OnceLock};
use std::time::Instant;

use glam::Vec3;

use crate::environment::Environment;
use crate::environment::blurred::blurred;
use crate::environment::upload::PreparedEnvironment;
use crate::error::{Error, Result};
use crate::gpu::{Gpu, Limits, SceneBytes, SceneData, ScenePart, SceneSet};
use crate::points::PointCloud;
use crate::scene::bvh::{self, SceneBvh};
use crate::scene::chunks::chunks;
use crate::scene::query_geometry::QueryGeometry;
use crate::scene::refit::MovingBvh;
use crate::scene::upload::{self, PreparedScene};
use crate::scene::{Aabb, Scene};
use crate::settings::Rays;
use crate::shared::{BvhNode, BvhTriangle, LIGHT_EMITTERS, PunctualLight, WORD_ROW_TEXELS};

/// A scene uploaded to a device, with what the frame needs to know of it. Clones share what is on the device.
#[derive(Clone)]
pub struct UploadedScene {
    pub(crate) set: Arc<SceneSet>,
    pub(crate) bounds: Aabb,
    /// Of the places of all point lights at all times.
    lamp_bounds: Aabb,
    /// Longest edge of any triangle's bounding box.
    pub(crate) largest_triangle: f32,
    /// The same of triangles that never move.
    largest_at_rest: f32,
    pub(crate) first_point_light: u32,
    pub(crate) light_count: u32,
    /// Triangles that shine by themselves.
    pub(crate) emitter_count: u32,
    /// Luminance of their flux.
    emitter_flux: f64,
    /// Something is seen without light: it shines or is unlit.
    pub(crate) has_emission: bool,
    pub(crate) has_structures: bool,
    /// Cells of the environment's table; 0 where nothing comes from the environment.
    pub(crate) environment_cells: [u32; 2],
    /// Flux (luminance) of the lights, and of the environment into the scene's bounding sphere.
    pub(crate) light_flux: f64,
    /// Of the lights, that of the faintest one that shines; 0 where none does.
    pub(crate) faintest_light_flux: f64,
    pub(crate) environment_flux: f64,
    /// Radiance over what the environment's image holds.
    pub(crate) environment_scale: f32,
    /// Light from all around, and means of it once they are asked for.
    environment: Option<Arc<Environment>>,
    environment_means: OnceLock<Arc<[[f32; 4]]>>,
    /// Directional and spot lights, as uploaded.
    other_lights: Vec<PunctualLight>,
    /// The tree that follows triangles which move.
    moving: Option<Arc<MovingBvh>>,
    /// How often vertices have moved.
    vertex_moves: u64,
    /// Whether anything moves: vertices, lights or cameras.
    animated: bool,
    /// Whether lights move or change.
    lights_move: bool,
    /// Points over its surfaces, those that were asked for last in front.
    points: Vec<Arc<PointCloud>>,
}

/// The least share of the flux that one of these lights has, of those that shine.
fn faintest_share(lights: &[PunctualLight]) -> f64 {
    let shares = lights.iter().map(|light| f64::from(light.path_probability)).filter(|share| *share > 0.0);
    shares.reduce(f64::min).unwrap_or(0.0)
}

/// Sets of points that are kept: the two sides of a window may have different ones, and others while something moves.
const KEPT_POINTS: usize = 4;

/// Whether the largest parts of a scene fit the device, before minutes are spent on its BVH.
fn check_size(scene: &Scene, storage_bytes: u64, image_rows: u32) -> Result<()> {
    let triangle_count = scene.indices.len() as u64 / 3;
    let image_bytes = u64::from(image_rows) * u64::from(WORD_ROW_TEXELS) * 16;
    let parts = [
        ("vertices", size_of_val(scene.vertices.as_slice()) as u64, storage_bytes),
        ("indices", size_of_val(scene.indices.as_slice()) as u64, storage_bytes),
        ("triangles of the BVH", triangle_count * size_of::<BvhTriangle>() as u64, image_bytes),
    ];
    let excess = |(_, bytes, limit): &(&str, u64, u64)| *bytes as f64 / *limit as f64;
    let most = parts.iter().max_by(|a, b| excess(a).total_cmp(&excess(b)));
    let Some(part @ (name, bytes, limit)) = most.filter(|part| excess(part) > 1.0) else { return Ok(()) };
    Err(Error::Failure(format!(
        "the scene is too large for this device: of its {triangle_count} triangles the {name} take {} MiB, and {} MiB are \
         the most; about {:.0} such triangles would fit",
        bytes >> 20,
        limit >> 20,
        triangle_count as f64 / excess(part)
    )))
}

/// What of a scene is computed before it is uploaded; needs no device.
pub struct ReadyScene {
    bvh: bvh::SceneBvh,
    prepared: PreparedScene,
}

impl ReadyScene {
    /// Builds the BVH and everything else that the upload needs, for a device with these limits.
    ///
    /// # Errors
    /// When a part of the scene does not fit the device.
    pub fn new(scene: &Scene, limits: &Limits) -> Result<Self> {
        check_size(scene, limits.storage_range_bytes, limits.image_rows)?;
        let bvh = bvh::build(scene);
        log::info!("BVH: {} nodes, depth {}, {:.0} ms", bvh.nodes.len(), bvh.depth, bvh.build_ms);
        Ok(Self { bvh, prepared: upload::prepare(scene, limits.array_layers) })
    }
}

impl UploadedScene {
    /// Builds the BVH and uploads everything, for `--rays bvh`.
    ///
    /// # Errors
    /// When a part of the scene does not fit the device.
    pub fn new(gpu: &Arc<Gpu>, scene: &Scene) -> Result<Self> {
        Self::with_rays(gpu, scene, Rays::Bvh)
    }

    /// The same with what `rays` needs beside the BVH. Either kind of rays can then be asked for.
    ///
    /// # Errors
    /// [`Error::Usage`] when the device has no such rays; when a part of the scene does not fit the device.
    pub fn with_rays(gpu: &Arc<Gpu>, scene: &Scene, rays: Rays) -> Result<Self> {
        Self::upload(gpu, scene, &ReadyScene::new(scene, &gpu.report().limits)?, rays)
    }

    /// Uploads a scene that was made ready before, such as on another thread.
    ///
    /// # Errors
    /// Those of [`Self::with_rays`].
    pub fn upload(gpu: &Arc<Gpu>, scene: &Scene, ready: &ReadyScene, rays: Rays) -> Result<Self> {
        check_rays(gpu, rays)?;
        let ReadyScene { bvh, prepared } = ready;
        bvh.check_depth()?;
        let moves = scene.motion.moves().geometry;
        let node_capacity = if moves { MovingBvh::node_capacity(bvh.triangles.len()) } else { 0 };
        let PreparedScene {
            materials,
            lights,
            emitters,
            has_emission,
            first_point_light,
            light_flux,
            environment,
            albedo,
            textures,
            material_textures,
        } = prepared;
        let query = (rays == Rays::Query).then(|| QueryGeometry::new(scene, &bvh.triangles));
        let data = SceneData {
            query: query.as_ref(),
            nodes: bytemuck::cast_slice(&bvh.nodes),
            node_capacity_bytes: node_capacity * size_of::<BvhNode>(),
            triangles: bytemuck::cast_slice(&bvh.triangles),
            vertices: bytemuck::cast_slice(&scene.vertices),
            tangents: bytemuck::cast_slice(&scene.tangents),
            vertices_move: moves,
            indices: bytemuck::cast_slice(&scene.indices),
            materials: bytemuck::cast_slice(materials),
            lights: bytemuck::cast_slice(lights),
            emitters: bytemuck::cast_slice(&emitters.list),
            environment,
            albedo_size_px: albedo.size_px,
            albedo_layers: &albedo.layers,
            textures,
            material_textures,
            chunks: chunks(scene),
        };
        let set = Arc::new(SceneSet::new(gpu, &data)?);
        let moving_vertices = scene.motion.moving_vertices(scene.vertices.len());
        let other_lights = lights[..*first_point_light as usize].to_vec();
        let first_point_light = *first_point_light;
        let light_count = lights.iter().filter(|light| light.kind != LIGHT_EMITTERS).count() as u32;
        Ok(Self {
            set,
            bounds: scene.bounds,
            lamp_bounds: scene.lamp_bounds(),
            largest_triangle: largest_triangle(scene, |_| true),
            largest_at_rest: largest_triangle(scene, |corner| !moving_vertices[corner]),
            first_point_light,
            light_count,
            emitter_count: emitters.list.len() as u32,
            emitter_flux: emitters.flux,
            has_emission: *has_emission,
            has_structures: query.is_some(),
            environment_cells: environment.cells,
            environment_scale: environment.scale,
            environment: scene.environment.clone(),
            environment_means: OnceLock::new(),
            light_flux: *light_flux,
            faintest_light_flux: *light_flux * faintest_share(lights),
            environment_flux: environment_flux(environment, &scene.bounds),
            other_lights,
            moving: moves.then(|| Arc::new(MovingBvh::new(bvh))),
            vertex_moves: 0,
            animated: scene.motion.moves().any(),
            lights_move: scene.motion.moves().lights,
            points: Vec::new(),
        })
    }

    /// Puts on the device where the scene, which is the one that was uploaded, has everything that moves, vertices as the host
    /// has them. `scene_mover` leaves these to the device. Waits; no frame may be running. Points that stand for its surfaces have
    /// to be spread again.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn follow(&mut self, gpu: &Arc<Gpu>, scene: &Scene) -> Result<()> {
        self.follow_lighting(gpu, scene)?;
        let moves = scene.motion.moves().geometry;
        let Some(moving) = self.moving.as_ref().filter(|_| moves).map(Arc::clone) else { return Ok(()) };
        self.set.keep_vertices(gpu)?;
        self.set.replace(gpu, ScenePart::Vertices, bytemuck::cast_slice(&scene.vertices))?;
        if !scene.tangents.is_empty() {
            self.set.replace(gpu, ScenePart::Tangents, bytemuck::cast_slice(&scene.tangents))?;
        }
        self.replace_tree(gpu, scene, &moving.at(scene))?;
        self.vertices_have_moved(largest_triangle(scene, |_| true));
        Ok(())
    }

    /// Puts on the device where lights that move are, and the environment.
    pub(crate) fn follow_lighting(&mut self, gpu: &Arc<Gpu>, scene: &Scene) -> Result<()> {
        if scene.motion.moves().lights {
            let (lights, _) = upload::lights(scene, self.emitter_flux);
            self.set.replace(gpu, ScenePart::Lights, bytemuck::cast_slice(&lights))?;
            self.other_lights = lights[..self.first_point_light as usize].to_vec();
        }
        self.follow_environment(gpu, scene)
    }

    /// Puts another tree over the scene's triangles on the device; waits.
    pub(crate) fn replace_tree(&self, gpu: &Arc<Gpu>, scene: &Scene, tree: &SceneBvh) -> Result<()> {
        self.set.replace(gpu, ScenePart::Nodes, bytemuck::cast_slice(&tree.nodes))?;
        self.set.replace(gpu, ScenePart::Triangles, bytemuck::cast_slice(&tree.triangles))?;
        if self.has_structures {
            // Its triangles may have another order.
            self.set.rebuild_structures(gpu, &QueryGeometry::new(scene, &tree.triangles))?;
        }
        Ok(())
    }

    /// The vertices on the device are others than before, and of the triangles that may have moved the largest is so large.
    pub(crate) fn vertices_have_moved(&mut self, largest_triangle: f32) {
        self.vertex_moves += 1;
        self.largest_triangle = largest_triangle.max(self.largest_at_rest);
        self.points.clear();
    }

    /// The tree that follows triangles which move.
    pub(crate) fn moving_bvh(&self) -> Option<&Arc<MovingBvh>> {
        self.moving.as_ref()
    }

    /// Puts the scene's environment on the device, where it is another one than before.
    fn follow_environment(&mut self, gpu: &Arc<Gpu>, scene: &Scene) -> Result<()> {
        let is_same = |a: &Arc<Environment>, b: &Arc<Environment>| Arc::ptr_eq(a, b);
        let Some(environment) = &scene.environment else { return Ok(()) };
        if self.environment.as_ref().is_some_and(|known| is_same(known, environment)) {
            return Ok(());
        }
        let start = Instant::now();
        let prepared = upload::environment(scene);
        let prepared_ms = start.elapsed().as_secs_f64() * 1e3;
        self.set.replace_environment(gpu, &prepared)?;
        log::debug!(
            "sky: prepared in {prepared_ms:.1} ms, on the device after {:.1} ms",
            start.elapsed().as_secs_f64() * 1e3
        );
        (self.environment_cells, self.environment_scale) = (prepared.cells, prepared.scale);
        self.environment_flux = environment_flux(&prepared, &self.bounds);
        (self.environment, self.environment_means) = (Some(Arc::clone(environment)), OnceLock::new());
        Ok(())
    }

    /// Spreads 2 to this power points over the surfaces of the scene, which is the one that was uploaded, unless it has
    /// them already or none are wanted. Returns them.
    ///
    /// # Errors
    /// Those of [`PointCloud::of_scene`].
    pub fn spread_points(&mut self, scene: &Scene, leaf_count_log2: Option<u32>) -> Result<Option<Arc<PointCloud>>> {
        let Some(wanted) = leaf_count_log2 else { return Ok(None) };
        let points = match self.points(wanted) {
            Ok(known) => Arc::clone(known),
            Err(_) => {
                let start = Instant::now();
                let points = PointCloud::of_scene(scene, wanted)?;
                log::info!("points: {}, {:.0} ms", points.leaf_count(), start.elapsed().as_secs_f64() * 1e3);
                Arc::new(points)
            }
        };
        self.keep_points(Some(Arc::clone(&points)));
        Ok(Some(points))
    }

    /// Takes points that were spread over this scene elsewhere, such as on another thread, if there are any.
    pub fn keep_points(&mut self, points: Option<Arc<PointCloud>>) {
        let Some(points) = points else { return };
        self.points.retain(|known| known.leaf_count_log2 != points.leaf_count_log2);
        self.points.insert(0, points);
        self.points.truncate(KEPT_POINTS);
    }

    /// The points that were spread over it, 2 to this power of them.
    ///
    /// # Errors
    /// [`Error::Failure`] when [`Self::spread_points`] has not made them.
    pub fn points(&self, leaf_count_log2: u32) -> Result<&Arc<PointCloud>> {
        let known = self.points.iter().find(|points| points.leaf_count_log2 == leaf_count_log2);
        known.ok_or_else(|| Error::Failure(format!("the scene was uploaded without 2^{leaf_count_log2} points")))
    }

    /// Triangles, materials and lights as shaders read them; waits.
    ///
    /// # Errors
    /// When the device is lost or has no memory.
    pub fn read_back(&self, gpu: &Arc<Gpu>) -> Result<SceneBytes> {
        self.set.read_back(gpu)
    }

    /// The scene's parts on the device, for executors of other graphs.
    #[must_use]
    pub fn set(&self) -> &Arc<SceneSet> {
        &self.set
    }

    /// Means of the environment over caps of several sizes ([`blurred`]), in the unit that its image is stored in; a black
    /// texel where nothing comes from it.
    #[must_use]
    pub fn environment_means(&self) -> Arc<[[f32; 4]]> {
        let scale = self.environment_scale;
        let stored = |environment: &Arc<Environment>| -> Arc<[[f32; 4]]> {
            blurred(environment).iter().map(|texel| texel.map(|value| value / scale)).collect()
        };
        let means = || self.environment.as_ref().filter(|_| scale > 0.0).map_or_else(|| [[0.0; 4]].into(), stored);
        Arc::clone(self.environment_means.get_or_init(means))
    }

    /// Whether its vertices move.
    #[must_use]
    pub fn has_moving_vertices(&self) -> bool {
        self.moving.is_some()
    }

    /// Longest edge of the bounding box of any triangle.
    #[must_use]
    pub fn largest_triangle(&self) -> f32 {
        self.largest_triangle
    }

    /// How often its vertices have moved. Those from before the last time are on the device as well.
    #[must_use]
    pub fn vertex_moves(&self) -> u64 {
        self.vertex_moves
    }

    /// Whether anything in it moves: vertices, lights or cameras.
    #[must_use]
    pub fn is_animated(&self) -> bool {
        self.animated
    }

    /// Bounds of the places of all point lights at all times; empty without any.
    #[must_use]
    pub fn lamp_bounds(&self) -> Aabb {
        self.lamp_bounds
    }

    /// Whether vertices or lights move, and light paths with them.
    #[must_use]
    pub fn has_moving_lighting(&self) -> bool {
        self.has_moving_vertices() || self.lights_move
    }

    /// Whether lights move or change.
    #[must_use]
    pub fn has_moving_lights(&self) -> bool {
        self.lights_move
    }

    /// Triangles of the scene that shine by themselves.
    #[must_use]
    pub fn emitter_count(&self) -> u32 {
        self.emitter_count
    }

    /// Punctual lights of the scene.
    #[must_use]
    pub fn light_count(&self) -> u32 {
        self.light_count
    }

    /// Directional and spot lights, as uploaded.
    #[must_use]
    pub fn other_lights(&self) -> &[PunctualLight] {
        &self.other_lights
    }
}

/// Flux (luminance) of an environment into the bounding sphere of a scene.
fn environment_flux(environment: &PreparedEnvironment, bounds: &Aabb) -> f64 {
    let radius = f64::from(bounds.radius());
    environment.scalar_irradiance * std::f64::consts::PI * radius * radius
}

/// Longest edge of the bounding box of any triangle of such corners.
fn largest_triangle(scene: &Scene, counts: impl Fn(usize) -> bool) -> f32 {
    let corner = |i: &u32| Vec3::from(scene.vertices[*i as usize].position_ws);
    let edge = |t: &[u32]| {
        let [a, b, c] = [0, 1, 2].map(|k| corner(&t[k]));
        (a.max(b).max(c) - a.min(b).min(c)).max_element()
    };
    let counted = scene.indices.chunks_exact(3).filter(|t| t.iter().all(|corner| counts(*corner as usize)));
    counted.map(edge).fold(0.0, f32::max)
}

/// Fails where a device cannot trace rays in this way.
pub(crate) fn check_rays(gpu: &Gpu, rays: Rays) -> Result<()> {
    if rays == Rays::Bvh || gpu.features().ray_query {
        return Ok(());
    }
    Err(Error::Usage(
        "--rays query needs VK_KHR_ray_query and VK_KHR_acceleration_structure, which this device lacks; use bvh"
            .to_owned(),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::testing::plane;

    #[test]
    fn scenes_beyond_a_limit_are_refused_at_once() {
        let scene = plane(1.0);
        check_size(&scene, 4096, 1).unwrap();
        let message = |bytes, rows| check_size(&scene, bytes, rows).unwrap_err().to_string();
        let vertices = message(64, 1);
        assert!(vertices.contains("of its 2 triangles the vertices take 0 MiB"), "{vertices}");
        assert!(vertices.ends_with("about 1 such triangles would fit"), "{vertices}");
        assert!(message(4096, 0).contains("the triangles of the BVH"));
    }
}
