//! How resources of a frame are taken apart for dumps (`docs/dumps.md`): descriptions, and arrays with named fields.
//! Techniques describe theirs in these terms; `report::dump` writes the files.

pub mod array;

use std::any::Any;
use std::collections::BTreeMap;

pub use array::{Array, Field, Scalar};

use crate::passes::FrameShape;

/// How a resource is taken apart.
#[derive(Clone, Copy)]
pub enum Contents {
    /// A buffer, by the function that makes an array of it.
    Buffer(fn(&[u8], &DumpContext<'_>) -> Array),
    /// An image, by the names of its channels.
    Image(&'static [&'static str]),
}

/// One resource of the frame, or several whose names begin alike.
#[derive(Clone, Copy)]
pub struct Entry {
    /// The graph's name; with `*` at the end any name that begins so.
    pub name: &'static str,
    /// Units of its numbers.
    pub units: &'static str,
    /// What it holds, in a sentence.
    pub meaning: &'static str,
    /// Whether its pixels are in the interleaved layout.
    pub interleaved: bool,
    /// Whether its words tell how much of other buffers is in use.
    pub noted: bool,
    /// How it is taken apart.
    pub contents: Contents,
}

impl Entry {
    /// Whether it describes the resource of this name.
    #[must_use]
    pub fn fits(&self, resource: &str) -> bool {
        match self.name.strip_suffix('*') {
            Some(start) => resource.starts_with(start),
            None => resource == self.name,
        }
    }
}

/// Channels of an image of colours.
pub const RGBA: &[&str] = &["R", "G", "B", "A"];
/// The channel of a depth buffer.
pub const DEPTH: &[&str] = &["Z"];

/// Units of what a camera sees.
pub const RADIANCE: &str = "radiance";
/// Units of light that no surface has reflected yet.
pub const LIGHTING: &str = "radiance per unit albedo";
/// Units of packed positions and normals.
pub const METRES_AND_BITS: &str = "metres; octahedral mapping, 16-bit snorm";
/// Units of what is counted.
pub const COUNT: &str = "count";

/// The entry of a buffer.
#[must_use]
pub const fn buffer(
    name: &'static str,
    units: &'static str,
    contents: fn(&[u8], &DumpContext<'_>) -> Array,
    meaning: &'static str,
) -> Entry {
    Entry { name, units, meaning, interleaved: false, noted: false, contents: Contents::Buffer(contents) }
}

/// The entry of an image.
#[must_use]
pub const fn image(
    name: &'static str,
    units: &'static str,
    channels: &'static [&'static str],
    meaning: &'static str,
) -> Entry {
    Entry { name, units, meaning, interleaved: false, noted: false, contents: Contents::Image(channels) }
}

/// The entry of something in the interleaved layout.
#[must_use]
pub const fn interleaved(entry: Entry) -> Entry {
    Entry { interleaved: true, ..entry }
}

/// The entry of a buffer that tells how much of others is in use.
#[must_use]
pub const fn noted(entry: Entry) -> Entry {
    Entry { noted: true, ..entry }
}

/// What is known of the frame when a buffer is taken apart.
pub struct DumpContext<'a> {
    /// What every frame has.
    pub frame: &'a FrameShape,
    /// The pass that wrote the buffer.
    pub pass: String,
    /// Its push constants.
    pub push: Vec<u32>,
    technique: &'a dyn Any,
    noted: BTreeMap<String, Vec<u32>>,
}

impl<'a> DumpContext<'a> {
    /// Nothing but the shapes of frame and technique.
    #[must_use]
    pub fn new(frame: &'a FrameShape, technique: &'a dyn Any) -> Self {
        Self { frame, pass: String::new(), push: Vec::new(), technique, noted: BTreeMap::new() }
    }

    /// The technique's shape, where it is of this type.
    #[must_use]
    pub fn shape<T: 'static>(&self) -> Option<&'a T> {
        self.technique.downcast_ref()
    }

    /// Remembers a resource whose entry is [`Entry::noted`]. Call it for everything that a pass wrote before anything of
    /// that pass is taken apart.
    pub fn note(&mut self, resource: &str, bytes: &[u8]) {
        self.noted.insert(resource.to_owned(), words(bytes));
    }

    /// Words of a noted resource; none before it is written.
    #[must_use]
    pub fn words(&self, resource: &str) -> &[u32] {
        self.noted.get(resource).map_or(&[], Vec::as_slice)
    }

    /// Height and width of the picture.
    #[must_use]
    pub fn pixels(&self) -> [u64; 2] {
        [self.frame.height_px.into(), self.frame.width_px.into()]
    }
}

/// What is made of a resource for a dump besides the resource itself.
pub struct Derived {
    /// Name of its file.
    pub name: &'static str,
    /// Units of its numbers.
    pub units: &'static str,
    /// What it holds, in a sentence.
    pub meaning: &'static str,
    /// The numbers.
    pub array: Array,
}

/// The words of little-endian bytes.
#[must_use]
pub fn words(bytes: &[u8]) -> Vec<u32> {
    bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
}

/// Words as little-endian bytes.
#[must_use]
pub fn bytes_of(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|w| w.to_le_bytes()).collect()
}

/// A field of floats.
#[must_use]
pub fn f(name: &str, shape: &[u64]) -> Field {
    Field::new(name, Scalar::F32, shape)
}

/// A field of words.
#[must_use]
pub fn u(name: &str, shape: &[u64]) -> Field {
    Field::new(name, Scalar::U32, shape)
}

/// All of a buffer as words.
#[must_use]
pub fn all_words(bytes: &[u8], _: &DumpContext<'_>) -> Array {
    Array::plain(Scalar::U32, &[bytes.len() as u64 / 4], bytes)
}

/// One float.
#[must_use]
pub fn one_float(bytes: &[u8], _: &DumpContext<'_>) -> Array {
    Array::plain(Scalar::F32, &[1], bytes)
}

/// A word for every pixel of the picture.
#[must_use]
pub fn per_pixel(bytes: &[u8], known: &DumpContext<'_>) -> Array {
    Array::plain(Scalar::U32, &known.pixels(), bytes)
}

/// The scanned range of the ranks: after the second step of the scan only the entry past its end is there.
#[must_use]
pub fn ranks(bytes: &[u8], known: &DumpContext<'_>) -> Array {
    let [first, count] = [0, 1].map(|i| u64::from(known.push.get(i).copied().unwrap_or(0)));
    let (start, length) = if known.pass.ends_with("scan_block_sums") { (first + count, 1) } else { (first, count + 1) };
    Array::plain(Scalar::U32, &[length], &bytes[4 * start as usize..]).starting_at(start)
}
