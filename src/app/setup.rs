//! What every way to render begins with: a device, a scene on it, a camera.

use std::cell::RefCell;
use std::path::Path;
use std::sync::Arc;

use directories::ProjectDirs;

use super::lighting;
use crate::gpu::{Gpu, GpuOptions};
use crate::progress::{Bar, Progress};
use crate::renderer::UploadedScene;
use crate::report::timings::SceneInfo;
use crate::scene::{Camera, Scene, gltf};
use crate::settings::{DeviceSettings, EnvironmentSettings, MotionSettings, SceneSettings, Settings, SunPlace};
use crate::{Error, Result, camera, techniques};

/// The scene shown when none is named.
const COURTYARD: &[u8] = include_bytes!("../../assets/courtyard.glb");

/// The scene of its file that moves.
const COURTYARD_IN_MOTION: &str = "courtyard in motion";

/// The device that the settings ask for.
pub(super) fn open_gpu(settings: &Settings) -> Result<Arc<Gpu>> {
    Gpu::new(&gpu_options(settings))
}

/// What has to be said of a driver that renders on the CPU; nobody may take its times for those of a GPU.
pub(super) fn cpu_note(gpu: &Gpu, settings: &Settings) -> Option<&'static str> {
    let note = match settings.device.gpu {
        Some(_) => "a CPU driver",
        None => "a CPU driver: no suitable GPU was found (--list-gpus)",
    };
    gpu.report().is_cpu().then_some(note)
}

/// How the settings want the device opened.
pub(super) fn gpu_options(settings: &Settings) -> GpuOptions {
    let folders = || ProjectDirs::from("", "", env!("CARGO_PKG_NAME"));
    let DeviceSettings { gpu, validation, no_pipeline_cache, .. } = &settings.device;
    GpuOptions {
        select: gpu.clone(),
        validation: *validation,
        baseline_only: false,
        pipeline_folder: if *no_pipeline_cache { None } else { folders().map(|found| found.cache_dir().to_owned()) },
    }
}

/// The scene that the settings ask for, with a progress bar for each step.
pub(super) fn load_scene(settings: &Settings, progress: &Progress) -> Result<Scene> {
    let bar: RefCell<Option<(String, Bar)>> = RefCell::new(None);
    let report = |step: &str, done: u64, total: u64| {
        let mut current = bar.borrow_mut();
        if current.as_ref().is_none_or(|(name, _)| name != step) {
            *current = Some((step.to_owned(), progress.bar(step, total)));
        }
        if let Some((_, bar)) = current.as_ref() {
            bar.set(done);
        }
    };
    let SceneSettings { file, scene_name, sun, .. } = &settings.scene;
    let file = file.as_deref().map(|file| (file, scene_name.as_deref()));
    let moves = settings.motion.is_asked_for(settings.output.is_sequence());
    read_scene((file, moves), *sun, &settings.motion, &settings.environment, &report)
}

/// The scene of a file, the one of this name or its default, or the built-in one, at the moment that is asked for, with the
/// sun where it is asked for, in its environment. The built-in one is another, in which things move, if it `moves`.
pub(super) fn read_scene(
    (file, moves): (Option<(&Path, Option<&str>)>, bool),
    sun: Option<SunPlace>,
    motion: &MotionSettings,
    environment: &EnvironmentSettings,
    report: &dyn Fn(&str, u64, u64),
) -> Result<Scene> {
    let mut scene = match file {
        Some((path, name)) => gltf::load_scene(path, name, report),
        None if moves => gltf::load_scene_of("courtyard", COURTYARD, COURTYARD_IN_MOTION, report),
        None => gltf::load_bytes("courtyard", COURTYARD, report),
    }?;
    scene.play(motion.animation.as_deref())?;
    scene.pose(motion.time_s);
    lighting::light(&mut scene, sun, environment)?;
    Ok(scene)
}

/// The scene on the device, with what the settings trace rays with, and the points that their technique needs.
pub(super) fn upload(gpu: &Arc<Gpu>, scene: &Scene, settings: &Settings, progress: &Progress) -> Result<UploadedScene> {
    let bar = progress.bar("BVH", 1);
    let mut uploaded = UploadedScene::with_rays(gpu, scene, settings.tracing.rays)?;
    bar.set(1);
    uploaded.spread_points(scene, techniques::of(settings)?.point_count_log2(settings))?;
    Ok(uploaded)
}

/// The camera of that name or index, or at that place; the first when none is named.
pub(super) fn find_camera(scene: &Scene, wanted: Option<&str>) -> Result<Camera> {
    let first = scene.cameras.first();
    let found = match wanted {
        None => first.cloned(),
        Some(name) => {
            let named = scene.cameras.iter().find(|c| c.name == name);
            let named = named.or_else(|| scene.cameras.get(name.parse::<usize>().ok()?));
            named.cloned().or_else(|| camera::from_setting(name, first?))
        }
    };
    found.ok_or_else(|| {
        let names: Vec<&str> = scene.cameras.iter().map(|c| c.name.as_str()).collect();
        Error::Usage(format!(
            "--camera {} is not in the scene; its cameras are {}",
            wanted.unwrap_or_default(),
            names.join(", ")
        ))
    })
}

/// What a report says of the scene.
pub(super) fn scene_info(settings: &Settings, scene: &Scene, camera: &Camera) -> SceneInfo {
    SceneInfo {
        name: scene.name.clone(),
        path: settings.scene.file.as_ref().map(|p| p.display().to_string()),
        triangles: scene.indices.len() as u64 / 3,
        cameras: scene.cameras.iter().map(|c| c.name.clone()).collect(),
        camera: camera.name.clone(),
        sun: settings.scene.sun.map(|sun| sun.to_string()),
        environment: lighting::source(scene, &settings.environment).to_string(),
        has_sky_for_lack_of_light: lighting::has_sky_for_lack_of_light(scene, &settings.environment),
    }
}
