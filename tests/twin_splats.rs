//! Micro-buffers that points are splatted into, against their twin.

mod common;

use std::f32::consts::PI;

use common::compare::within;
use common::points::{Rendered, render, under_sky};
use common::rooms::{add_quad, camera};
use glam::Vec3;
use gridlight::cpu::micro_buffers::{leaf_key_of, micro_frame, place_of_leaf_key};
use gridlight::cpu::splat_points::{MicroBuffer, MicroEye, Splatting};
use gridlight::micro_buffers::table;
use gridlight::scene::Scene;
use gridlight::scene::testing::{box_room, diffuse, scene_from_quads};
use gridlight::settings::{Coverage, Hemisphere, MicroFill, Settings, Size, Technique};
use gridlight::shared::{MicroTexel, PRIMARY_EDGE, SECONDARY_EDGE};

/// Cosine of the widest cone of normals of what is splatted.
const WIDEST_CONE_COS: f32 = 0.5;

fn small(coverage: Coverage) -> Settings {
    Settings::default().changed(|s| {
        s.render.technique = Technique::Pbgi;
        s.picture.size = Size { width: 61, height: 35 };
        s.pbgi.points = 4096;
        s.pbgi.micro = MicroFill::Points;
        s.pbgi.coverage = coverage;
    })
}

fn level(y: f32, h: f32) -> [Vec3; 4] {
    [Vec3::new(-h, y, h), Vec3::new(h, y, h), Vec3::new(h, y, -h), Vec3::new(-h, y, -h)]
}

/// A floor with a part of a roof, and a closed block that faces its neighbours in several ways.
fn under_a_roof() -> Scene {
    let mut scene = scene_from_quads("roof", &[level(0.0, 3.0)], diffuse("white", Vec3::ONE));
    add_quad(&mut scene, level(1.0, 0.8));
    let [below, above] = [level(0.02, 0.3), level(0.5, 0.2)];
    add_quad(&mut scene, above);
    add_quad(&mut scene, [below[3], below[2], below[1], below[0]]);
    for i in 0..4 {
        let next = (i + 1) % 4;
        add_quad(&mut scene, [below[i], below[next], above[next], above[i]]);
    }
    let mut scene = under_sky(scene);
    scene.cameras = vec![camera(Vec3::new(0.0, 0.6, 2.5), Vec3::new(0.0, -0.1, -1.0).normalize(), 0.8)];
    scene
}

/// All points on one triangle, which is far larger than the view.
fn one_triangle() -> Scene {
    let mut scene = scene_from_quads("triangle", &[level(0.0, 300.0)], diffuse("white", Vec3::ONE));
    scene.indices.truncate(3);
    scene.triangle_materials.truncate(1);
    scene.draws[0].index_count = 3;
    let mut scene = under_sky(scene);
    scene.cameras = vec![camera(Vec3::new(20.0, 40.0, 90.0), Vec3::new(0.0, -0.7, -0.7).normalize(), 0.8)];
    scene
}

fn inside_a_box() -> Scene {
    let mut scene = under_sky(box_room(4.0, Vec3::splat(0.8)));
    scene.cameras = vec![camera(Vec3::new(-1.5, 0.3, 1.4), Vec3::new(0.7, -0.2, -0.9).normalize(), 1.2)];
    scene
}

/// What a texel holds, or none where nothing is to be compared.
type Texel = (f32, u32);

/// A twin of a frame.
struct Twin<'a> {
    rendered: &'a Rendered,
    settings: &'a Settings,
    table: Vec<MicroTexel>,
}

impl<'a> Twin<'a> {
    fn new(rendered: &'a Rendered, settings: &'a Settings, edge: u32) -> Self {
        Self { rendered, settings, table: table(edge, Hemisphere::Paraboloid) }
    }

    fn splatting(&self) -> Splatting<'_> {
        Splatting {
            points: &self.rendered.cloud,
            table: &self.table,
            is_binary: self.settings.pbgi.coverage == Coverage::Binary,
            scene_radius: self.rendered.scene_radius,
            widest_cone_cos: WIDEST_CONE_COS,
        }
    }

    fn eye(&self, key: u32, leaves: &[u32]) -> MicroEye {
        let cloud = &self.rendered.cloud;
        let leaf = leaf_key_of(cloud, *leaves.iter().min().unwrap(), key);
        let (position_ws, normal) = place_of_leaf_key(cloud, leaf, self.rendered.largest_triangle);
        MicroEye { position_ws, to_world: micro_frame(normal, key, self.settings.tracing.seed) }
    }
}

fn texels_of(buffer: &MicroBuffer<'_>) -> Vec<Texel> {
    let seen = |(texel, coverage)| (coverage, if coverage > 0.0 { buffer.key(texel) } else { 0 });
    buffer.coverage().into_iter().enumerate().map(seen).collect()
}

/// Whether what primary points see is as the twin has it, of every so many points; gives how much is covered.
fn check_primaries(rendered: &Rendered, twin: &Twin<'_>, step: usize) -> Result<usize, String> {
    let texels: Vec<u32> = rendered.written.last("micro_texels");
    let leaves: Vec<u32> = rendered.written.last("primary_leaves");
    let splatting = twin.splatting();
    let (mut covered, mut different) = (0, Vec::new());
    for (slot, key) in rendered.primaries().into_iter().enumerate().step_by(step) {
        let eye = twin.eye(key, &leaves[4 * slot..][..4]);
        let expected = texels_of(&splatting.micro_buffer(eye));
        for (i, (found, expected)) in texels[expected.len() * slot..].iter().zip(expected).enumerate() {
            covered += usize::from(expected.0 > 0.0);
            let found = ((found >> 24) as f32 / 255.0, found & 0xff_ffff);
            // Coverage is kept in 255 steps, and a node at the edge of a texel may be rounded into either.
            if !within(found.0 - expected.0, 0.02) || (found.1 != expected.1 && expected.0 > 0.01) {
                different.push(format!("key {key}, texel {i}: {found:?}, not {expected:?}"));
            }
        }
    }
    if different.len() * 100 <= covered {
        Ok(covered)
    } else {
        Err(format!("{} of {covered}: {}", different.len(), different[0]))
    }
}

#[test]
fn primary_points_see_what_the_twin_does() {
    for (scene, least) in [(under_a_roof(), 1000), (inside_a_box(), 5000), (one_triangle(), 0)] {
        for coverage in [Coverage::Fraction, Coverage::Binary] {
            let settings = small(coverage);
            let rendered = render(&scene, &settings);
            let primaries = rendered.primaries().len();
            let twin = Twin::new(&rendered, &settings, PRIMARY_EDGE);
            let covered = check_primaries(&rendered, &twin, 1 + primaries / 40).unwrap();
            assert!(primaries > 20 && covered >= least, "{primaries} points, {covered} texels");
        }
    }
}

#[test]
fn another_twin_does_not_pass() {
    let settings = small(Coverage::Fraction);
    let rendered = render(&under_a_roof(), &settings);
    let turned = settings.clone().changed(|s| s.tracing.seed = 2);
    check_primaries(&rendered, &Twin::new(&rendered, &turned, PRIMARY_EDGE), 9).unwrap_err();
    let binary = settings.clone().changed(|s| s.pbgi.coverage = Coverage::Binary);
    check_primaries(&rendered, &Twin::new(&rendered, &binary, PRIMARY_EDGE), 9).unwrap_err();
}

/// Whether secondary points have the light that their twins' micro-buffers leave open, under a white sky; `scale` times it.
fn check_secondaries(rendered: &Rendered, twin: &Twin<'_>, scale: f32) -> Result<usize, String> {
    let needed: Vec<u32> = rendered.written.last("point_needed");
    let irradiance: Vec<[f32; 3]> = rendered.written.all("point_light/light_secondaries", "point_irradiance");
    let splatting = twin.splatting();
    let keys = &needed[..rendered.counts().needed_count as usize];
    let mut shaded = 0;
    for key in keys.iter().step_by(1 + keys.len() / 60) {
        let coverage = splatting.micro_buffer(twin.eye(*key, &[u32::MAX])).coverage();
        let open = |(coverage, texel): (f32, &MicroTexel)| (1.0 - coverage) * texel.cosine_weight;
        let expected: f32 = coverage.into_iter().zip(&twin.table).map(open).sum();
        let found = irradiance[*key as usize][0];
        shaded += usize::from(expected < 0.9 * PI);
        if !within(found - scale * expected, 0.01 * PI) {
            return Err(format!("key {key}: {found}, not {expected}"));
        }
    }
    Ok(shaded)
}

#[test]
fn secondary_points_are_lit_as_their_twins() {
    for coverage in [Coverage::Fraction, Coverage::Binary] {
        let settings = small(coverage);
        let rendered = render(&under_a_roof(), &settings);
        let twin = Twin::new(&rendered, &settings, SECONDARY_EDGE);
        let shaded = check_secondaries(&rendered, &twin, 1.0).unwrap();
        assert!(shaded > 10, "{shaded} points are shaded");
        check_secondaries(&rendered, &twin, 1.05).unwrap_err();
    }
}
