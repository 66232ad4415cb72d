//! Two timings files against each other.

use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::table::number;
use crate::files::{TIMINGS_SCHEMA as SCHEMA, read_whole};
use crate::{Error, Result};

/// The part of the frame, in percent, from which a pass is held to the limit by itself.
pub const NOTABLE_PERCENT: f64 = 5.0;

/// Settings that say where things go, not what is measured; the scene is compared by itself.
const UNIMPORTANT_SETTINGS: [&str; 4] = ["output", "timings", "dump", "scene"];
/// What a scene is known by: a path differs between machines.
const SCENE_KEYS: [&str; 3] = ["name", "triangles", "camera"];

/// What is read of a file that `--timings FILE.json` wrote.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct TimingsFile {
    schema: String,
    device: Map<String, Value>,
    machine: Map<String, Value>,
    scene: Map<String, Value>,
    settings: Map<String, Value>,
    passes: Vec<Pass>,
    frame_gpu_ms: Times,
    frame_cpu_ms: Times,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
struct Pass {
    name: String,
    ms: Times,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
struct Times {
    median: f64,
}

/// A pass or a frame in both files, medians.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TimePair {
    /// The graph's name of the pass, or which frame.
    pub name: String,
    /// Median milliseconds in the first file; `None` where it has no such pass.
    pub reference_ms: Option<f64>,
    /// Median milliseconds in the second file; `None` where it has no such pass.
    pub test_ms: Option<f64>,
    /// Second over first; `None` where that is undefined.
    pub ratio: Option<f64>,
    /// The larger of its parts, in percent, of the two frames on the GPU's clock; `None` where the clock stands still.
    pub share_percent: Option<f64>,
}

/// What differs between two timings files.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TimingComparison {
    /// Every pass: those of the first file in their order, then those only in the second.
    pub passes: Vec<TimePair>,
    /// The frame on the GPU's clock.
    pub frame_gpu: TimePair,
    /// The frame on the wall clock.
    pub frame_cpu: TimePair,
    /// What makes the files less comparable, one sentence each.
    pub notes: Vec<String>,
}

impl TimingsFile {
    /// Reads what `--timings FILE.json` wrote.
    ///
    /// # Errors
    /// [`Error::File`] when it cannot be read or is something else.
    pub fn read(path: &Path) -> Result<Self> {
        let bytes =
            read_whole(path, || false).map_err(|error| Error::file(path, format!("cannot be read: {error}")))?;
        Self::parse(&bytes).map_err(|reason| Error::file(path, reason))
    }

    /// A file's content; what is wrong with it as a clause otherwise.
    fn parse(bytes: &[u8]) -> std::result::Result<Self, String> {
        let json: Value = serde_json::from_slice(bytes).map_err(|error| format!("not a JSON file: {error}"))?;
        match json.get("schema").and_then(Value::as_str) {
            Some(SCHEMA) => {}
            Some(other) => {
                return Err(format!("not a timings file of this version: its schema is {other}, not {SCHEMA}"));
            }
            None => return Err("not a timings file of gridlight: it has no schema".to_owned()),
        }
        Self::deserialize(json).map_err(|error| format!("not a whole timings file: {error}"))
    }
}

impl TimingComparison {
    /// Compares the medians of two runs.
    #[must_use]
    pub fn new(reference: &TimingsFile, test: &TimingsFile) -> Self {
        let frames = (reference.frame_gpu_ms.median, test.frame_gpu_ms.median);
        let find = |file: &TimingsFile, name: &str| file.passes.iter().find(|p| p.name == name).map(|p| p.ms.median);
        let added = test.passes.iter().filter(|pass| find(reference, &pass.name).is_none());
        let pair = |pass: &Pass| TimePair::new(&pass.name, find(reference, &pass.name), find(test, &pass.name), frames);
        let whole = |name: &str, a: Times, b: Times| TimePair::new(name, Some(a.median), Some(b.median), frames);
        Self {
            passes: reference.passes.iter().chain(added).map(pair).collect(),
            frame_gpu: whole("frame (GPU clock)", reference.frame_gpu_ms, test.frame_gpu_ms),
            frame_cpu: whole("frame (CPU clock)", reference.frame_cpu_ms, test.frame_cpu_ms),
            notes: notes(reference, test),
        }
    }

    /// A clause for the frame (GPU clock) and for each pass of at least [`NOTABLE_PERCENT`] of either frame that is
    /// slower by more than `max_percent`. Passes in one file only count with the frame.
    #[must_use]
    pub fn regressions(&self, max_percent: f64) -> Vec<String> {
        let slower = |pair: &TimePair| pair.slower_clause(max_percent);
        let notable = self.passes.iter().filter(|pair| pair.is_notable());
        std::iter::once(&self.frame_gpu).chain(notable).filter_map(slower).collect()
    }

    /// Whether [`Self::regressions`] looks at a pass or a frame of this comparison.
    pub(super) fn is_held_to_a_limit(&self, pair: &TimePair) -> bool {
        pair == &self.frame_gpu || (pair.is_notable() && self.passes.contains(pair))
    }

    /// The passes of at least [`NOTABLE_PERCENT`] of either frame, and the others together, where they are several.
    pub(super) fn notable_passes(&self) -> (Vec<TimePair>, Option<TimePair>) {
        let (notable, others): (Vec<_>, Vec<_>) = self.passes.iter().cloned().partition(TimePair::is_notable);
        let sum = |ms: fn(&TimePair) -> Option<f64>| others.iter().filter_map(ms).sum::<f64>();
        let name = format!("{} passes below {NOTABLE_PERCENT} %", others.len());
        let frames = [&self.frame_gpu.reference_ms, &self.frame_gpu.test_ms].map(|ms| ms.unwrap_or(0.0));
        let sums = (sum(|pair| pair.reference_ms), sum(|pair| pair.test_ms));
        let rest = TimePair::new(&name, Some(sums.0), Some(sums.1), (frames[0], frames[1]));
        if others.len() > 1 { (notable, Some(rest)) } else { (self.passes.clone(), None) }
    }
}

impl TimePair {
    fn new(name: &str, reference_ms: Option<f64>, test_ms: Option<f64>, frames: (f64, f64)) -> Self {
        let share = |ms: Option<f64>, frame: f64| ms.filter(|_| frame > 0.0).map(|ms| 100.0 * ms / frame);
        let shares = [share(reference_ms, frames.0), share(test_ms, frames.1)];
        Self {
            name: name.to_owned(),
            reference_ms,
            test_ms,
            ratio: reference_ms.zip(test_ms).filter(|(a, _)| *a > 0.0).map(|(a, b)| b / a),
            share_percent: shares.into_iter().flatten().reduce(f64::max),
        }
    }

    fn is_notable(&self) -> bool {
        self.share_percent.is_some_and(|share| share >= NOTABLE_PERCENT)
    }

    /// Whether it takes longer by more than this.
    pub(super) fn is_slower(&self, max_percent: f64) -> bool {
        let times = self.reference_ms.zip(self.test_ms);
        times.is_some_and(|(before, after)| after - before > before * max_percent / 100.0)
    }

    fn slower_clause(&self, max_percent: f64) -> Option<String> {
        let (before, after) = self.reference_ms.zip(self.test_ms).filter(|_| self.is_slower(max_percent))?;
        let name = &self.name;
        let times = format!("{} against {} ms", number(after), number(before));
        let percent = self.ratio.map_or_else(String::new, |ratio| format!("{} % ", number(100.0 * (ratio - 1.0))));
        Some(format!("{name} is {percent}slower ({times}), over the limit {max_percent} %"))
    }
}

fn notes(reference: &TimingsFile, test: &TimingsFile) -> Vec<String> {
    let all = |_: &str| true;
    [
        difference("device", &reference.device, &test.device, all),
        difference("machine", &reference.machine, &test.machine, all),
        difference("scene", &reference.scene, &test.scene, |key| SCENE_KEYS.contains(&key)),
        difference("settings", &reference.settings, &test.settings, |key| !UNIMPORTANT_SETTINGS.contains(&key)),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// "the device differs: name `a` against `b`, ..." over the keys that matter; `None` where those are equal.
fn difference(
    what: &str,
    reference: &Map<String, Value>,
    test: &Map<String, Value>,
    matters: fn(&str) -> bool,
) -> Option<String> {
    let added = test.keys().filter(|key| !reference.contains_key(*key));
    let keys = reference.keys().chain(added).filter(|key| matters(key) && reference.get(*key) != test.get(*key));
    let shown = |value: Option<&Value>| match value {
        None | Some(Value::Null) => "unset".to_owned(),
        Some(Value::String(text)) => format!("`{text}`"),
        Some(other) => other.to_string(),
    };
    let parts: Vec<String> =
        keys.map(|key| format!("{key} {} against {}", shown(reference.get(key)), shown(test.get(key)))).collect();
    (!parts.is_empty()).then(|| format!("{what} not the same: {}", parts.join(", ")))
}

#[cfg(test)]
mod tests;
