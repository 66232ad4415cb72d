//! The bytes behind a glTF: external files, data URIs and buffer views, all ranges checked.

use std::borrow::Cow;
use std::cell::Cell;
use std::collections::HashMap;
use std::fmt::Display;
use std::path::{Path, PathBuf};

use ::gltf::json::accessor::Accessor;
use ::gltf::json::validation::USize64;
use ::gltf::json::{Index, Root, Scene, buffer};
use base64::Engine as _;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};

use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use super::gltf_lenient::Lenient;
use super::gltf_notes::{Noted, Thing};
use super::gltf_parts::WrongPart;
use super::gltf_pointers::Pointers;
use super::{gltf_draco, gltf_files, gltf_glb, gltf_json, gltf_meshopt};
use crate::{Error, Result};

/// A parsed glTF with its buffers in memory. Nothing in it has been validated beyond what each method checks.
pub(super) struct Document<'a> {
    path: PathBuf,
    base: Option<PathBuf>,
    /// The JSON part.
    pub root: Root,
    /// What animations change by `KHR_animation_pointer`.
    pub pointers: Pointers,
    buffers: Vec<Cow<'a, [u8]>>,
    /// What compressed buffer views hold and what has been decompressed for others, by the index of the view.
    decompressed: HashMap<usize, Vec<u8>>,
    /// What is to be said of how it was read.
    pub notes: Noted,
    /// Numbers of animations, skins and morph targets that have been read.
    pub moving_numbers: Cell<u64>,
}

impl<'a> Document<'a> {
    /// Parses `bytes` (GLB or JSON), reads all buffers and decompresses their views. `base` is the folder of external
    /// files, if there is one.
    pub fn parse(
        path: &Path,
        base: Option<PathBuf>,
        bytes: &'a [u8],
        progress: &dyn Fn(&str, u64, u64),
    ) -> Result<Self> {
        let gltf_glb::Parts { text, chunk, faults } = gltf_glb::split(path, bytes)?;
        let gltf_json::Parsed { root, pointers, wrong_parts } = gltf_json::parse(path, text)?;
        let mut document = Self {
            path: path.to_path_buf(),
            base,
            root,
            pointers,
            buffers: Vec::new(),
            decompressed: HashMap::new(),
            notes: Noted::default(),
            moving_numbers: Cell::default(),
        };
        faults.into_iter().for_each(|fault| document.mend(fault));
        for WrongPart { thing, fault, is_lost } in wrong_parts {
            if is_lost { document.leave_out(thing, fault) } else { document.fault(thing, fault) }
        }
        let compressed = gltf_meshopt::compressed_views(&document)?;
        let placeholders = gltf_meshopt::placeholders(&document.root, &compressed);
        let total = document.root.buffers.len() as u64;
        for i in 0..document.root.buffers.len() {
            progress("buffers", i as u64, total);
            let is_read = !placeholders.contains(&i);
            let data = if is_read { document.read_buffer(i, chunk)? } else { Cow::Borrowed(&[][..]) };
            document.buffers.push(data);
        }
        document.decompressed = gltf_meshopt::decompress(&document, &compressed)?;
        gltf_draco::decompress(&mut document)?;
        progress("buffers", total, total);
        Ok(document)
    }

    /// Makes a scene, by its name or its index, the one that is read.
    pub fn choose_scene(&mut self, wanted: &str) -> Result<()> {
        let scenes = &self.root.scenes;
        let named = scenes.iter().position(|scene| scene.name.as_deref() == Some(wanted));
        let index = wanted.parse().ok().filter(|index| *index < scenes.len());
        let Some(found) = named.or(index) else {
            let file = self.path.display();
            let name = |(i, scene): (usize, &Scene)| scene.name.clone().unwrap_or_else(|| i.to_string());
            let names: Vec<String> = scenes.iter().enumerate().map(name).collect();
            let what = match names.as_slice() {
                [] => "the file has no scenes".to_owned(),
                names => format!("its scenes are {}", names.join(", ")),
            };
            return Err(Error::Usage(format!("--scene-name {wanted} is not in {file}; {what}")));
        };
        self.root.scene = Some(Index::new(found as u32));
        Ok(())
    }

    /// The file, as messages name it.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The object of an extension that `what` may have.
    pub fn extension<T: DeserializeOwned>(
        &self,
        what: &dyn Display,
        extensions: Option<&Map<String, Value>>,
        name: &str,
    ) -> Result<Option<T>> {
        let Some(object) = extensions.and_then(|extensions| extensions.get(name)) else { return Ok(None) };
        let read = T::deserialize(Lenient::new(object));
        read.map(Some).map_err(|e| self.error(format_args!("{what} has a broken {name}: {e}")))
    }

    /// The object of an extension that a thing may have, and can do without.
    pub fn spare_extension<T: DeserializeOwned>(
        &self,
        thing: Thing,
        extensions: Option<&Map<String, Value>>,
        name: &str,
    ) -> Option<T> {
        let read = T::deserialize(Lenient::new(extensions?.get(name)?));
        read.map_err(|e| self.fault(thing, format!("has a broken {name}, which is ignored: {e}"))).ok()
    }

    /// An error about this file.
    pub fn error(&self, reason: impl Display) -> Error {
        Error::file(&self.path, reason)
    }

    fn read_buffer(&self, i: usize, chunk: Option<&'a [u8]>) -> Result<Cow<'a, [u8]>> {
        let buffer = &self.root.buffers[i];
        let uri = buffer.uri.as_ref().filter(|uri| !uri.is_empty());
        let data = match (uri, chunk) {
            (Some(uri), _) => Cow::Owned(self.fetch(&format!("buffer {i}"), uri)?),
            (None, Some(chunk)) if i == 0 => Cow::Borrowed(chunk),
            (None, _) => return Err(self.error(format_args!("buffer {i} has no uri and the file no chunk for it"))),
        };
        let announced = buffer.byte_length.0;
        if (data.len() as u64) < announced {
            let (name, len) = (buffer.uri.as_deref().map_or("the binary chunk", name_of), data.len());
            return Err(self
                .error(format_args!("buffer {i} ({name}) is truncated: {announced} bytes announced, {len} present")));
        }
        Ok(data)
    }

    /// The bytes a URI stands for: a data URI or a file beside the glTF.
    pub fn fetch(&self, what: &str, uri: &str) -> Result<Vec<u8>> {
        if let Some(data) = gltf_files::data_of(uri) {
            return decode_data_uri(data).map_err(|why| self.error(format_args!("the data URI of {what} {why}")));
        }
        let name = name_of(uri);
        if gltf_files::is_remote(uri) {
            return Err(self.error(format_args!("{what} is at `{name}`: only files and data URIs can be read")));
        }
        let Some(base) = &self.base else {
            return Err(self.error(format_args!("{what} is the external file `{name}`, which a scene in memory lacks")));
        };
        let gltf_files::Named { path: file, faults } = gltf_files::find(base, uri);
        faults.into_iter().for_each(|fault| self.mend(fault));
        // Devices and pipes could be endless, so only regular files are read.
        let read = match std::fs::metadata(&file) {
            Ok(meta) if !meta.is_file() => Err("not a regular file".to_owned()),
            Ok(_) => std::fs::read(&file).map_err(|e| e.to_string()),
            Err(e) => Err(e.to_string()),
        };
        read.map_err(|why| self.error(format_args!("{what}, the file `{name}`, cannot be read: {why}")))
    }

    /// Bytes of all buffers together, as the file has them.
    pub fn buffer_bytes(&self) -> u64 {
        self.buffers.iter().map(|buffer| buffer.len() as u64).sum()
    }

    /// Adds an accessor like `model` of so many packed elements, whose bytes are these.
    #[cfg_attr(not(feature = "codecs"), allow(dead_code, reason = "only decoders add any"))]
    pub fn add_accessor(&mut self, model: Accessor, count: usize, bytes: Vec<u8>) -> Index<Accessor> {
        let (view, accessor) = (self.root.buffer_views.len(), self.root.accessors.len());
        let buffer_view = Some(Index::new(view as u32));
        let added = Accessor { buffer_view, byte_offset: None, count: USize64(count as u64), sparse: None, ..model };
        self.root.accessors.push(added);
        self.root.buffer_views.push(buffer::View {
            buffer: Index::new(0),
            byte_length: USize64(bytes.len() as u64),
            byte_offset: None,
            byte_stride: None,
            name: None,
            target: None,
            extensions: None,
            extras: Default::default(),
        });
        self.decompressed.insert(view, bytes);
        Index::new(accessor as u32)
    }

    /// The bytes of a buffer view and its stride, decompressed.
    pub fn view(&self, what: &str, index: Index<buffer::View>) -> Result<(&[u8], Option<usize>)> {
        let i = index.value();
        let Some(view) = self.root.buffer_views.get(i) else {
            return Err(self.error(format_args!("{what} refers to buffer view {i}, which does not exist")));
        };
        let bytes = match self.decompressed.get(&i) {
            Some(bytes) => bytes,
            None => {
                let start = view.byte_offset.unwrap_or_default().0;
                self.range(&format_args!("buffer view {i}"), view.buffer.value(), start, view.byte_length.0)?
            }
        };
        Ok((bytes, view.byte_stride.map(|s| s.0).filter(|s| *s != 0)))
    }

    /// So many bytes of a buffer from byte `start` on, of which `what` consists.
    pub fn range(&self, what: &dyn Display, buffer: usize, start: u64, length: u64) -> Result<&[u8]> {
        let Some(bytes) = self.buffers.get(buffer) else {
            return Err(self.error(format_args!("{what} refers to buffer {buffer}, which does not exist")));
        };
        let part = start.checked_add(length).and_then(|end| {
            let (start, end) = (usize::try_from(start).ok()?, usize::try_from(end).ok()?);
            bytes.get(start..end)
        });
        part.ok_or_else(|| {
            let have = bytes.len();
            self.error(format_args!(
                "{what} ({length} bytes from byte {start}) reaches beyond its buffer of {have} bytes"
            ))
        })
    }
}

/// What messages call a file by its URI.
fn name_of(uri: &str) -> &str {
    if gltf_files::data_of(uri).is_some() { "a data URI" } else { uri }
}

fn decode_data_uri(data: &str) -> std::result::Result<Vec<u8>, String> {
    // A parameter in quotes may have commas.
    let mut quotes = 0;
    let is_end = |c: char| {
        quotes += u32::from(c == '"');
        c == ',' && quotes % 2 == 0
    };
    let (head, body) = data.split_once(is_end).or_else(|| data.split_once(',')).ok_or("has no comma")?;
    let mut body: Vec<u8> = percent_encoding::percent_decode_str(body).collect();
    if !head.rsplit(';').next().is_some_and(|last| last.trim().eq_ignore_ascii_case("base64")) {
        return Ok(body);
    }
    // Lines and the alphabet of URLs, as browsers have them.
    body.retain(|byte| !byte.is_ascii_whitespace());
    for byte in &mut body {
        *byte = match *byte {
            b'-' => b'+',
            b'_' => b'/',
            other => other,
        };
    }
    let config = GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent);
    GeneralPurpose::new(&base64::alphabet::STANDARD, config).decode(body).map_err(|e| format!("is not base64: {e}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decodes_data_uris() {
        assert_eq!(decode_data_uri("application/octet-stream;base64,AAEC").unwrap(), [0, 1, 2]);
        assert_eq!(decode_data_uri(";base64,AAE").unwrap(), [0, 1], "padding is optional");
        assert_eq!(decode_data_uri(",a%20b").unwrap(), b"a b");
        assert_eq!(decode_data_uri("a/b;charset=utf-8;BASE64, AA\r\nEC%0A").unwrap(), [0, 1, 2], "lines");
        assert_eq!(decode_data_uri(" text/plain ; name=\"a,b\" ; base64 , AAEC ").unwrap(), [0, 1, 2], "quotes");
        assert_eq!(decode_data_uri("base64,AAEC").unwrap(), [0, 1, 2], "without its semicolon");
        assert_eq!(decode_data_uri("a=\"b,AAEC").unwrap(), b"AAEC", "a quote without end");
        assert_eq!(decode_data_uri(";base64,-_-_").unwrap(), decode_data_uri(";base64,+/%2B%2F").unwrap());
        assert!(decode_data_uri(";base64,!").is_err());
        assert!(decode_data_uri("nothing").is_err());
    }
}
