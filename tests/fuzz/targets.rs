//! What reads files, each with its seeds.

use std::path::Path;

use gridlight::compare::{TimingComparison, TimingsFile};
use gridlight::files::pictures::{read_exr, read_png};
use gridlight::points::PointCloud;
use gridlight::report::dump::diff;
use gridlight::scene::{bvh, gltf};
use gridlight::settings::Settings;
use gridlight::{Result, environment};

use super::seeds::{self, Seed};

/// How a file is changed.
#[derive(Clone, Copy, PartialEq)]
pub enum Shape {
    /// By what its name says: JSON in `.json`, `.gltf` and `.glb`, chunks in `.png`, bytes in all else.
    ByName,
    /// As lines of words, but for JSON.
    Text,
}

/// A reader of files.
pub struct Target {
    pub name: &'static str,
    pub shape: Shape,
    pub seeds: fn() -> Vec<Seed>,
    /// Reads the file, and uses what it says as the program does.
    pub read: fn(&Path) -> Result<()>,
    /// Of so many inputs one is for this target, in parts of the sum.
    pub share: usize,
}

pub const TARGETS: &[Target] = &[
    Target { name: "scene", shape: Shape::ByName, seeds: seeds::scenes, read: scene, share: 8 },
    Target { name: "texture", shape: Shape::ByName, seeds: seeds::textures, read: texture, share: 3 },
    Target { name: "picture", shape: Shape::ByName, seeds: seeds::pictures, read: picture, share: 3 },
    Target { name: "environment", shape: Shape::ByName, seeds: seeds::environments, read: environment, share: 2 },
    Target { name: "settings", shape: Shape::Text, seeds: seeds::settings, read: settings, share: 2 },
    Target { name: "timings", shape: Shape::ByName, seeds: seeds::timings, read: timings, share: 1 },
    Target { name: "dump", shape: Shape::ByName, seeds: seeds::dump_files, read: dump, share: 2 },
    #[cfg(feature = "window")]
    Target { name: "script", shape: Shape::Text, seeds: seeds::scripts, read: script, share: 1 },
];

/// Larger scenes are read and not used: building their trees would take all the time.
const MOST_TRIANGLES: usize = 2000;

fn scene(path: &Path) -> Result<()> {
    let mut scene = gltf::load(path, &|_, _, _| ())?;
    scene.play(Some("all")).or_else(|_| scene.play(None))?;
    for time_s in [0.0, 0.7, 1e9] {
        scene.pose(time_s);
    }
    if scene.indices.len() <= 3 * MOST_TRIANGLES {
        bvh::build(&scene).check_depth()?;
        let _ = PointCloud::of_scene(&scene, 4)?;
    }
    Ok(())
}

fn texture(path: &Path) -> Result<()> {
    let scene = path.with_extension("scene.glb");
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    std::fs::write(&scene, seeds::textured(&name)).expect("the folder can be written");
    gltf::load(&scene, &|_, _, _| ()).map(drop)
}

fn picture(path: &Path) -> Result<()> {
    let is_png = path.extension().is_some_and(|extension| extension == "png");
    if is_png { read_png(path).map(drop) } else { read_exr(path).map(drop) }
}

fn environment(path: &Path) -> Result<()> {
    environment::file::read(path).map(|environment| drop(environment.with_suns_apart()))
}

fn settings(path: &Path) -> Result<()> {
    Settings::read(path)?.validate()
}

fn timings(path: &Path) -> Result<()> {
    let (_, whole) = seeds::timings().remove(0);
    let reference = path.with_extension("reference.json");
    std::fs::write(&reference, whole).expect("the folder can be written");
    let (reference, test) = (TimingsFile::read(&reference)?, TimingsFile::read(path)?);
    for found in [TimingComparison::new(&reference, &test), TimingComparison::new(&test, &reference)] {
        let _ = found.regressions(5.0);
        let _ = gridlight::compare::table::timing_table(&found, Some(5.0), true);
    }
    Ok(())
}

/// The file takes the place of the one of its name in a dump, which is compared with one that is whole.
fn dump(path: &Path) -> Result<()> {
    let (whole, changed) = (path.with_extension("whole"), path.with_extension("changed"));
    if !whole.exists() {
        seeds::write_dump(&whole);
    }
    seeds::write_dump(&changed);
    let name = path.file_name().unwrap_or_default();
    std::fs::copy(path, changed.join(name)).expect("the folder can be written");
    let options = diff::Options { tolerance: 1e-3, ignore_settings: true };
    for (a, b) in [(&whole, &changed), (&changed, &whole)] {
        let found = diff::compare(a, b, options)?;
        let _ = (found.table(), found.sentence());
    }
    Ok(())
}

#[cfg(feature = "window")]
fn script(path: &Path) -> Result<()> {
    let mut script = gridlight::app::window::Script::read(path)?;
    while script.next(u64::MAX).is_some() {}
    Ok(())
}
