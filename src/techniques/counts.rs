//! What techniques tell: counts of a frame, and tables about one pixel.

use serde_json::Value;

/// Something that a frame counted.
#[derive(Clone, Debug, PartialEq)]
pub struct Count {
    /// Its key in the timings.
    pub key: &'static str,
    /// What the window calls it.
    pub label: &'static str,
    /// A number, or one for each level from 1 on.
    pub value: Value,
}

impl Count {
    /// A count of this name.
    #[must_use]
    pub fn new(key: &'static str, label: &'static str, value: impl Into<Value>) -> Self {
        Self { key, label, value: value.into() }
    }
}

/// A table in the window's inspector.
#[derive(Clone, Debug, PartialEq)]
pub struct InspectorTable {
    /// Its name, unlike that of others.
    pub name: &'static str,
    /// Names of the columns, each with a sentence of help.
    pub columns: &'static [(&'static str, &'static str)],
    /// As many cells as columns in each row.
    pub rows: Vec<Vec<Cell>>,
}

/// A small square picture in the window's inspector.
#[derive(Clone, Debug, PartialEq)]
pub struct InspectorImage {
    /// What it shows.
    pub name: &'static str,
    /// The same in a sentence.
    pub help: &'static str,
    /// Pixels of a row, and rows.
    pub edge: u32,
    /// sRGB colours, `0xRRGGBB`, row by row; `None` is nothing.
    pub colors: Vec<Option<u32>>,
}

/// A cell of such a table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cell {
    /// What it says.
    pub text: String,
    /// sRGB colour, `0xRRGGBB`; `None` is the panel's own, in letters of equal width.
    pub color: Option<u32>,
}

impl Cell {
    /// Numbers and words.
    #[must_use]
    pub fn plain(text: impl Into<String>) -> Self {
        Self { text: text.into(), color: None }
    }

    /// Words in a colour.
    #[must_use]
    pub fn colored(text: impl Into<String>, color: u32) -> Self {
        Self { text: text.into(), color: Some(color) }
    }
}
