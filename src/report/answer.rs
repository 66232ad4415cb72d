//! What a run says at its end: what was rendered on what, how long a frame took and in which passes, and where the files are.

use crate::error::shortened;
use std::fmt::Write;
use std::path::Path;

use super::Summary;
use super::timings::{Device, RunTimes, SceneInfo};
use crate::settings::{self, Settings};
use crate::techniques::Count;

/// Passes below this share of the frame are summed up in one line.
const LEAST_SHARE: f64 = 0.01;

/// A run that has come to its end.
#[derive(Debug)]
pub struct Answer<'a> {
    /// The scene and its camera.
    pub scene: &'a SceneInfo,
    /// The device.
    pub device: &'a Device,
    /// What is to be said of the device, if anything.
    pub device_note: Option<&'a str>,
    /// The settings.
    pub settings: &'a Settings,
    /// What was measured.
    pub times: &'a RunTimes,
    /// What the technique counted.
    pub counts: &'a [Count],
    /// Exposure of the picture, where it has one.
    pub exposure: Option<f32>,
    /// Whether a darker picture would have had no more.
    pub is_most_exposed: bool,
    /// Files and folders that the run leaves.
    pub files: &'a [&'a Path],
}

impl Answer<'_> {
    /// The lines. Plain text.
    #[must_use]
    pub fn text(&self) -> String {
        let mut lines = vec![self.scene_line(), self.device_line(), self.picture_line()];
        lines.push(self.frame_line());
        lines.extend(self.pass_lines());
        lines.extend(self.files.iter().map(|file| format!("written: {}", file.display())));
        lines.join("\n")
    }

    fn scene_line(&self) -> String {
        let SceneInfo { name, camera, triangles, environment, .. } = self.scene;
        let around = if environment == "none" { String::new() } else { format!(", environment {environment}") };
        shortened(&format!("scene: {name}, {} triangles, camera {camera}{around}", thousands(*triangles)))
    }

    fn device_line(&self) -> String {
        let note = self.device_note.map_or_else(String::new, |note| format!(", {note}"));
        format!("device: {}{note}", self.device.name)
    }

    /// Size, technique, what it counted, exposure.
    fn picture_line(&self) -> String {
        let mut line =
            format!("picture: {}, {}", self.settings.picture.size, settings::name(&self.settings.render.technique));
        for Count { label, value, .. } in self.counts {
            // Counts by level are for the timings.
            if let Some(count) = value.as_u64() {
                let _ = write!(line, ", {} {label}", thousands(count));
            }
        }
        if let Some(exposure) = self.exposure {
            let _ = write!(line, ", exposure {}", three_digits(f64::from(exposure)));
            line += if self.is_most_exposed { ", the most that so dark a picture is given" } else { "" };
        }
        line
    }

    fn frame_line(&self) -> String {
        let Summary { median, p95, .. } = &self.times.frame_gpu_ms;
        match self.times.frame_count() {
            1 => format!("frame: {}, one frame", time(*median)),
            frames => format!("frame: {}, median of {frames} frames, 95 % within {}", time(*median), time(*p95)),
        }
    }

    /// The passes, the costly ones by name.
    fn pass_lines(&self) -> Vec<String> {
        let all: f64 = self.times.passes.iter().map(|pass| pass.ms.median).sum();
        let share = |ms: f64| if all > 0.0 { ms / all } else { 0.0 };
        let (costly, others): (Vec<_>, Vec<_>) =
            self.times.passes.iter().partition(|pass| share(pass.ms.median) >= LEAST_SHARE);
        let mut rows: Vec<(String, f64)> = costly.iter().map(|pass| (pass.name.clone(), pass.ms.median)).collect();
        if let [other] = others[..] {
            rows.push((other.name.clone(), other.ms.median));
        } else if !others.is_empty() {
            let rest = others.iter().map(|pass| pass.ms.median).sum();
            rows.push((format!("{} passes below 1 %", others.len()), rest));
        }
        let width = rows.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
        let line =
            |(name, ms): &(String, f64)| format!("  {name:width$} {:>8} {:>4.0} %", time(*ms), 100.0 * share(*ms));
        rows.iter().map(line).collect()
    }
}

/// Milliseconds with as many digits as mean something.
fn time(ms: f64) -> String {
    if ms >= 10_000.0 { format!("{} s", three_digits(ms / 1000.0)) } else { format!("{} ms", three_digits(ms)) }
}

/// A number above 0 with three digits or, from 1000 on, with all before the point.
pub(super) fn three_digits(value: f64) -> String {
    if value <= 0.0 {
        return "0".to_owned();
    }
    let decimals = (2.0 - value.log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{value:.decimals$}")
}

/// 1234567 as 1,234,567.
fn thousands(count: u64) -> String {
    let digits = count.to_string();
    let lead = digits.len() % 3;
    let groups = digits.as_bytes()[lead..].chunks(3).map(|group| String::from_utf8_lossy(group).into_owned());
    let first = (lead > 0).then(|| digits[..lead].to_owned());
    first.into_iter().chain(groups).collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::super::timings::tests::two_frames;
    use super::*;

    fn text(times: &RunTimes, counts: &[Count]) -> String {
        let scene = SceneInfo {
            name: "room".to_owned(),
            path: None,
            triangles: 1_234_567,
            cameras: vec!["door".to_owned()],
            camera: "door".to_owned(),
            sun: None,
            environment: "sky".to_owned(),
            has_sky_for_lack_of_light: false,
        };
        let device = Device { name: "a device".to_owned(), ..Device::default() };
        let (settings, files) = (Settings::default(), [Path::new("a.png")]);
        Answer {
            scene: &scene,
            device: &device,
            device_note: Some("a CPU driver"),
            settings: &settings,
            times,
            counts,
            exposure: Some(2.5),
            is_most_exposed: times.frame_count() == 1,
            files: &files,
        }
        .text()
    }

    #[test]
    fn it_says_what_was_done_and_how_long_it_took() {
        let counts = [Count::new("vpls", "VPLs", 99_812_u32), Count::new("levels", "by level", vec![3, 2])];
        let size = Settings::default().picture.size;
        let expected = format!(
            "\
scene: room, 1,234,567 triangles, camera door, environment sky
device: a device, a CPU driver
picture: {size}, lgh, 99,812 VPLs, exposure 2.50
frame: 5.00 ms, median of 2 frames, 95 % within 6.00 ms
  gbuffer        1.50 ms   30 %
  light-volumes  3.50 ms   70 %
written: a.png"
        );
        assert_eq!(text(&RunTimes::of(&two_frames()).unwrap(), &counts), expected);
    }

    #[test]
    fn passes_that_cost_little_are_one_line() {
        let pass_ms = [("a", 12_000.0), ("b", 1.0), ("c", 2.0)].map(|(name, ms)| (name.to_owned(), ms)).to_vec();
        let frame = super::super::FrameTimes { pass_ms, gpu_ms: 12_003.0, cpu_ms: 12_010.0 };
        let text = text(&RunTimes::of(&[frame]).unwrap(), &[]);
        assert!(text.contains("\nframe: 12.0 s, one frame\n"), "{text}");
        assert!(text.contains(", exposure 2.50, the most that so dark a picture is given\n"), "{text}");
        assert!(text.contains("  2 passes below 1 %  3.00 ms    0 %") && !text.contains("  b "), "{text}");
    }

    #[test]
    fn a_clock_that_stands_still_has_no_shares() {
        let frame = super::super::FrameTimes { pass_ms: vec![("a".to_owned(), 0.0)], gpu_ms: 0.0, cpu_ms: 0.0 };
        let text = text(&RunTimes::of(&[frame]).unwrap(), &[]);
        assert!(!text.contains("NaN") && text.contains("frame: 0 ms"), "{text}");
    }

    #[test]
    fn numbers_by_hand() {
        assert_eq!(
            [0, 7, 999, 1000, 12_345, 1_234_567].map(thousands),
            ["0", "7", "999", "1,000", "12,345", "1,234,567"]
        );
        assert_eq!(
            [0.012_34, 0.5, 2.345_67, 23.4567, 234.567, 3186.394].map(three_digits),
            ["0.0123", "0.500", "2.35", "23.5", "235", "3186"]
        );
    }
}
