//! A device against a record.

use std::fmt::Write as _;

use comfy_table::presets::ASCII_MARKDOWN;
use comfy_table::{Cell, CellAlignment, Table};

use super::{Case, FileDigest};

/// A larger deviation is a difference. Pictures are small and lights few, so that a path that takes another way at the last
/// bit shows in the means: SwiftShader deviates from lavapipe by up to 8 %. A pass that goes wrong deviates by more.
pub const LARGEST_DEVIATION: f64 = 0.1;

/// What was found, case by case.
#[derive(Debug, Default)]
pub struct Scorecard {
    rows: Vec<Row>,
}

/// One case.
#[derive(Debug)]
struct Row {
    name: String,
    passes: usize,
    numbers: u64,
    largest: Deviation,
    /// The first that is a difference, in the order of the frame.
    first: Option<Deviation>,
}

/// How far something is from the record.
#[derive(Clone, Debug, Default)]
struct Deviation {
    of: String,
    amount: f64,
}

impl Deviation {
    fn is_difference(&self) -> bool {
        self.amount.is_nan() || self.amount > LARGEST_DEVIATION
    }
}

impl Scorecard {
    /// Adds what a device left in a case, beside the record's.
    pub fn add(&mut self, recorded: &Case, found: &Case) {
        let deviations: Vec<Deviation> = deviations(&recorded.files, &found.files);
        let larger = |a: Deviation, b: &Deviation| if b.amount > a.amount { b.clone() } else { a };
        let mut passes: Vec<&str> = found.files.iter().map(|file| file.pass.as_str()).collect();
        passes.dedup();
        self.rows.push(Row {
            name: recorded.name.clone(),
            passes: passes.len(),
            numbers: found.files.iter().flat_map(|file| &file.columns).map(|column| column.count).sum(),
            largest: deviations.iter().fold(Deviation::default(), larger),
            first: deviations.into_iter().find(Deviation::is_difference),
        });
    }

    /// A table of all cases.
    #[must_use]
    pub fn table(&self) -> String {
        let mut table = Table::new();
        table.load_style(ASCII_MARKDOWN);
        table.set_header(["case", "passes", "numbers", "largest deviation", "in", "verdict"]);
        let right = |text: String| Cell::new(text).set_alignment(CellAlignment::Right);
        for row in &self.rows {
            let verdict =
                row.first.as_ref().map_or_else(|| "ok".to_owned(), |first| format!("DIFFERS from {}", first.of));
            table.add_row([
                Cell::new(&row.name),
                right(row.passes.to_string()),
                right(row.numbers.to_string()),
                right(format!("{:.2} %", 100.0 * row.largest.amount)),
                Cell::new(&row.largest.of),
                Cell::new(verdict),
            ]);
        }
        table.to_string()
    }

    /// What is wrong, in a sentence; `None` where nothing is.
    #[must_use]
    pub fn complaint(&self) -> Option<String> {
        let wrong: Vec<_> = self.rows.iter().filter_map(|row| Some((row, row.first.as_ref()?))).collect();
        let (row, first) = wrong.first()?;
        let mut sentence = format!("{} of {} cases differ from the record", wrong.len(), self.rows.len());
        let percent = 100.0 * first.amount;
        let _ = write!(
            sentence,
            ", first {} in {}: {percent:.1} %, where {:.0} % may be",
            row.name,
            first.of,
            100.0 * LARGEST_DEVIATION
        );
        Some(sentence)
    }
}

/// Of everything that either has, in the order of the frame. What only one has is all another.
fn deviations(recorded: &[FileDigest], found: &[FileDigest]) -> Vec<Deviation> {
    let same = |a: &FileDigest, b: &FileDigest| (&a.pass, &a.resource) == (&b.pass, &b.resource);
    let missing = recorded.iter().filter(|file| !found.iter().any(|other| same(file, other)));
    let whole = |file: &FileDigest| Deviation { of: format!("{}: {}", file.pass, file.resource), amount: 1.0 };
    let mut all = Vec::new();
    for file in found {
        match recorded.iter().find(|other| same(file, other)) {
            Some(other) if other.columns.len() == file.columns.len() => {
                all.extend(other.columns.iter().zip(&file.columns).map(|(a, b)| Deviation {
                    of: format!("{}: {} {}", file.pass, file.resource, a.name).trim_end().to_owned(),
                    amount: a.deviation(b),
                }));
            }
            _ => all.push(whole(file)),
        }
    }
    all.extend(missing.map(whole));
    all
}

#[cfg(test)]
mod tests {
    use super::super::Digest;
    use super::*;

    fn case(passes: &[&str], mean: f32) -> Case {
        let digest = Digest { name: String::new(), count: 100, not_finite: 0, mean, rms: 1.0 };
        let file = |pass: &&str| FileDigest {
            pass: (*pass).to_owned(),
            resource: "buffer".to_owned(),
            columns: vec![digest.clone()],
        };
        Case { name: "lgh".to_owned(), options: String::new(), files: passes.iter().map(file).collect() }
    }

    fn complaint(recorded: &Case, found: &Case) -> Option<String> {
        let mut card = Scorecard::default();
        card.add(recorded, found);
        assert!(card.table().contains("lgh"));
        card.complaint()
    }

    #[test]
    fn the_first_pass_that_differs_is_named() {
        let recorded = case(&["a", "b"], 0.5);
        assert_eq!(complaint(&recorded, &case(&["a", "b"], 0.51)), None);
        let sentence = complaint(&recorded, &case(&["a", "b"], 0.65)).unwrap();
        assert_eq!(sentence, "1 of 1 cases differ from the record, first lgh in a: buffer: 15.0 %, where 10 % may be");
        assert!(complaint(&recorded, &case(&["a", "b"], f32::NAN)).is_some());
        assert!(complaint(&recorded, &case(&["a", "b", "c"], 0.5)).unwrap().contains("in c: buffer"));
        assert!(complaint(&recorded, &case(&["a"], 0.5)).unwrap().contains("in b: buffer"));
    }
}
