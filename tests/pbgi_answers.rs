//! Point-based global illumination, traced and splatted, where mathematics knows how much of the sky is seen, and in the
//! furnace, where everything has the radiance of the sky.

mod common;

use std::f32::consts::PI;

use common::compare::{near, within};
use common::points::{Rendered, render, under_sky};
use common::rooms::{add_quad, camera};
use common::written::Written;
use glam::Vec3;
use gridlight::Result as GridlightResult;
use gridlight::micro_buffers::LOBES;
use gridlight::passes::compose::Indirect;
use gridlight::passes::direct_light::AreaLight;
use gridlight::passes::gbuffer::GBuffer;
use gridlight::passes::micro_buffers::{self, GatherTables};
use gridlight::passes::pbgi_shape::PbgiShape;
use gridlight::passes::point_cut::Hidden;
use gridlight::passes::points::Points;
use gridlight::passes::{Frame, cache_gather, cache_tiles, point_cut, radiance_cache};
use gridlight::renderer::{Job, Renderer, UploadedScene};
use gridlight::scene::Scene;
use gridlight::scene::testing::{box_room, diffuse, scene_from_quads};
use gridlight::settings::{MicroFill, Settings, Size, Technique as TechniqueName};
use gridlight::shared::{FrameData, PointCounts};
use gridlight::techniques::{self, Added, Technique, TechniqueOutputs, TechniqueShape};

const BOTH: [MicroFill; 2] = [MicroFill::Rays, MicroFill::Points];

fn settings(micro: MicroFill) -> Settings {
    Settings::default().changed(|s| {
        s.render.technique = TechniqueName::Pbgi;
        s.picture.size = Size { width: 128, height: 72 };
        s.pbgi.points = 1 << 15;
        s.pbgi.micro = micro;
    })
}

fn quad(origin: Vec3, u: Vec3, v: Vec3) -> [Vec3; 4] {
    [origin, origin + u, origin + u + v, origin + v]
}

/// A black floor before z = 0, seen from +z.
fn floor() -> Scene {
    let floor = quad(Vec3::new(-2.0, 0.0, 4.0), 4.0 * Vec3::X, -4.0 * Vec3::Z);
    let mut scene = scene_from_quads("floor", &[floor], diffuse("black", Vec3::ZERO));
    scene.cameras = vec![camera(Vec3::new(0.0, 2.0, 4.0), Vec3::new(0.0, -1.0, -1.0).normalize(), 0.9)];
    scene
}

/// Mean and spread of how much more of the sky the floor's points see than `open` says, over those that `asked` names.
fn sky_errors(rendered: &Rendered, asked: impl Fn(Vec3) -> bool, open: impl Fn(Vec3) -> f32) -> [f32; 2] {
    let on_floor = |position: &Vec3| position.y.abs() < 1e-3 && asked(*position);
    let lit = rendered.lit();
    let errors: Vec<f32> = lit.iter().filter(|(p, _)| on_floor(p)).map(|(p, e)| e.x / PI - open(*p)).collect();
    assert!(errors.len() > 50, "{} points", errors.len());
    let count = errors.len() as f32;
    let mean = errors.iter().sum::<f32>() / count;
    [mean, (errors.iter().map(|error| error * error).sum::<f32>() / count).sqrt()]
}

/// Whether errors are those of a way to fill micro-buffers.
fn check_errors([mean, spread]: [f32; 2], micro: MicroFill) -> Result<(), String> {
    let (most, widest) = if micro == MicroFill::Rays { (0.003, 0.02) } else { (0.01, 0.02) };
    let is_right = within(mean, most) && within(spread, widest);
    if is_right { Ok(()) } else { Err(format!("{micro:?}: off by {mean}, spread {spread}")) }
}

#[test]
fn a_floor_before_a_wall_sees_the_rest_of_the_sky() {
    let height = 1.0;
    let mut scene = floor();
    add_quad(&mut scene, quad(Vec3::new(-40.0, 0.0, 0.0), 80.0 * Vec3::X, height * Vec3::Y));
    let scene = under_sky(scene);
    for micro in BOTH {
        let rendered = render(&scene, &settings(micro));
        let asked = |p: Vec3| p.x.abs() < 1.0 && p.z > 0.1;
        let open = |p: Vec3| 0.5 * (1.0 + p.z / p.z.hypot(height));
        check_errors(sky_errors(&rendered, asked, open), micro).unwrap();
        let lower = |p: Vec3| 0.5 * (1.0 + p.z / p.z.hypot(0.8 * height));
        check_errors(sky_errors(&rendered, asked, lower), micro).unwrap_err();
    }
}

/// Adds a ball of many faces, without the uppermost ones if it is open.
fn add_ball(scene: &mut Scene, centre: Vec3, radius: f32, is_open: bool) {
    let (columns, rows) = (48, 24);
    let at = |x: u32, y: u32| {
        // The same numbers at the seam and at the poles, so that it is closed.
        let x = if y == 0 || y == rows { 0 } else { x % columns };
        let (around, down) = (x as f32 / columns as f32 * 2.0 * PI, y as f32 / rows as f32 * PI);
        centre + radius * Vec3::new(down.sin() * around.cos(), down.cos(), down.sin() * around.sin())
    };
    for (x, y) in (0..columns).flat_map(|x| (u32::from(is_open)..rows).map(move |y| (x, y))) {
        add_quad(scene, [at(x + 1, y), at(x + 1, y + 1), at(x, y + 1), at(x, y)]);
    }
}

#[test]
fn a_floor_below_a_ball_sees_the_rest_of_the_sky() {
    let (centre, radius) = (Vec3::new(0.0, 1.2, 1.5), 0.6);
    // Where the ball is far enough away to be splatted, and so near that it hides much.
    let asked = |p: Vec3| p.x.abs() < 1.8 && p.z > 0.2 && p.z < 3.8;
    for (micro, is_open) in [(BOTH[0], false), (BOTH[1], false), (BOTH[1], true)] {
        let mut scene = floor();
        add_ball(&mut scene, centre, radius, is_open);
        let rendered = render(&under_sky(scene), &settings(micro));
        let open = |scale: f32| {
            move |p: Vec3| 1.0 - scale * radius * radius * (centre.y - p.y) / (centre - p).length().powi(3)
        };
        check_errors(sky_errors(&rendered, asked, open(1.0)), micro).unwrap();
        check_errors(sky_errors(&rendered, asked, open(1.2)), micro).unwrap_err();
    }
}

fn closed_box() -> Scene {
    let mut scene = under_sky(box_room(4.0, Vec3::ONE));
    scene.cameras = vec![camera(Vec3::new(-1.5, 0.3, 1.4), Vec3::new(0.7, -0.2, -0.9).normalize(), 1.2)];
    scene
}

#[test]
fn nothing_of_the_sky_gets_into_a_closed_box() {
    for micro in BOTH {
        let rendered = render(&closed_box(), &settings(micro));
        let most = if micro == MicroFill::Rays { 1e-6 } else { 0.015 };
        let lit = rendered.lit();
        let mean = lit.iter().map(|(_, irradiance)| irradiance.x / PI).sum::<f32>() / lit.len() as f32;
        assert!(lit.len() > 20 && within(mean, most), "{micro:?}: {mean} of the sky at {} points", lit.len());
    }
}

/// White surfaces of several kinds: a floor, a roof over a part of it, a ball, and a wall that stands in the floor.
fn furnace() -> Scene {
    let mut scene = floor();
    scene.materials[0] = diffuse("white", Vec3::ONE);
    add_quad(&mut scene, quad(Vec3::new(-1.5, 1.0, 3.0), 1.5 * Vec3::X, -2.0 * Vec3::Z));
    add_quad(&mut scene, quad(Vec3::new(0.5, -0.5, 3.0), 1.0 * Vec3::X, 1.5 * Vec3::Y));
    add_ball(&mut scene, Vec3::new(0.3, 0.5, 1.2), 0.6, false);
    under_sky(scene)
}

/// Caches and pixels of point-based global illumination, where every point has this irradiance.
struct Furnace {
    irradiance: f32,
}

/// The one of a white sky.
static WHITE: Furnace = Furnace { irradiance: PI };

#[derive(Clone, Debug, PartialEq)]
struct FurnaceShape {
    pbgi: PbgiShape,
    irradiance: f32,
}

impl Technique for Furnace {
    fn name(&self) -> &'static str {
        "furnace"
    }

    fn shape(&self, job: &Job<'_>, known: Option<&dyn TechniqueShape>) -> GridlightResult<Box<dyn TechniqueShape>> {
        let shape = techniques::of(job.settings)?.shape(job, known)?;
        let pbgi: &PbgiShape = shape.as_any().downcast_ref().expect("pbgi");
        Ok(Box::new(FurnaceShape { pbgi: pbgi.clone(), irradiance: self.irradiance }))
    }
}

impl TechniqueShape for FurnaceShape {
    fn technique(&self) -> &'static dyn Technique {
        &WHITE
    }

    fn write_constants(&self, job: &Job<'_>, data: &mut FrameData) {
        self.pbgi.write_constants(job, data);
    }

    fn environment_light(&self) -> AreaLight {
        AreaLight::InTechnique
    }

    fn add_passes(&self, frame: &mut Frame, gbuffer: &GBuffer) -> Added {
        let shape = &self.pbgi;
        let tables = GatherTables::declare(frame, shape);
        let points = Points::declare(frame, &shape.cloud);
        let light = vec![self.irradiance; 6 * points.node_count() as usize];
        let irradiance = frame.graph.filled_buffer("point_irradiance", bytemuck::cast_slice(&light).into());
        let cut = point_cut::add(frame, gbuffer.depth, &points, shape.primary_capacity, Hidden::Dropped);
        let primaries = micro_buffers::choose_leaves(frame, &points, cut);
        let micro_buffers = micro_buffers::add(frame, shape, &points, &primaries, &tables);
        let caches = radiance_cache::add(frame, shape, &points, &primaries, &micro_buffers, &tables, irradiance);
        let tiles = cache_tiles::add(frame, shape, &primaries, &caches);
        let gathered = cache_gather::add(frame, gbuffer, &caches, &tiles);
        let indirect = Indirect { lighting: gathered.lighting, shadows: None, has_share: false };
        Added { indirect: Some(indirect), outputs: TechniqueOutputs::default(), inspect: None }
    }
}

/// What a furnace leaves.
struct Burnt {
    /// Of every pixel.
    radiance: Vec<Vec3>,
    /// What every lobe of every cache holds, of the sky and of the bounce together.
    lobes: Vec<Vec3>,
}

fn burn(scene: &Scene, settings: &Settings, furnace: &Furnace) -> Burnt {
    let test = common::gpu();
    let mut uploaded = UploadedScene::new(&test.gpu, scene).unwrap();
    uploaded.spread_points(scene, Some(settings.pbgi.points.ilog2())).unwrap();
    let job = Job::new(&test.gpu, &uploaded, &scene.cameras[0], settings);
    let mut renderer = Renderer::with_technique(furnace, &job).unwrap();
    let ticket = renderer.submit().unwrap();
    renderer.wait(ticket).unwrap();
    let radiance = renderer.read_radiance().unwrap().chunks_exact(3).map(Vec3::from_slice).collect();
    let written = Written::by(&renderer);
    let cache_count = written.last::<PointCounts>("point_counts")[0].primary_count as usize;
    let lobes: Vec<[Vec3; 2]> = written.last("cache_lobes");
    Burnt {
        radiance,
        lobes: lobes[..LOBES as usize * cache_count].iter().map(|[sky, bounce]| *sky + *bounce).collect(),
    }
}

fn check_white(burnt: &Burnt) -> Result<(), String> {
    if let Some(lobe) = burnt.lobes.iter().find(|lobe| !near(**lobe, Vec3::splat(PI), 2e-5)) {
        return Err(format!("a lobe of {lobe} in the furnace"));
    }
    match burnt.radiance.iter().find(|radiance| !near(**radiance, Vec3::ONE, 2e-5)) {
        Some(radiance) => Err(format!("{radiance} in the furnace")),
        None if burnt.lobes.len() > 100 => Ok(()),
        None => Err(format!("{} lobes are too few", burnt.lobes.len())),
    }
}

#[test]
fn in_the_furnace_everything_is_white() {
    for micro in BOTH {
        for scene in [furnace(), closed_box()] {
            check_white(&burn(&scene, &settings(micro), &WHITE)).unwrap();
        }
        let brighter = Furnace { irradiance: 1.01 * PI };
        check_white(&burn(&furnace(), &settings(micro), &brighter)).unwrap_err();
    }
}
