//! Point-based global illumination with each of its ways of selection.

mod common;

use common::points::{Rendered, render, under_sky};
use common::rooms::{add_quad, camera};
use glam::Vec3;
use gridlight::scene::Scene;
use gridlight::scene::testing::{diffuse, scene_from_quads};
use gridlight::settings::{Selection, Settings, Size, Technique};

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
