//! Point-based global illumination with each of its ways of selection, with more primary points than there is room for, and in
//! awkward scenes.

mod common;

use common::compare::near;
use common::light_sets::Random;
use common::points::{Rendered, render, under_sky};
use common::rooms::{add_quad, camera};
use glam::Vec3;
use gridlight::passes::pbgi_shape::PbgiShape;
use gridlight::points::PointCloud;
use gridlight::renderer::{Job, Renderer, UploadedScene};
use gridlight::scene::testing::{box_room, diffuse, plane, scene_from_quads};
use gridlight::scene::{Scene, Texture};
use gridlight::settings::{MicroFill, Selection, Settings, Size, Technique};
use gridlight::shared::CacheCounts;

fn small() -> Settings {
    Settings::default().changed(|s| {
        s.render.technique = Technique::Pbgi;
        s.picture.size = Size { width: 96, height: 54 };
        s.pbgi.points = 4096;
    })
}

/// A floor and a wall behind it, of which the camera sees a part.
fn corner() -> Scene {
    let level =
        [Vec3::new(-2.0, 0.0, 2.0), Vec3::new(2.0, 0.0, 2.0), Vec3::new(2.0, 0.0, -2.0), Vec3::new(-2.0, 0.0, -2.0)];
    let mut scene = scene_from_quads("corner", &[level], diffuse("grey", Vec3::splat(0.5)));
    add_quad(&mut scene, level.map(|corner| Vec3::new(corner.x, 2.0 - corner.z, -2.0)));
    let mut scene = under_sky(scene);
    scene.cameras = vec![camera(Vec3::new(0.5, 1.0, 2.5), Vec3::new(0.0, -0.3, -1.0).normalize(), 0.7)];
    scene
}

/// Bits of a set of sides.
fn bits(rendered: &Rendered, name: &str) -> Vec<u32> {
    rendered.written.last(name)
}

/// Whether every bit of the one is in the other, and how many more there are.
fn bits_more(few: &[u32], many: &[u32]) -> Option<u32> {
    let is_subset = few.iter().zip(many).all(|(few, many)| few & !many == 0);
    let count = |bits: &[u32]| bits.iter().map(|word| word.count_ones()).sum::<u32>();
    is_subset.then(|| count(many) - count(few))
}

#[test]
fn arrivals_find_what_levels_find() {
    let [levels, arrival] = [Selection::Levels, Selection::Arrival]
        .map(|selection| render(&corner(), &small().changed(|s| s.pbgi.selection = selection)));
    for what in ["known_bits", "derived_bits", "needed_bits"] {
        assert!(bits(&levels, what) == bits(&arrival, what), "{what}");
    }
    assert_eq!(levels.counts(), arrival.counts());
    assert!(levels.radiance == arrival.radiance);
}

#[test]
fn the_papers_order_lights_a_superset() {
    let [ours, paper] = [Selection::Levels, Selection::Paper]
        .map(|selection| render(&corner(), &small().changed(|s| s.pbgi.selection = selection)));
    for what in ["primary_bits", "seen_bits", "under_bits"] {
        assert!(bits(&ours, what) == bits(&paper, what), "{what}");
    }
    let [ours_needed, paper_needed] = [&ours, &paper].map(|rendered| bits(rendered, "needed_bits"));
    let more = bits_more(&ours_needed, &paper_needed).expect("the paper's order must light what ours does");
    assert!(more > 0, "the same here: the scene tells nothing");
    assert!(bits_more(&paper_needed, &ours_needed).is_none());
    assert!(bits_more(&bits(&paper, "known_bits"), &bits(&ours, "known_bits")).is_some());
    assert_eq!(ours.counts().needed_count + more, paper.counts().needed_count);
}

/// Flakes that lie in all directions: hardly any two have a mean normal, so that each leaf is a primary point.
fn flakes() -> Scene {
    let mut random = Random::new(3);
    let mut flake = || {
        let mut any = |size: f32| Vec3::from_array([0; 3].map(|_| size * (2.0 * random.unit() - 1.0)));
        let (place, u, v) = (any(1.0), any(0.03), any(0.03));
        [place, place + u, place + u + v, place + v]
    };
    let quads: Vec<_> = (0..4000).map(|_| flake()).collect();
    let mut scene = under_sky(scene_from_quads("flakes", &quads, diffuse("grey", Vec3::splat(0.5))));
    scene.cameras = vec![camera(Vec3::new(0.0, 0.0, 4.0), Vec3::NEG_Z, 0.7)];
    scene
}

#[test]
fn there_is_room_for_as_many_primary_points_as_the_camera_finds() {
    let settings = small().changed(|s| (s.pbgi.points, s.picture.size) = (1 << 14, Size { width: 16, height: 9 }));
    let counts = render(&flakes(), &settings).counts();
    // More than a picture of this size has room for by itself.
    assert!(counts.primary_count > 4200 && counts.primaries_lost == 0, "{counts:?}");
}

#[test]
fn primary_points_without_room_are_dropped_and_told() {
    let test = common::gpu();
    let (scene, settings) = (flakes(), small());
    let mut uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
    uploaded.spread_points(&scene, Some(12)).unwrap();
    let job = Job::new(&test.gpu, &uploaded, &scene.cameras[0], &settings);
    let submitted = |mut renderer: Renderer| {
        let ticket = renderer.submit().unwrap();
        renderer.wait(ticket).unwrap();
        renderer
    };
    let whole = submitted(Renderer::new(&job).unwrap());
    assert_eq!(whole.complaint().unwrap(), None);
    let mut shapes = whole.shapes().clone();
    shapes.of_mut::<PbgiShape>().unwrap().primary_capacity = 100;
    let renderer = submitted(Renderer::with_shapes(&job, shapes).unwrap());
    let complaint = renderer.complaint().unwrap().expect("most primary points have no room");
    assert!(complaint.contains("room for 100:") && complaint.contains("lacks light"), "{complaint}");
    assert!(renderer.read_radiance().unwrap().iter().all(|value| value.is_finite() && *value >= 0.0));
}

/// A frame of an awkward scene: every number of it is one.
fn sound(scene: &Scene, settings: &Settings) -> Rendered {
    let rendered = render(scene, settings);
    let wrong = rendered.radiance.iter().find(|radiance| !(radiance.min_element() >= 0.0 && radiance.is_finite()));
    assert_eq!(wrong, None);
    let counts = rendered.written.last::<CacheCounts>("cache_counts")[0];
    assert_eq!((counts.lost_references, rendered.counts().primaries_lost), (0, 0));
    rendered
}

/// Both ways of filling micro-buffers.
fn both_ways() -> [Settings; 2] {
    [MicroFill::Rays, MicroFill::Points].map(|micro| small().changed(|s| s.pbgi.micro = micro))
}

/// A scene under a white sky seen from above.
fn seen_from_above(scene: Scene, distance: f32) -> Scene {
    let mut scene = under_sky(scene);
    scene.materials[0] = diffuse("grey", Vec3::splat(0.5));
    scene.cameras = vec![camera(Vec3::new(0.0, distance, 0.1 * distance), Vec3::new(0.0, -1.0, -0.1).normalize(), 0.6)];
    scene
}

/// Of the pixel in the middle.
fn centre(rendered: &Rendered) -> Vec3 {
    rendered.radiance[27 * 96 + 48]
}

#[test]
fn one_triangle_has_all_of_the_sky() {
    let mut scene = plane(2.0);
    scene.indices.truncate(3);
    scene.triangle_materials.truncate(1);
    scene.draws[0].index_count = 3;
    // The half with the corner at +x, +z is left.
    let mut scene = seen_from_above(scene, 3.0);
    scene.cameras[0].position_ws.x = 0.4;
    for settings in both_ways() {
        let found = centre(&sound(&scene, &settings));
        assert!(near(found, Vec3::splat(0.5), 1e-3), "{found}");
    }
}

#[test]
fn more_points_than_a_surface_needs_are_harmless() {
    // A pixel has hundreds of leaves.
    let settings = small().changed(|s| {
        s.pbgi.points = 1 << 16;
        s.picture.size = Size { width: 16, height: 9 };
    });
    let rendered = sound(&seen_from_above(plane(1.0), 1.2), &settings);
    let found = rendered.radiance[4 * 16 + 8];
    assert!(near(found, Vec3::splat(0.5), 1e-3), "{found}");
}

#[test]
fn points_may_all_lie_at_one_place() {
    // So far from the origin that positions have steps as large as the surface.
    let far = Vec3::splat(1000.0);
    let size = 1e-4;
    let corners = [Vec3::new(0.0, 0.0, size), Vec3::new(size, 0.0, size), Vec3::new(size, 0.0, 0.0), Vec3::ZERO];
    let mut scene =
        under_sky(scene_from_quads("speck", &[corners.map(|corner| far + corner)], diffuse("grey", Vec3::splat(0.5))));
    scene.cameras = vec![camera(far + Vec3::new(0.0, 3e-4, 2e-4), Vec3::new(0.0, -1.0, -0.5).normalize(), 0.8)];
    scene.cameras[0].near = 1e-5;
    let cloud = PointCloud::of_scene(&scene, 12).unwrap();
    let places: std::collections::BTreeSet<_> =
        (4096..8192).map(|node| cloud.node(node).centroid_ws.to_array().map(f32::to_bits)).collect();
    assert!(places.len() <= 9, "{} places", places.len());
    for settings in both_ways() {
        sound(&scene, &settings);
    }
}

/// A plane whose texture has these alphas by turns.
fn masked(alphas: [u8; 2]) -> Scene {
    let mut scene = seen_from_above(plane(3.0), 4.0);
    let texel = |i: u32| [255, 255, 255, alphas[((i % 64 / 8 + i / 64 / 8) % 2) as usize]];
    let rgba = (0..64 * 64).flat_map(texel).collect();
    scene.textures = vec![Texture { name: "mask".into(), width: 64, height: 64, rgba }];
    scene.materials[0].base_color_texture = Some(0);
    scene.materials[0].alpha_cutoff = Some(0.5);
    scene
}

#[test]
fn everything_may_be_masked() {
    for settings in both_ways() {
        let rendered = sound(&masked([255, 0]), &settings);
        // Through the holes the sky is seen.
        let count =
            |value: f32| rendered.radiance.iter().filter(|found| near(**found, Vec3::splat(value), 0.02)).count();
        assert!(count(1.0) > 1000 && count(0.5) > 500, "{} of the sky, {} lit by it", count(1.0), count(0.5));
    }
    let error = PointCloud::of_scene(&masked([0, 0]), 12).map(|_| ()).unwrap_err().to_string();
    assert_eq!(error, "scene plane has no visible surface for points to lie on");
}

#[test]
fn a_camera_inside_a_solid_sees_darkness() {
    let mut scene = box_room(2.0, Vec3::splat(0.5));
    // Its front faces outwards.
    for triangle in scene.indices.chunks_exact_mut(3) {
        triangle.swap(1, 2);
    }
    let mut scene = under_sky(scene);
    scene.cameras = vec![camera(Vec3::splat(0.1), Vec3::new(0.3, -0.2, -1.0).normalize(), 1.0)];
    for settings in both_ways() {
        let rendered = sound(&scene, &settings);
        if settings.pbgi.micro == MicroFill::Rays {
            assert!(rendered.radiance.iter().all(|found| near(*found, Vec3::ZERO, 1e-6)), "{}", centre(&rendered));
        }
    }
}

#[test]
fn a_camera_that_sees_nothing_sees_the_sky() {
    for (position_ws, forward_ws) in [(Vec3::new(0.0, 2.0, 0.0), Vec3::Y), (Vec3::new(0.0, 5.0, 1e5), Vec3::Z)] {
        let mut scene = seen_from_above(plane(2.0), 3.0);
        scene.cameras = vec![camera(position_ws, forward_ws, 0.8)];
        for settings in both_ways() {
            let rendered = sound(&scene, &settings);
            assert!(rendered.radiance.iter().all(|found| near(*found, Vec3::ONE, 1e-4)), "{}", centre(&rendered));
            assert_eq!(rendered.counts().primary_count, 0);
        }
    }
}

#[test]
fn a_camera_far_outside_sees_the_scene_as_a_speck() {
    let mut scene = seen_from_above(plane(2.0), 3.0);
    scene.cameras = vec![camera(Vec3::new(0.0, 500.0, 0.0), Vec3::new(1e-4, -1.0, 0.0).normalize(), 0.3)];
    for settings in both_ways() {
        let rendered = sound(&scene, &settings);
        assert!(rendered.counts().primary_count <= 2, "{:?}", rendered.counts());
    }
}
