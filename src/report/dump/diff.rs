//! Comparing two dumps file by file in the order of the frame: which pass differs first, and by how much.

use std::path::{Path, PathBuf};

use comfy_table::presets::ASCII_MARKDOWN;
use comfy_table::{Cell, CellAlignment, Table};
use exr::prelude::f16;
use serde_json::{Value, json};

use super::images::Picture;
use super::manifest::{FileEntry, Manifest};
use crate::dump::{Array, Scalar};
use crate::settings::{Scope, Settings};
use crate::{Error, Result};

/// The smallest magnitude that a difference is taken relative to, as a fraction of the mean magnitude of the field.
const FLOOR: f64 = 1e-2;

/// What counts as different.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Options {
    /// Largest relative difference of two equal floats or fixed-point numbers; 0 compares bits.
    pub tolerance: f64,
    /// Compare dumps of different settings.
    pub ignore_settings: bool,
}

/// How one file of the dumps compares.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// The pass.
    pub pass: String,
    /// The resource.
    pub resource: String,
    /// Numbers compared.
    pub numbers: u64,
    /// Numbers that differ.
    pub differing: u64,
    /// Largest absolute difference.
    pub max_abs: f64,
    /// Largest relative difference.
    pub max_rel: f64,
    /// Numbers that are NaN in either dump.
    pub nans: u64,
    /// Why the numbers could not be compared one by one.
    pub note: Option<String>,
    /// Whether a difference counts; not that of the constants of different settings.
    counts: bool,
    order: Option<usize>,
}

impl Row {
    /// Whether the file differs.
    #[must_use]
    pub fn differs(&self) -> bool {
        self.counts && (self.differing > 0 || self.note.is_some())
    }
}

impl Row {
    /// Where it is of: a pass, or one of the things that a frame starts from.
    #[must_use]
    pub fn place(&self) -> String {
        let kind = if self.order.is_some() { "pass" } else { "the" };
        format!("{kind} {}", self.pass)
    }
}

/// Two dumps compared.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Comparison {
    /// Every file, in the order of the frame.
    pub rows: Vec<Row>,
    /// What they were compared with.
    pub tolerance: f64,
}

/// Compares the dumps in two folders.
///
/// # Errors
/// [`Error::Usage`] when their settings differ, [`Error::File`] when a file is missing or damaged.
pub fn compare(a: &Path, b: &Path, options: Options) -> Result<Comparison> {
    let (left, right) = (Manifest::read(a)?, Manifest::read(b)?);
    let settings_differ = differing_settings(&left, &right);
    if !settings_differ.is_empty() && !options.ignore_settings {
        return Err(Error::Usage(format!(
            "{} and {} were made with different settings: {}; --ignore-settings compares them all the same",
            a.display(),
            b.display(),
            settings_differ.join(", ")
        )));
    }
    let same = |x: &FileEntry, y: &FileEntry| (&x.pass, &x.resource) == (&y.pass, &y.resource);
    let mut rows = Vec::new();
    for file in &left.files {
        let mut row = match right.files.iter().find(|other| same(file, other)) {
            Some(other) => compare_files((&a.join(&file.file), file), (&b.join(&other.file), other), options)?,
            None => only_in(a, file),
        };
        // The constants follow the settings; what matters then is what the passes make of them.
        row.counts = settings_differ.is_empty() || file.resource != "frame_data";
        rows.push(row);
    }
    let missing = right.files.iter().filter(|file| !left.files.iter().any(|other| same(file, other)));
    rows.extend(missing.map(|file| only_in(b, file)));
    rows.sort_by_key(|row| row.order);
    Ok(Comparison { rows, tolerance: options.tolerance })
}

/// Each setting that differs, with both values.
fn differing_settings(a: &Manifest, b: &Manifest) -> Vec<String> {
    let empty = serde_json::Map::new();
    let settings = |manifest: &Manifest| manifest.settings.as_object().unwrap_or(&empty).clone();
    let (left, right) = (settings(a), settings(b));
    let mut keys: Vec<&String> = left.keys().chain(right.keys()).collect();
    keys.sort();
    keys.dedup();
    let pairs = keys
        .into_iter()
        .filter(|key| is_compared(key))
        .map(|key| (key.as_str(), left.get(key).unwrap_or(&Value::Null), right.get(key).unwrap_or(&Value::Null)));
    let scene = [("scene", "name"), ("camera", "camera"), ("sun", "sun")]
        .map(|(name, key)| (name, &a.scene[key], &b.scene[key]));
    scene.into_iter().chain(pairs).filter(|(_, x, y)| x != y).map(|(key, x, y)| format!("{key} ({x}, {y})")).collect()
}

/// Whether a setting says what a run computes. What it is run on and where it leaves its files does not, and the scene is
/// compared by what the manifest says of it. A setting that this program does not know may matter.
fn is_compared(key: &str) -> bool {
    Settings::scope_of(key).is_none_or(|scope| !scope.is_session() && scope != Scope::Scene)
}

fn blank(file: &FileEntry) -> Row {
    Row {
        pass: file.pass.clone(),
        resource: file.resource.clone(),
        counts: true,
        order: file.pass_index,
        ..Row::default()
    }
}

fn only_in(folder: &Path, file: &FileEntry) -> Row {
    Row { note: Some(format!("only in {}", folder.display())), ..blank(file) }
}

/// The numbers of one field or channel.
pub struct Column {
    /// Empty where an array has no names.
    pub name: String,
    /// Of each number.
    pub scalar: Scalar,
    /// Of all.
    pub bytes: Vec<u8>,
}

/// The numbers of a file by fields or channels.
///
/// # Errors
/// [`Error::File`] when it cannot be read or is not as its entry says.
pub fn columns(path: &Path, file: &FileEntry) -> Result<Vec<Column>> {
    let (shape, columns) = if path.extension().is_some_and(|e| e == "exr") {
        let picture = Picture::read(path)?;
        let shape = vec![u64::from(picture.height_px), u64::from(picture.width_px)];
        let channels = picture.channels.into_iter();
        (shape, channels.map(|(name, bytes)| Column { name, scalar: picture.scalar, bytes }).collect())
    } else {
        let array = Array::read(path)?;
        if array.dtype_json() != file.dtype {
            let (found, told) = (array.dtype_json(), &file.dtype);
            return Err(Error::file(path, format!("has elements {found}, but the manifest says {told}")));
        }
        (array.shape.clone(), array_columns(&array))
    };
    if shape != file.shape {
        // Without spaces: where a list is long, it is one long word, of which the sentence keeps what it can.
        let (found, told) = (json!(shape), json!(file.shape));
        return Err(Error::file(path, format!("has shape {found}, but the manifest says {told}")));
    }
    Ok(columns)
}

fn array_columns(array: &Array) -> Vec<Column> {
    let size = array.element_bytes();
    let mut offset = 0;
    let mut columns = Vec::new();
    for field in &array.fields {
        let range = offset..offset + field.bytes();
        let bytes = array.bytes.chunks_exact(size).flat_map(|element| &element[range.clone()]).copied().collect();
        columns.push(Column { name: field.name.clone(), scalar: field.scalar, bytes });
        offset = range.end;
    }
    columns
}

fn compare_files(a: (&PathBuf, &FileEntry), b: (&PathBuf, &FileEntry), options: Options) -> Result<Row> {
    let mut row = blank(a.1);
    let (left, right) = (columns(a.0, a.1)?, columns(b.0, b.1)?);
    if (&a.1.dtype, a.1.first_element) != (&b.1.dtype, b.1.first_element) || inner(a.1) != inner(b.1) {
        row.note = Some(format!("{} and {} elements", elements(a.1), elements(b.1)));
        return Ok(row);
    }
    if a.1.shape != b.1.shape {
        // A list that is longer in one dump: what both have is compared, the rest counts as different.
        row.note = Some(format!("{} and {} elements", elements(a.1), elements(b.1)));
    }
    for (x, y) in left.iter().zip(&right) {
        let scale = a.1.scale.get(&x.name).copied();
        compare_columns(&mut row, x, y, scale, options.tolerance);
    }
    Ok(row)
}

/// Elements along the axes after the first, which alone may grow.
fn inner(file: &FileEntry) -> &[u64] {
    if file.kind == "image" { &file.shape } else { file.shape.get(1..).unwrap_or_default() }
}

fn elements(file: &FileEntry) -> String {
    let shape: Vec<String> = file.shape.iter().map(u64::to_string).collect();
    let from = if file.first_element > 0 { format!(" from {}", file.first_element) } else { String::new() };
    shape.join("x") + &from
}

/// A number's bits and its value.
#[must_use]
pub fn number(scalar: Scalar, bytes: &[u8], scale: f64) -> (u64, f64) {
    let mut wide = [0; 8];
    wide[..bytes.len()].copy_from_slice(bytes);
    let bits = u64::from_le_bytes(wide);
    let value = match scalar {
        Scalar::F16 => f64::from(f16::from_bits(bits as u16).to_f32()),
        Scalar::F32 => f64::from(f32::from_bits(bits as u32)),
        Scalar::I16 => f64::from(bits as u16 as i16) * scale,
        Scalar::I64 => bits as i64 as f64 * scale,
        Scalar::U32 => bits as f64,
    };
    (bits, value)
}

fn compare_columns(row: &mut Row, a: &Column, b: &Column, scale: Option<f64>, tolerance: f64) {
    let size = a.scalar.bytes();
    let numbers = |column: &Column| -> Vec<(u64, f64)> {
        column.bytes.chunks_exact(size).map(|bytes| number(column.scalar, bytes, scale.unwrap_or(1.0))).collect()
    };
    let (left, right) = (numbers(a), numbers(b));
    let real = matches!(a.scalar, Scalar::F16 | Scalar::F32) || scale.is_some();
    let finite = left.iter().chain(&right).map(|n| n.1.abs()).filter(|value| value.is_finite());
    let (sum, count) = finite.fold((0.0, 0_u64), |(sum, count), value| (sum + value, count + 1));
    let floor = FLOOR * sum / count.max(1) as f64;
    row.numbers += left.len().min(right.len()) as u64;
    for ((bits, x), (other_bits, y)) in left.into_iter().zip(right) {
        row.nans += u64::from(x.is_nan() || y.is_nan());
        if bits == other_bits || (x.is_nan() && y.is_nan()) {
            continue;
        }
        let abs = (x - y).abs();
        let larger = x.abs().max(y.abs()).max(floor);
        let rel = if abs.is_finite() { abs / larger.max(f64::MIN_POSITIVE) } else { f64::INFINITY };
        if tolerance > 0.0 && real && rel <= tolerance {
            continue;
        }
        row.differing += 1;
        // A NaN against a number is as far as can be.
        row.max_abs = row.max_abs.max(if abs.is_nan() { f64::INFINITY } else { abs });
        row.max_rel = row.max_rel.max(rel);
    }
}

impl Comparison {
    /// The first file that differs.
    #[must_use]
    pub fn first(&self) -> Option<&Row> {
        self.rows.iter().find(|row| row.differs())
    }

    /// Every file in a row of plain text.
    #[must_use]
    pub fn table(&self) -> String {
        let mut table = Table::new();
        table.load_style(ASCII_MARKDOWN);
        table.set_header(["pass", "resource", "numbers", "differing", "max abs", "max rel", "NaN", "note"]);
        let right = |text: String| Cell::new(text).set_alignment(CellAlignment::Right);
        for row in &self.rows {
            let note = match (&row.note, row.counts) {
                (Some(note), _) => note.clone(),
                (None, false) => "follows the settings".to_owned(),
                (None, true) => String::new(),
            };
            table.add_row([
                Cell::new(&row.pass),
                Cell::new(&row.resource),
                right(row.numbers.to_string()),
                right(row.differing.to_string()),
                right(short(row.max_abs)),
                right(short(row.max_rel)),
                right(row.nans.to_string()),
                Cell::new(note),
            ]);
        }
        table.trim_fmt()
    }

    /// The result in a sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        let Some(first) = self.first() else {
            let numbers: u64 = self.rows.iter().map(|row| row.numbers).sum();
            let how =
                if self.tolerance > 0.0 { format!("within {}", self.tolerance) } else { "bit for bit".to_owned() };
            return format!("the dumps agree {how}: {numbers} numbers in {} files", self.rows.len());
        };
        let files = self.rows.iter().filter(|row| row.differs()).count();
        let differ = format!(
            "{} of {} numbers of {} differ, by at most {} (relative {})",
            first.differing,
            first.numbers,
            first.resource,
            short(first.max_abs),
            short(first.max_rel)
        );
        let what = match &first.note {
            Some(note) if first.numbers > 0 => format!("{differ}, in {note}"),
            Some(note) => format!("{}: {note}", first.resource),
            None => differ,
        };
        let place = match first.order {
            Some(_) => format!("the first pass that differs is {}", first.pass),
            None => format!("the frames start from another {}", first.pass),
        };
        format!("{place}: {what}; {files} of {} files differ", self.rows.len())
    }
}

fn short(value: f64) -> String {
    if value == 0.0 { "0".to_owned() } else { format!("{value:.2e}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::testing::every_value_changed;

    fn row(a: &[f32], b: &[f32], tolerance: f64) -> Row {
        let column = |values: &[f32]| Column {
            name: String::new(),
            scalar: Scalar::F32,
            bytes: values.iter().flat_map(|v| v.to_le_bytes()).collect(),
        };
        let mut row = Row { counts: true, ..Row::default() };
        compare_columns(&mut row, &column(a), &column(b), None, tolerance);
        row
    }

    #[test]
    fn bits_are_compared_without_a_tolerance() {
        assert!(!row(&[1.0, f32::NAN], &[1.0, f32::NAN], 0.0).differs());
        let found = row(&[1.0, 2.0, 0.0], &[1.0, 2.0 + 2.0 * f32::EPSILON, -0.0], 0.0);
        assert_eq!((found.numbers, found.differing), (3, 2));
        assert_eq!(found.max_abs, f64::from(2.0 * f32::EPSILON));
    }

    fn manifest(settings: &Settings) -> Manifest {
        let scene = serde_json::json!({"name": "courtyard", "camera": {"name": "first"}, "sun": settings.scene.sun});
        Manifest { scene, settings: serde_json::to_value(settings).unwrap(), ..Manifest::default() }
    }

    #[test]
    fn settings_count_by_their_group() {
        let (defaults, changed) = (Settings::default(), every_value_changed());
        for key in Settings::keys() {
            let value = changed.table().unwrap()[&key].clone();
            let mut other = manifest(&defaults);
            other.settings[&key] = serde_json::to_value(value).unwrap();
            let differing = differing_settings(&manifest(&defaults), &other);
            let scope = Settings::scope_of(&key).unwrap();
            let counts = scope == Scope::Picture || scope.is_method();
            assert_eq!(differing.iter().any(|sentence| sentence.starts_with(&key)), counts, "{key}: {differing:?}");
        }
        let turned = defaults.clone().changed(|s| s.scene.sun = changed.scene.sun);
        let differing = differing_settings(&manifest(&defaults), &manifest(&turned));
        assert!(differing.len() == 1 && differing[0].starts_with("sun (null, "), "{differing:?}");
    }

    #[test]
    fn settings_of_other_programs_count() {
        let mut other = manifest(&Settings::default());
        other.settings["new-setting"] = true.into();
        assert_eq!(differing_settings(&manifest(&Settings::default()), &other), ["new-setting (null, true)"]);
    }

    #[test]
    fn tolerances_are_relative_with_a_floor() {
        assert!(!row(&[100.0], &[100.9], 0.01).differs());
        assert!(row(&[100.0], &[102.0], 0.01).differs());
        // The mean magnitude is about 67, so that 0.005 is compared with 0.67.
        assert!(!row(&[100.0, 100.0, 0.0], &[100.0, 100.0, 0.005], 0.01).differs());
        assert!(row(&[100.0, 100.0, 0.0], &[100.0, 100.0, 0.05], 0.01).differs());
    }

    #[test]
    fn a_number_lost_is_the_largest_difference() {
        let found = row(&[1.0, 2.0], &[f32::NAN, f32::INFINITY], 0.5);
        assert_eq!((found.differing, found.nans), (2, 1));
        assert_eq!((found.max_abs, found.max_rel), (f64::INFINITY, f64::INFINITY));
    }

    #[test]
    fn integers_are_exact_and_fixed_point_is_not() {
        let column =
            |value: i64| Column { name: String::new(), scalar: Scalar::I64, bytes: value.to_le_bytes().into() };
        for (scale, differing) in [(None, 1), (Some(0.5_f64.powi(40)), 0)] {
            let mut row = Row { counts: true, ..Row::default() };
            compare_columns(&mut row, &column(1 << 40), &column((1 << 40) + 9), scale, 1e-6);
            assert_eq!(row.differing, differing);
        }
    }
}
