//! What is to be said of how a file was read: a line each, however often it is so.

use std::cell::RefCell;
use std::collections::{HashMap, HashSet};
use std::fmt;

use super::gltf_buffers::Document;
use super::gltf_extensions;
use crate::error::shortened;

/// So many textures that cannot be read get a line each.
const MOST_TEXTURES: usize = 4;

/// A thing of a file, as messages call it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Thing {
    /// `camera`, `material`.
    kind: &'static str,
    /// Which of its kind, if there are several.
    index: Option<usize>,
    name: Option<String>,
}

impl Thing {
    pub fn new(kind: &'static str, index: usize, name: Option<&String>) -> Self {
        Self { kind, index: Some(index), name: name.cloned() }
    }

    pub fn file() -> Self {
        Self { kind: "the file", index: None, name: None }
    }
}

impl fmt::Display for Thing {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str(self.kind)?;
        self.index.iter().try_for_each(|index| write!(formatter, " {index}"))?;
        self.name.iter().try_for_each(|name| write!(formatter, " (`{name}`)"))
    }
}

/// What is wrong with things of one kind.
struct Fault {
    thing: Thing,
    sentence: String,
    /// Other things of which it is true.
    more: usize,
}

/// What has been noted of a file.
#[derive(Default)]
pub(super) struct Notes {
    /// What the file has that is not rendered.
    ignored: Vec<String>,
    /// What is wrong with the file and was read as it is meant.
    mended: Vec<&'static str>,
    /// What textures cannot be read, and why.
    unreadable_textures: Vec<String>,
    faults: Vec<Fault>,
    /// Where a sentence stands in `faults`, by the kind of thing.
    places: HashMap<(&'static str, String), usize>,
    /// Faults by thing, so that each is counted once.
    known: HashSet<(&'static str, Option<usize>, usize)>,
    left_out: HashSet<(&'static str, Option<usize>)>,
}

impl Notes {
    fn fault(&mut self, thing: Thing, sentence: String) {
        let end = self.faults.len();
        let place = *self.places.entry((thing.kind, sentence.clone())).or_insert(end);
        if !self.known.insert((thing.kind, thing.index, place)) {
            return;
        }
        match self.faults.get_mut(place) {
            Some(fault) => fault.more += 1,
            None => self.faults.push(Fault { thing, sentence, more: 0 }),
        }
    }
}

fn add<T: PartialEq>(list: &mut Vec<T>, item: T) {
    if !list.contains(&item) {
        list.push(item);
    }
}

impl Document<'_> {
    /// Notes something that the file has and that is not rendered.
    pub fn ignore(&self, what: impl Into<String>) {
        add(&mut self.notes.borrow_mut().ignored, what.into());
    }

    /// Notes something that is wrong with the file and was read as it is meant.
    pub fn mend(&self, fault: &'static str) {
        add(&mut self.notes.borrow_mut().mended, fault);
    }

    /// Notes a texture that cannot be read, why, and what is done about it. The first are told, the others counted.
    pub fn unreadable_texture(&self, sentence: String) {
        add(&mut self.notes.borrow_mut().unreadable_textures, sentence);
    }

    /// Notes that a thing of the file `has` this fault, and what is done about it. Of things of the same kind with the
    /// same fault the first is named, and the others are counted.
    pub fn fault(&self, thing: Thing, has: impl Into<String>) {
        self.notes.borrow_mut().fault(thing, has.into());
    }

    /// Notes once that a thing of the file is left out, for the first reason found.
    pub fn leave_out(&self, thing: Thing, why: impl fmt::Display) {
        let mut notes = self.notes.borrow_mut();
        if notes.left_out.insert((thing.kind, thing.index)) {
            notes.fault(thing, format!("is left out: {why}"));
        }
    }

    /// What is to be said of how the file was read, a sentence each.
    pub fn remarks(&self) -> Vec<String> {
        let (path, notes) = (self.path().display(), self.notes.borrow());
        let list = |what: &str, items: Vec<&str>| {
            (!items.is_empty()).then(|| format!("{what} of {path}: {}", items.join(", ")))
        };
        let unread = gltf_extensions::unread(self.root.extensions_used.iter().map(String::as_str));
        let unread = unread.into_iter().map(|sentence| format!("{path}: {sentence}"));
        let (told, others) = notes.unreadable_textures.split_at(MOST_TEXTURES.min(notes.unreadable_textures.len()));
        let textures = told.iter().map(|sentence| format!("{path}: {sentence}"));
        let others = Some(others.len()).filter(|count| *count > 0);
        let textures = textures.chain(others.map(|count| format!("{path}: {count} more textures cannot be read")));
        let faults = notes.faults.iter().map(|Fault { thing, sentence, more }| match more {
            0 => format!("{path}: {thing} {sentence}"),
            _ => format!("{path}: {thing} {sentence} ({more} more of this kind)"),
        });
        list("mended while reading", notes.mended.clone())
            .into_iter()
            .chain(unread)
            .chain(textures)
            .chain(faults)
            .chain(list("not rendered", notes.ignored.iter().map(String::as_str).collect()))
            .map(|remark| shortened(&remark))
            .collect()
    }
}

/// The notes of a document, which those who read it add to.
pub(super) type Noted = RefCell<Notes>;
