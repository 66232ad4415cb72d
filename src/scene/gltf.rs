//! Reads glTF 2.0 files (`.gltf` with its files, `.glb`) into a [`Scene`].
//!
//! The file is not trusted: whatever is in it, the outcome is a scene or an error that names the fault.

use std::ffi::OsStr;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use glam::Vec3;

use super::default_camera::default_camera;
use super::gltf_buffers::Document;
use super::gltf_materials::{default_material, mappings, materials};
use super::gltf_mesh::{Geometry, is_lost};
use super::gltf_nodes::{Found, default_sun, walk};
use super::gltf_textures::decode_images;
use super::motion::Motion;
use super::{Aabb, Draw, Light, LitBy, Material, Scene, Vertex};
use crate::camera::nearly_parallel;
use crate::files::read_whole;
use crate::{Error, Result, interrupt};

/// Loads a scene from a file. `progress` hears a stage (`buffers`, `meshes`, `textures`), the steps done and their number.
///
/// # Errors
/// [`Error::File`] for everything that is wrong with the file or with those it refers to.
pub fn load(path: &Path, progress: &dyn Fn(&str, u64, u64)) -> Result<Scene> {
    load_scene(path, None, progress)
}

/// The same for a scene of the file by its name, or by its index from 0; without one for the file's default scene.
///
/// # Errors
/// Those of [`load`]; [`Error::Usage`] when there is no such scene.
pub fn load_scene(path: &Path, wanted: Option<&str>, progress: &dyn Fn(&str, u64, u64)) -> Result<Scene> {
    check_file(path)?;
    let bytes = read_whole(path, interrupt::requested).map_err(|error| match error.kind() {
        ErrorKind::Interrupted => Error::Interrupted(format!("interrupted while {} was read", path.display())),
        _ => unreadable(path, &error),
    })?;
    let base = path.parent().map_or_else(PathBuf::new, Path::to_path_buf);
    let name = path.file_stem().map_or_else(|| "scene".into(), OsStr::to_string_lossy);
    let mut document = Document::parse(path, Some(base), &bytes, progress)?;
    if let Some(wanted) = wanted {
        document.choose_scene(wanted)?;
    }
    assemble(&name, &document, progress)
}

/// Finds out whether a file may be a scene, without reading it.
///
/// # Errors
/// [`Error::File`] when it is not there or, by its name, of another format.
pub fn check_file(path: &Path) -> Result<()> {
    if let Some(format) = other_format(path) {
        let advice = "is not read: convert it to glTF (.gltf, .glb), with Blender's export for example";
        return Err(Error::file(path, format_args!("{format} {advice}")));
    }
    std::fs::metadata(path).map(drop).map_err(|e| unreadable(path, &e))
}

fn unreadable(path: &Path, error: &std::io::Error) -> Error {
    Error::file(path, format_args!("the scene file cannot be read: {error}"))
}

/// The name of a format that people have scenes in and that is not glTF, by the file's name.
fn other_format(path: &Path) -> Option<&'static str> {
    let extension = path.extension()?.to_str()?.to_ascii_lowercase();
    let formats: [(&str, &[&str]); 8] = [
        ("Wavefront OBJ", &["obj"]),
        ("FBX", &["fbx"]),
        ("USD", &["usd", "usda", "usdc", "usdz"]),
        ("COLLADA", &["dae"]),
        ("Blender's format", &["blend"]),
        ("3D Studio's format", &["3ds", "max"]),
        ("STL", &["stl"]),
        ("PLY", &["ply"]),
    ];
    formats.into_iter().find(|(_, extensions)| extensions.contains(&extension.as_str())).map(|(name, _)| name)
}

/// Loads a scene from the bytes of a GLB (or of a `.gltf` without external files), `name` standing for its path.
///
/// # Errors
/// [`Error::File`] for everything that is wrong with the bytes, external files included.
pub fn load_bytes(name: &str, glb: &[u8], progress: &dyn Fn(&str, u64, u64)) -> Result<Scene> {
    let document = Document::parse(Path::new(name), None, glb, progress)?;
    assemble(name, &document, progress)
}

/// Loads one of the scenes of such a file by its name, whichever the file shows first.
///
/// # Errors
/// Those of [`load_bytes`]; also when there is no such scene.
pub fn load_scene_of(name: &str, glb: &[u8], scene: &str, progress: &dyn Fn(&str, u64, u64)) -> Result<Scene> {
    let mut document = Document::parse(Path::new(name), None, glb, progress)?;
    document.choose_scene(scene)?;
    assemble(name, &document, progress)
}

fn assemble(name: &str, document: &Document, progress: &dyn Fn(&str, u64, u64)) -> Result<Scene> {
    let mut found = walk(document)?;
    let mut motion = Motion::read(document, &found)?;
    let mappings = mappings(document);
    let (mut materials, images) = materials(document, &mappings);
    let geometry = gather(document, &found, Geometry::new(&materials, &mappings), &mut motion, progress)?;
    let textures = decode_images(document, &images, &mut materials, progress)?;
    let Geometry { mut vertices, mut tangents, corners, has_colors, .. } = geometry;
    motion.pose_at_rest(&mut vertices, &mut tangents);
    if let Some(what) = motion.find_lost(|vertex| is_lost(vertex.position_ws.into()), &vertices) {
        return Err(document.error(format_args!("{what} has a vertex position that is not finite or too far")));
    }
    let runs = Runs::new(corners, &mut materials);
    // The default material is there only if something uses it.
    materials.iter_mut().zip(has_colors).for_each(|(material, has)| material.has_vertex_colors = has);
    if runs.indices.is_empty() {
        return Err(document.error("the scene has no triangles"));
    }
    document.remarks().iter().for_each(|remark| log::warn!("{remark}"));
    let bounds = bounds(&vertices, &runs.indices);
    for (index, half_height) in std::mem::take(&mut found.parallel) {
        found.cameras[index] = nearly_parallel(&found.cameras[index], half_height, bounds.center(), bounds.radius());
    }
    motion.set_cameras(&found.cameras);
    if found.cameras.is_empty() {
        log::info!("the scene has no camera: it gets one named `default`");
        found.cameras.push(default_camera(&vertices, &runs.indices, &bounds));
    }
    let lit_by = lit_by(&found, &runs.draws, &materials);
    if found.lights.is_empty() {
        found.lights.push(if lit_by == LitBy::Nothing { default_sun() } else { Light::DARK });
    }
    let Runs { indices, triangle_materials, draws } = runs;
    let Found { cameras, lights, .. } = found;
    let name = name.to_owned();
    Ok(Scene {
        name,
        vertices,
        tangents,
        indices,
        triangle_materials,
        draws,
        materials,
        textures,
        cameras,
        lights,
        lit_by,
        environment: None,
        sky_sun: None,
        motion: motion.or_nothing(),
        bounds,
    })
}

/// What of the scene's light is the file's.
fn lit_by(found: &Found, draws: &[Draw], materials: &[Material]) -> LitBy {
    match () {
        () if found.is_dark || !found.lights.is_empty() => LitBy::Lights,
        () if draws.iter().any(|draw| materials[draw.material as usize].is_lamp()) => LitBy::EmissiveSurfaces,
        () => LitBy::Nothing,
    }
}

/// The triangles of all meshes of the scene, with a note of each kind of thing left out.
fn gather(
    document: &Document,
    found: &Found,
    mut geometry: Geometry,
    motion: &mut Motion,
    progress: &dyn Fn(&str, u64, u64),
) -> Result<Geometry> {
    let moved = motion.moved_nodes();
    let total = found.instances.len() as u64;
    progress("meshes", 0, total);
    geometry.compute_ahead(document, &found.instances)?;
    for (i, instance) in found.instances.iter().enumerate() {
        progress("meshes", i as u64, total);
        let moves = motion.carries(document, instance, &moved);
        geometry.add(document, instance, motion, moves)?;
    }
    progress("meshes", total, total);
    if geometry.not_triangles > 0 {
        document.ignore(format!("{} primitives of points or lines", geometry.not_triangles));
    }
    if geometry.incomplete > 0 {
        document.ignore(format!("the incomplete last triangles of {} primitives", geometry.incomplete));
    }
    if geometry.degenerate > 0 {
        log::info!("{} triangles without an area are left out", geometry.degenerate);
    }
    Ok(geometry)
}

/// Triangles in the order of their materials.
struct Runs {
    indices: Vec<u32>,
    triangle_materials: Vec<u32>,
    draws: Vec<Draw>,
}

impl Runs {
    /// Concatenates the corners of each material; adds the default material when something uses it or there is none.
    fn new(corners: Vec<Vec<u32>>, materials: &mut Vec<Material>) -> Self {
        let mut runs = Self { indices: Vec::new(), triangle_materials: Vec::new(), draws: Vec::new() };
        if materials.is_empty() || corners.last().is_some_and(|c| !c.is_empty()) {
            materials.push(default_material());
        }
        runs.indices.reserve_exact(corners.iter().map(Vec::len).sum());
        for (material, corners) in (0u32..).zip(corners) {
            if corners.is_empty() {
                continue;
            }
            let (first_index, index_count) = (runs.indices.len() as u32, corners.len() as u32);
            runs.draws.push(Draw { first_index, index_count, material });
            runs.triangle_materials.resize(runs.triangle_materials.len() + corners.len() / 3, material);
            runs.indices.extend(corners);
        }
        runs
    }
}

/// Bounds of the vertices that triangles use.
pub(super) fn bounds(vertices: &[Vertex], indices: &[u32]) -> Aabb {
    let empty = Aabb { min: Vec3::MAX, max: Vec3::MIN };
    indices.iter().fold(empty, |bounds, i| {
        let p = Vec3::from_array(vertices[*i as usize].position_ws);
        Aabb { min: bounds.min.min(p), max: bounds.max.max(p) }
    })
}

#[cfg(test)]
#[path = "gltf_tests.rs"]
mod tests;

#[cfg(test)]
#[path = "gltf_robustness_tests.rs"]
mod robustness;

#[cfg(test)]
#[path = "gltf_case_tests.rs"]
mod case_tests;

#[cfg(test)]
#[path = "gltf_parts_tests.rs"]
mod parts_tests;

#[cfg(all(test, feature = "codecs"))]
#[path = "gltf_extension_tests.rs"]
mod extension_tests;

#[cfg(all(test, feature = "codecs"))]
#[path = "gltf_draco_tests.rs"]
mod draco_tests;

#[cfg(all(test, feature = "codecs"))]
#[path = "gltf_meshopt_tests.rs"]
mod meshopt_tests;

#[cfg(test)]
#[path = "gltf_tangent_tests.rs"]
mod tangent_tests;
