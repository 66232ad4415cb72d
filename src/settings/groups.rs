//! The groups of settings that do not depend on the technique.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::group::{Validate, settings_group};
use super::validate::{above_zero, at_least_one, has_extension, require};
use super::values::name_or_index;
use super::{
    BackFaces, Exposure, PixelPlace, PresentMode, Rays, RenderScale, Size, SunPlace, Switch, Technique, TextureFilter,
    ToneMap, View,
};
use crate::Result;
use crate::files::{FileKind, sequence};

/// Most stops of `--exposure-compensation`, up and down.
const MOST_STOPS: f32 = 32.0;

settings_group! {
    /// What is looked at, from where, and under which sun.
    #[command(next_help_heading = "Picture")]
    pub struct SceneSettings: Scene {
        /// glTF or GLB file to render [default: the built-in scene]
        #[arg(id = "scene", value_name = "SCENE", help_heading = "Run")]
        #[serde(serialize_with = "path_as_text")]
        pub file as "scene": Option<PathBuf> = None,
        /// Scene of the file, by name or by index from 0 [default: the one that the file names, or the first]
        #[arg(long, visible_alias = "scene", value_name = "NAME|INDEX")]
        #[serde(deserialize_with = "name_or_index")]
        pub scene_name: Option<String> = None,
        /// Camera of the scene, by name or by index from 0, or a position and view as the window saves them:
        /// X,Y,Z,AZIMUTH,HEIGHT,YFOV in metres and degrees [default: the first, or one inside a room and outside
        /// anything else]
        #[arg(long, value_name = "NAME|INDEX|PLACE", allow_hyphen_values = true)]
        #[serde(deserialize_with = "name_or_index")]
        pub camera: Option<String> = None,
        /// Direction of the scene's first directional light, in degrees: azimuth 0 is along -z and 90 along x; height above the horizon
        /// [default: as in the scene]
        #[arg(long, value_name = "AZIMUTH,HEIGHT", allow_hyphen_values = true)]
        pub sun: Option<SunPlace> = None,
    }
}

settings_group! {
    /// How a run goes.
    #[command(next_help_heading = "Run")]
    pub struct RunSettings: Run {
        /// Render without a window; needs no display
        #[arg(long)]
        pub headless: bool = false,
        /// Measured frames, 1 or more [default: 1]
        #[arg(long, value_name = "N")]
        pub frames: u32 = 1,
        /// Frames rendered before the measured ones [default: 0]
        #[arg(long, value_name = "N")]
        pub warmup: u32 = 0,
    }
}

settings_group! {
    /// What every picture has, whatever it shows.
    #[command(next_help_heading = "Picture")]
    pub struct PictureSettings: Picture {
        /// Size in pixels [default: 1280x720]
        #[arg(long, value_name = "WxH")]
        pub size: Size = Size { width: 1280, height: 720 },
        /// Factor on the radiance in PNG pictures, above 0, or `auto`: from the picture's histogram [default: auto]
        #[arg(long, value_name = "auto|FACTOR", allow_negative_numbers = true)]
        pub exposure: Exposure = Exposure::Auto,
        /// Exposure compensation in stops, on top of the exposure, -32 to 32 [default: 0]
        #[arg(long, value_name = "STOPS", allow_negative_numbers = true)]
        pub exposure_compensation: f32 = 0.0,
        /// Tone curve of PNG pictures and the window [default: neutral]
        #[arg(long, value_enum, hide_possible_values = true, value_name = "reinhard|agx|neutral")]
        pub tone_map: ToneMap = ToneMap::Neutral,
        /// Whether the camera sees the backs of single-sided surfaces; light meets them either way [default: keep]
        #[arg(long, value_enum, hide_possible_values = true, value_name = "keep|cull")]
        pub back_faces: BackFaces = BackFaces::Keep,
        /// Texture filter of what the camera sees: anisotropic, or trilinear, which blurs surfaces seen at a flat angle and is much
        /// cheaper on a CPU driver [default: anisotropic, where the device has it]
        #[arg(long, value_enum, hide_possible_values = true, value_name = "anisotropic|trilinear")]
        pub texture_filter: TextureFilter = TextureFilter::Anisotropic,
    }
}

settings_group! {
    /// What the picture shows, and which technique renders it.
    #[command(next_help_heading = "Method")]
    pub struct RenderSettings: Technique {
        /// What the picture shows: final, albedo, normal, depth, motion-vectors, direct, environment-visibility,
        /// indirect, shadow-ratio, shadow-ratio-filtered, selected-level, lights-tested, light-count, level-weights, vpls, or for
        /// pbgi primary-points, secondary-points (both also with -above), cache-count, cache-weights or cache-misses;
        /// all writes each to a file named after --output [default: final]
        #[arg(long, value_enum, hide_possible_values = true, value_name = "NAME", help_heading = "Picture")]
        pub view: View = View::Final,
        /// The lighting grid hierarchy, point-based global illumination, final gathering over the hierarchy, direct light
        /// alone, or a reference: every light at every pixel, path tracing, or every point lit and gathered at every pixel
        /// [default: lgh]
        #[arg(long, value_enum, hide_possible_values = true, value_name = "lgh|pbgi|final-gather|direct|brute-force|path-trace|pbgi-reference")]
        pub technique: Technique = Technique::Lgh,
        /// Mean of this many frames with fresh seeds and sub-pixel jitter, 1 or more [default: 1]
        #[arg(long, value_name = "N")]
        pub accumulate: u32 = 1,
        /// Temporal anti-aliasing: frames sample their pixels elsewhere than those before, and their mean follows what moves [default: off]
        #[arg(long, value_enum, hide_possible_values = true, value_name = "on|off", help_heading = "Picture")]
        pub taa: Switch = Switch::Off,
        /// Direct light [default: on]
        #[arg(long, value_enum, hide_possible_values = true, value_name = "on|off")]
        pub direct: Switch = Switch::On,
    }
}

settings_group! {
    /// What light is traced with, whatever the technique.
    #[command(next_help_heading = "Method")]
    pub struct TracingSettings: Parameters {
        /// Seed of every random number, 0 to 4294967295 [default: 1]
        #[arg(long, value_name = "N")]
        pub seed: u32 = 1,
        /// Ray tracing: by the BVH in shaders, or by hardware acceleration structures (ray queries)
        /// [default: bvh]
        #[arg(long, value_enum, hide_possible_values = true, value_name = "bvh|query", help_heading = "Shadows")]
        pub rays: Rays = Rays::Bvh,
    }
}

settings_group! {
    /// What renders, and how it is treated.
    #[command(next_help_heading = "Device")]
    pub struct DeviceSettings: Device {
        /// Device, by its index in --list-gpus or by a part of its name [default: the most capable]
        #[arg(long, value_name = "INDEX|NAME")]
        #[serde(deserialize_with = "name_or_index")]
        pub gpu: Option<String> = None,
        /// Run with the Vulkan validation layers; any message is a failure (exit 4)
        #[arg(long)]
        pub validation: bool = false,
        /// Target for the longest submission to the device in milliseconds, above 0: frames are split between passes, reference
        /// techniques between parts of the picture [default: 200]
        #[arg(long, value_name = "MS", allow_negative_numbers = true)]
        pub max_submit_ms: f32 = 200.0,
        /// Neither read nor write the pipeline cache in the user's cache folder
        #[arg(long)]
        pub no_pipeline_cache: bool = false,
    }
}

settings_group! {
    /// How a window shows pictures.
    #[command(next_help_heading = "Window")]
    pub struct WindowSettings: Window {
        /// Vulkan present mode: wait for vertical blank, show the newest picture, show it immediately, or wait unless
        /// it is late [default: fifo]
        #[arg(long, value_enum, hide_possible_values = true, value_name = "fifo|mailbox|immediate|fifo-relaxed")]
        pub present_mode: PresentMode = PresentMode::Fifo,
        /// Resolution scale of the picture in the window, per axis, 0.05 to 1, or `auto`: 1 at rest, and in motion what
        /// keeps about 10 frames per second [default: auto]
        #[arg(long, value_name = "auto|F", allow_negative_numbers = true)]
        pub render_scale: RenderScale = RenderScale::Auto,
    }
}

settings_group! {
    /// The files that a run leaves.
    #[command(next_help_heading = "Output")]
    pub struct OutputSettings: Run {
        /// Write the last frame: .exr (linear radiance) or .png (exposed, tone-mapped); {frame} in the name writes every measured
        /// frame, with its number there
        #[arg(id = "output", short = 'o', long = "output", value_name = "PATH")]
        #[serde(serialize_with = "path_as_text")]
        pub picture as "output": Option<PathBuf> = None,
        /// Write the timings: .json (statistics, settings, counts) or .csv (every frame and pass); may be given twice, for both
        #[arg(long, value_name = "PATH")]
        #[serde(serialize_with = "paths_as_text", deserialize_with = "one_path_or_more")]
        pub timings: Vec<PathBuf> = Vec::new(),
        /// Write every intermediate of the last frame into this new or empty folder (docs/dumps.md)
        #[arg(long, value_name = "DIR")]
        #[serde(serialize_with = "path_as_text")]
        pub dump: Option<PathBuf> = None,
        /// Capture this frame with RenderDoc, counted from 0, into gridlight_*.rdc in the working directory
        #[arg(long, value_name = "N")]
        pub renderdoc_frame: Option<u32> = None,
        /// Print everything about this pixel, counted from the upper left corner (docs/window.md)
        #[arg(long, value_name = "X,Y")]
        pub inspect: Option<PixelPlace> = None,
    }
}

impl Validate for SceneSettings {
    fn validate(&self) -> Result<()> {
        require(self.scene_name.is_none() || self.file.is_some(), || {
            "--scene-name chooses a scene of a file, and none is given: the built-in scene is alone".to_owned()
        })?;
        let Some(SunPlace { azimuth_deg, height_deg }) = self.sun else { return Ok(()) };
        require(azimuth_deg.is_finite() && height_deg.abs() <= 90.0, || {
            format!("--sun {azimuth_deg},{height_deg} needs a finite azimuth and a height from -90 to 90")
        })
    }
}

impl Validate for RunSettings {
    fn validate(&self) -> Result<()> {
        at_least_one("frames", self.frames)
    }
}

impl Validate for PictureSettings {
    fn validate(&self) -> Result<()> {
        let size = self.size;
        require(size.width > 0 && size.height > 0, || {
            format!("--size {size} has no pixels: width and height must be at least 1")
        })?;
        match self.exposure {
            Exposure::Auto => Ok(()),
            Exposure::Fixed(factor) => above_zero("exposure", factor),
        }?;
        let stops = self.exposure_compensation;
        require((-MOST_STOPS..=MOST_STOPS).contains(&stops), || {
            format!("--exposure-compensation must be from -{MOST_STOPS} to {MOST_STOPS} stops, not {stops}")
        })
    }
}

impl Validate for RenderSettings {
    fn validate(&self) -> Result<()> {
        at_least_one("accumulate", self.accumulate)
    }
}

impl Validate for DeviceSettings {
    fn validate(&self) -> Result<()> {
        above_zero("max-submit-ms", self.max_submit_ms)
    }
}

impl Validate for WindowSettings {
    fn validate(&self) -> Result<()> {
        let RenderScale::Fixed(scale) = self.render_scale else { return Ok(()) };
        require((0.05..=1.0).contains(&scale), || {
            format!("--render-scale must be `auto` or from 0.05 to 1, not {scale}")
        })
    }
}

impl OutputSettings {
    /// The files and folders that are asked for, each with the option that asks for it.
    pub fn files(&self) -> impl Iterator<Item = (&'static str, &Path)> {
        let files = [("output", self.picture.as_slice()), ("timings", &self.timings), ("dump", self.dump.as_slice())];
        files.into_iter().flat_map(|(option, paths)| paths.iter().map(move |path| (option, path.as_path())))
    }
}

impl OutputSettings {
    /// Whether every measured frame is written.
    #[must_use]
    pub fn is_sequence(&self) -> bool {
        self.picture.as_deref().is_some_and(sequence::is_sequence)
    }

    /// Of several timings of one format the last is written, as of any other option.
    pub fn keep_last_timings(&mut self) {
        let kinds: Vec<_> = self.timings.iter().map(|path| FileKind::of(path)).collect();
        let mut index = 0;
        self.timings.retain(|_| {
            index += 1;
            !kinds[index..].contains(&kinds[index - 1])
        });
    }
}

impl Validate for OutputSettings {
    fn validate(&self) -> Result<()> {
        for timings in &self.timings {
            require(self.picture.as_ref() != Some(timings), || {
                format!("--output and --timings are the same file, {}: give two names", timings.display())
            })?;
        }
        if let Some(path) = &self.picture {
            has_extension("output", path, &[FileKind::Exr, FileKind::Png])?;
            let in_folder = path.parent().is_some_and(sequence::is_sequence);
            require(!in_folder, || {
                let (path, place) = (path.display(), sequence::FRAME_PLACE);
                format!("--output {path} must have {place} in the file's name, not in its folder's")
            })?;
        }
        for path in &self.timings {
            has_extension("timings", path, &[FileKind::Json, FileKind::Csv])?;
        }
        for kind in [FileKind::Json, FileKind::Csv] {
            let count = self.timings.iter().filter(|path| FileKind::of(path) == Some(kind)).count();
            require(count <= 1, || format!("--timings is given {count} times as .{}: give one", kind.extension()))?;
        }
        if let Some(dump) = &self.dump {
            let inside = self.picture.iter().chain(&self.timings).find(|path| path.starts_with(dump));
            require(inside.is_none(), || {
                format!("--dump {} must hold nothing else, and an output would lie in it", dump.display())
            })?;
        }
        Ok(())
    }
}

/// Several paths as a list, one as itself.
fn paths_as_text<S: Serializer>(paths: &[PathBuf], serializer: S) -> std::result::Result<S::Ok, S::Error> {
    match paths {
        [] => serializer.serialize_none(),
        [path] => path.to_string_lossy().serialize(serializer),
        _ => serializer.collect_seq(paths.iter().map(|path| path.to_string_lossy())),
    }
}

/// What [`paths_as_text`] writes.
fn one_path_or_more<'de, D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Vec<PathBuf>, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged, expecting = "a path, or a list of paths")]
    enum Paths {
        One(PathBuf),
        More(Vec<PathBuf>),
    }
    Ok(match Option::<Paths>::deserialize(deserializer)? {
        None => Vec::new(),
        Some(Paths::One(path)) => vec![path],
        Some(Paths::More(paths)) => paths,
    })
}

/// A path that is not Unicode must not stop the timings from being written.
fn path_as_text<S: Serializer>(path: &Option<PathBuf>, serializer: S) -> std::result::Result<S::Ok, S::Error> {
    path.as_ref().map(|path| path.to_string_lossy()).serialize(serializer)
}

impl Validate for TracingSettings {
    fn validate(&self) -> Result<()> {
        Ok(())
    }
}
