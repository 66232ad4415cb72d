//! The timings of a run: per-pass statistics as JSON, every frame as CSV.

use serde::Serialize;

use super::machine::Machine;
use super::summary::Summary;
use crate::gpu::DeviceReport;
use crate::settings::{self, Settings};
use crate::{Error, Result};

/// The version of the JSON layout.
pub use crate::files::TIMINGS_SCHEMA as SCHEMA;

/// What was measured in one frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameTimes {
    /// GPU milliseconds of each pass, in the order they ran, under the graph's names.
    pub pass_ms: Vec<(String, f64)>,
    /// GPU milliseconds from the first to the last timestamp of the frame.
    pub gpu_ms: f64,
    /// Wall-clock milliseconds of the frame.
    pub cpu_ms: f64,
}

/// The whole timings file.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunReport {
    /// Always [`SCHEMA`].
    pub schema: &'static str,
    /// The program that ran.
    pub program: Program,
    /// The device it ran on.
    pub device: Device,
    /// The computer it ran on.
    pub machine: Machine,
    /// The scene it rendered.
    pub scene: SceneInfo,
    /// Every setting.
    pub settings: Settings,
    /// Number of measured frames.
    pub frames: u32,
    /// How far the run came when the user stopped it; `None` when it ran to its end.
    pub interrupted: Option<String>,
    /// Number of frames before them.
    pub warmup: u32,
    /// The measurements.
    #[serde(flatten)]
    pub times: RunTimes,
    /// Memory in use.
    pub memory: Memory,
    /// What was counted.
    pub counts: Counts,
    /// How fast rays were.
    pub rays: RayRates,
    /// Exposure of the last frame's picture; `None` for a view that has a scale instead.
    pub exposure: Option<f32>,
}

/// Name and version of the program.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Program {
    /// `gridlight`.
    pub name: &'static str,
    /// Package version.
    pub version: &'static str,
    /// Abbreviated commit, or `unknown`.
    pub commit: &'static str,
}

impl Program {
    /// This program.
    #[must_use]
    pub fn this() -> Self {
        Self { name: env!("CARGO_PKG_NAME"), version: env!("CARGO_PKG_VERSION"), commit: env!("GRIDLIGHT_COMMIT") }
    }

    /// What a picture says of the program and the technique that made it.
    #[must_use]
    pub fn note(&self, settings: &Settings) -> String {
        let Self { name, version, commit } = self;
        format!("{name} {version} ({commit}), {}", settings::name(&settings.render.technique))
    }
}

/// What the driver says about itself.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Device {
    /// Device name.
    pub name: String,
    /// Driver name and information.
    pub driver: String,
    /// Vulkan version of the device, `major.minor.patch`.
    pub api_version: String,
    /// PCI or Khronos vendor number.
    pub vendor_id: u32,
    /// Device number within the vendor.
    pub device_id: u32,
    /// The vendor's own number of the driver version.
    pub driver_version: u32,
}

impl Device {
    /// What there is to say of a device.
    #[must_use]
    pub fn of(report: &DeviceReport) -> Self {
        Self {
            name: report.name.clone(),
            driver: report.driver.clone(),
            api_version: report.api_version.clone(),
            vendor_id: report.vendor_id,
            device_id: report.device_id,
            driver_version: report.driver_version,
        }
    }
}

/// What was rendered.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct SceneInfo {
    /// Name of the scene.
    pub name: String,
    /// Its file; `None` is the built-in scene.
    pub path: Option<String>,
    /// Number of triangles.
    pub triangles: u64,
    /// Names of all cameras.
    pub cameras: Vec<String>,
    /// Name of the camera that was used.
    pub camera: String,
    /// Where the sun was put; `None` leaves it where the scene has it.
    pub sun: Option<String>,
    /// What is around it: `none`, `sky`, a radiance, or an image's file.
    pub environment: String,
    /// Whether that is a sky because the scene brings no light and nothing else was asked for.
    pub has_sky_for_lack_of_light: bool,
}

/// Memory in use.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Memory {
    /// Most device memory allocated at a time.
    pub device_bytes: u64,
    /// Most memory this process had resident; `None` where the system does not tell.
    pub peak_resident_bytes: Option<u64>,
}

/// What was counted in the last frame: `vpl_rays`, `shadow_rays`, `environment_rays`, and what the technique counts.
pub type Counts = serde_json::Map<String, serde_json::Value>;

/// Rays of a frame over the median time of the pass that traces them, set-up of the rays included; `None` where it
/// traced none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct RayRates {
    /// Of `shadow_rays`.
    pub shadow_rays_per_s: Option<f64>,
    /// Of `vpl_trace`.
    pub vpl_rays_per_s: Option<f64>,
    /// Of `environment_light`.
    pub environment_rays_per_s: Option<f64>,
}

/// Rays that a frame traced.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayCounts {
    /// By light paths.
    pub vpl: u64,
    /// Towards lights of the hierarchy.
    pub shadow: u64,
    /// Towards the environment.
    pub environment: u64,
}

impl RayRates {
    /// Rates of so many rays in a frame.
    #[must_use]
    pub fn of(times: &RunTimes, rays: RayCounts) -> Self {
        let rate = |pass: &str, rays: u64| {
            // Light paths may go in parts: `vpl_trace/1` and so on.
            let is_part =
                |name: &str| name.strip_prefix(pass).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'));
            let ms: f64 = times.passes.iter().filter(|p| is_part(&p.name)).map(|p| p.ms.median).sum();
            (rays > 0 && ms > 0.0).then(|| rays as f64 / ms * 1e3)
        };
        Self {
            shadow_rays_per_s: rate("shadow_rays", rays.shadow),
            vpl_rays_per_s: rate("vpl_trace", rays.vpl),
            environment_rays_per_s: rate("environment_light", rays.environment),
        }
    }
}

/// GPU time of one pass.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PassTimes {
    /// The graph's name of the pass.
    pub name: String,
    /// Number of frames it ran in.
    pub frames: usize,
    /// Milliseconds in those frames.
    pub ms: Summary,
}

/// The measured frames, summarised.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunTimes {
    /// Every pass, in the order they first ran.
    pub passes: Vec<PassTimes>,
    /// The frame on the GPU's clock.
    pub frame_gpu_ms: Summary,
    /// The frame on the wall clock.
    pub frame_cpu_ms: Summary,
    /// The sum of the passes of a frame.
    pub pass_sum_ms: Summary,
}

impl RunTimes {
    /// Summarises the frames, or `None` when there are none. A pass that runs twice in a frame counts with its sum.
    #[must_use]
    pub fn of(frames: &[FrameTimes]) -> Option<Self> {
        let stats = |value: fn(&FrameTimes) -> f64| Summary::of(&frames.iter().map(value).collect::<Vec<_>>());
        Some(Self {
            passes: summarise_passes(frames),
            frame_gpu_ms: stats(|frame| frame.gpu_ms)?,
            frame_cpu_ms: stats(|frame| frame.cpu_ms)?,
            pass_sum_ms: stats(|frame| frame.pass_ms.iter().map(|(_, ms)| ms).sum())?,
        })
    }

    /// Frames that were measured.
    #[must_use]
    pub fn frame_count(&self) -> usize {
        self.passes.iter().map(|pass| pass.frames).max().unwrap_or(1)
    }
}

fn summarise_passes(frames: &[FrameTimes]) -> Vec<PassTimes> {
    let mut series: Vec<(&str, Vec<f64>)> = Vec::new();
    for frame in frames {
        let mut sums: Vec<(&str, f64)> = Vec::new();
        for (name, ms) in &frame.pass_ms {
            match sums.iter_mut().find(|(known, _)| known == name) {
                Some((_, sum)) => *sum += ms,
                None => sums.push((name, *ms)),
            }
        }
        for (name, ms) in sums {
            match series.iter_mut().find(|(known, _)| *known == name) {
                Some((_, values)) => values.push(ms),
                None => series.push((name, vec![ms])),
            }
        }
    }
    let summary = |(name, values): (&str, Vec<f64>)| {
        Some(PassTimes { name: name.to_owned(), frames: values.len(), ms: Summary::of(&values)? })
    };
    series.into_iter().filter_map(summary).collect()
}

impl RunReport {
    /// The report as an indented JSON document.
    ///
    /// # Errors
    /// [`Error::Failure`] when a value cannot be expressed.
    pub fn to_json(&self) -> Result<Vec<u8>> {
        super::to_json(self)
    }
}

/// The frames as CSV, `frame,pass,gpu_ms`, a row for each pass of each frame.
///
/// # Errors
/// [`Error::Failure`] when a value cannot be expressed.
pub fn to_csv(frames: &[FrameTimes]) -> Result<Vec<u8>> {
    let fail = |error: &dyn std::fmt::Display| Error::Failure(format!("cannot express the timings as CSV: {error}"));
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(["frame", "pass", "gpu_ms"]).map_err(|error| fail(&error))?;
    for (index, frame) in frames.iter().enumerate() {
        for (name, ms) in &frame.pass_ms {
            writer.serialize((index, name, ms)).map_err(|error| fail(&error))?;
        }
    }
    writer.into_inner().map_err(|error| fail(&error))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub fn two_frames() -> Vec<FrameTimes> {
        let frame = |a: f64, b: f64, gpu_ms: f64| FrameTimes {
            pass_ms: vec![("gbuffer".to_owned(), a), ("light-volumes".to_owned(), b)],
            gpu_ms,
            cpu_ms: gpu_ms + 1.0,
        };
        vec![frame(1.0, 3.0, 4.0), frame(2.0, 4.0, 6.0)]
    }

    pub fn report() -> RunReport {
        RunReport {
            schema: SCHEMA,
            program: Program::this(),
            device: Device { name: "some device".to_owned(), ..Device::default() },
            machine: Machine::here(),
            scene: SceneInfo { name: "courtyard".to_owned(), ..SceneInfo::default() },
            settings: Settings::default(),
            frames: 2,
            interrupted: None,
            warmup: 0,
            times: RunTimes::of(&two_frames()).unwrap(),
            memory: Memory { device_bytes: 7, peak_resident_bytes: None },
            counts: Counts::from_iter([("grid_lights_per_level".to_owned(), serde_json::json!([5, 3]))]),
            rays: RayRates { shadow_rays_per_s: Some(2.5e6), ..RayRates::default() },
            exposure: Some(0.5),
        }
    }

    #[test]
    fn passes_are_summarised() {
        let times = RunTimes::of(&two_frames()).unwrap();
        let names: Vec<_> = times.passes.iter().map(|pass| pass.name.as_str()).collect();
        assert_eq!(names, ["gbuffer", "light-volumes"]);
        assert_eq!(times.passes[1].ms, Summary { min: 3.0, median: 3.5, mean: 3.5, p95: 4.0, max: 4.0 });
        assert_eq!(times.frame_gpu_ms, Summary { min: 4.0, median: 5.0, mean: 5.0, p95: 6.0, max: 6.0 });
        assert_eq!(times.frame_cpu_ms.max.to_bits(), 7.0_f64.to_bits());
        assert_eq!(times.pass_sum_ms, times.frame_gpu_ms);
        assert_eq!(RunTimes::of(&[]), None);
    }

    #[test]
    fn rays_per_second_are_over_the_median_of_their_pass() {
        let pass_ms = |ms: f64| vec![("shadow_rays".to_owned(), ms), ("environment_light".to_owned(), 2.0 * ms)];
        let frame = |ms: f64| FrameTimes { pass_ms: pass_ms(ms), gpu_ms: ms, cpu_ms: ms };
        let times = RunTimes::of(&[frame(2.0), frame(4.0), frame(90.0)]).unwrap();
        let rates = RayRates::of(&times, RayCounts { vpl: 7, shadow: 1000, environment: 4000 });
        let expected = RayRates {
            shadow_rays_per_s: Some(250_000.0),
            vpl_rays_per_s: None,
            environment_rays_per_s: Some(500_000.0),
        };
        assert_eq!(rates, expected);
        assert_eq!(RayRates::of(&times, RayCounts { vpl: 7, ..RayCounts::default() }), RayRates::default());
    }

    #[test]
    fn repeated_and_absent_passes() {
        let mut frames = two_frames();
        frames[0].pass_ms.push(("gbuffer".to_owned(), 0.5));
        frames[1].pass_ms.pop();
        let times = RunTimes::of(&frames).unwrap();
        assert_eq!((times.passes[0].frames, times.passes[1].frames), (2, 1));
        assert_eq!(times.passes[0].ms.min.to_bits(), 1.5_f64.to_bits());
        assert_eq!(times.passes[1].ms.max.to_bits(), 3.0_f64.to_bits());
    }

    #[test]
    fn json_has_every_part() {
        let text = report().to_json().unwrap();
        let json: serde_json::Value = serde_json::from_slice(&text).unwrap();
        assert_eq!(json["schema"], "gridlight-timings/1");
        assert_eq!(json["program"]["name"], "gridlight");
        assert!(json["program"]["commit"].as_str().is_some_and(|commit| !commit.is_empty()));
        assert_eq!(json["passes"][1]["name"], "light-volumes");
        assert_eq!(json["passes"][1]["ms"]["median"], 3.5);
        for key in ["frame_gpu_ms", "frame_cpu_ms", "pass_sum_ms"] {
            for part in ["min", "median", "mean", "p95", "max"] {
                assert!(json[key][part].is_f64(), "{key}.{part}");
            }
        }
        assert_eq!(json["counts"]["grid_lights_per_level"], serde_json::json!([5, 3]));
        assert_eq!(json["rays"]["shadow_rays_per_s"], 2.5e6);
        assert!(json["rays"]["vpl_rays_per_s"].is_null());
        assert_eq!(json["exposure"], 0.5);
        assert!(json["memory"]["peak_resident_bytes"].is_null());
    }

    #[test]
    fn json_has_every_setting_even_unset_ones() {
        let json: serde_json::Value = serde_json::from_slice(&report().to_json().unwrap()).unwrap();
        let settings = json["settings"].as_object().unwrap();
        assert_eq!(settings.len(), Settings::keys().count());
        assert!(settings["camera"].is_null() && settings["reservoir"].is_null());
        assert_eq!(settings["clamp"], 1.0);
        assert_eq!(settings["size"], "1280x720");
    }

    #[test]
    fn csv_has_a_row_for_each_frame_and_pass() {
        let text = String::from_utf8(to_csv(&two_frames()).unwrap()).unwrap();
        let expected = "frame,pass,gpu_ms\n0,gbuffer,1.0\n0,light-volumes,3.0\n1,gbuffer,2.0\n1,light-volumes,4.0\n";
        assert_eq!(text, expected);
        assert_eq!(to_csv(&[]).unwrap(), b"frame,pass,gpu_ms\n");
    }
}
