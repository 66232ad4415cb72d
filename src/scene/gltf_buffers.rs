//! The bytes behind a glTF: the GLB container, external files, data URIs and buffer views, all ranges checked.

use std::borrow::Cow;
use std::cell::RefCell;
use std::fmt::Display;
use std::path::{Path, PathBuf};

use ::gltf::json::{self, Index, Root, buffer};
use base64::Engine as _;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};

use crate::{Error, Result};

/// A parsed glTF with its buffers in memory. Nothing in it has been validated beyond what each method checks.
pub(super) struct Document<'a> {
    path: PathBuf,
    base: Option<PathBuf>,
    /// The JSON part.
    pub root: Root,
    buffers: Vec<Cow<'a, [u8]>>,
    /// What the file has that is not rendered, each kind once.
    ignored: RefCell<Vec<String>>,
}

impl<'a> Document<'a> {
    /// Parses `bytes` (GLB or JSON) and reads all buffers. `base` is the folder of external files, if there is one.
    pub fn parse(
        path: &Path,
        base: Option<PathBuf>,
        bytes: &'a [u8],
        progress: &dyn Fn(&str, u64, u64),
    ) -> Result<Self> {
        let (text, chunk) = split_glb(path, bytes)?;
        let root: Root = json::deserialize::from_slice(text)
            .map_err(|e| Error::file(path, format_args!("the glTF JSON is broken: {e}")))?;
        let mut document =
            Self { path: path.to_path_buf(), base, root, buffers: Vec::new(), ignored: RefCell::default() };
        let total = document.root.buffers.len() as u64;
        for i in 0..document.root.buffers.len() {
            progress("buffers", i as u64, total);
            let data = document.read_buffer(i, chunk)?;
            document.buffers.push(data);
        }
        progress("buffers", total, total);
        Ok(document)
    }

    /// Notes something that the file has and that is not rendered.
    pub fn ignore(&self, what: impl Into<String>) {
        let (what, mut ignored) = (what.into(), self.ignored.borrow_mut());
        if !ignored.contains(&what) {
            ignored.push(what);
        }
    }

    /// Everything noted, as one sentence; `None` where all of the file is rendered.
    pub fn ignored(&self) -> Option<String> {
        let ignored = self.ignored.borrow();
        (!ignored.is_empty()).then(|| format!("not rendered of {}: {}", self.path.display(), ignored.join(", ")))
    }

    /// An error about this file.
    pub fn error(&self, reason: impl Display) -> Error {
        Error::file(&self.path, reason)
    }

    fn read_buffer(&self, i: usize, chunk: Option<&'a [u8]>) -> Result<Cow<'a, [u8]>> {
        let buffer = &self.root.buffers[i];
        let data = match (&buffer.uri, chunk) {
            (Some(uri), _) => Cow::Owned(self.fetch(&format!("buffer {i}"), uri)?),
            (None, Some(chunk)) if i == 0 => Cow::Borrowed(chunk),
            (None, _) => return Err(self.error(format_args!("buffer {i} has no uri and the file no chunk for it"))),
        };
        let announced = buffer.byte_length.0;
        if (data.len() as u64) < announced {
            let (name, len) = (buffer.uri.as_deref().map_or("the binary chunk", shorten), data.len());
            return Err(self
                .error(format_args!("buffer {i} ({name}) is truncated: {announced} bytes announced, {len} present")));
        }
        Ok(data)
    }

    /// The bytes a URI stands for: a data URI or a file beside the glTF.
    pub fn fetch(&self, what: &str, uri: &str) -> Result<Vec<u8>> {
        if let Some(data) = uri.strip_prefix("data:") {
            return decode_data_uri(data).map_err(|why| self.error(format_args!("the data URI of {what} {why}")));
        }
        let name = shorten(uri);
        if uri.contains("://") {
            return Err(self.error(format_args!("{what} is at `{name}`: only files and data URIs can be read")));
        }
        let Some(base) = &self.base else {
            return Err(self.error(format_args!("{what} is the external file `{name}`, which a scene in memory lacks")));
        };
        let decoded = percent_encoding::percent_decode_str(uri).decode_utf8_lossy();
        let mut file = base.join(decoded.as_ref());
        if !file.exists() {
            file = base.join(uri); // a name that holds a bare percent sign
        }
        // Devices and pipes could be endless, so only regular files are read.
        let read = match std::fs::metadata(&file) {
            Ok(meta) if !meta.is_file() => Err("not a regular file".to_owned()),
            Ok(_) => std::fs::read(&file).map_err(|e| e.to_string()),
            Err(e) => Err(e.to_string()),
        };
        read.map_err(|why| self.error(format_args!("{what}, the file `{name}`, cannot be read: {why}")))
    }

    /// The bytes of a buffer view, its stride, and a check that both lie inside the buffer.
    pub fn view(&self, what: &str, index: Index<buffer::View>) -> Result<(&[u8], Option<usize>)> {
        let i = index.value();
        let Some(view) = self.root.buffer_views.get(i) else {
            return Err(self.error(format_args!("{what} refers to buffer view {i}, which does not exist")));
        };
        let Some(buffer) = self.buffers.get(view.buffer.value()) else {
            let b = view.buffer.value();
            return Err(self.error(format_args!("buffer view {i} refers to buffer {b}, which does not exist")));
        };
        let start = view.byte_offset.unwrap_or_default().0;
        let bytes = start.checked_add(view.byte_length.0).and_then(|end| {
            let (start, end) = (usize::try_from(start).ok()?, usize::try_from(end).ok()?);
            buffer.get(start..end)
        });
        let Some(bytes) = bytes else {
            let (len, have) = (view.byte_length.0, buffer.len());
            return Err(self.error(format_args!(
                "buffer view {i} ({len} bytes from byte {start}) reaches beyond its buffer of {have} bytes"
            )));
        };
        Ok((bytes, view.byte_stride.map(|s| s.0).filter(|s| *s != 0)))
    }
}

/// A URI short enough for an error message.
pub(super) fn shorten(uri: &str) -> &str {
    if uri.starts_with("data:") {
        return "a data URI";
    }
    let end = uri.char_indices().nth(200).map_or(uri.len(), |(i, _)| i);
    &uri[..end]
}

fn decode_data_uri(data: &str) -> std::result::Result<Vec<u8>, String> {
    let (head, body) = data.split_once(',').ok_or("has no comma")?;
    let body: Vec<u8> = percent_encoding::percent_decode_str(body).collect();
    if !head.ends_with(";base64") {
        return Ok(body);
    }
    let config = GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent);
    GeneralPurpose::new(&base64::alphabet::STANDARD, config).decode(body).map_err(|e| format!("is not base64: {e}"))
}

/// The JSON text and the binary chunk of a GLB; other bytes are taken for JSON text.
fn split_glb<'a>(path: &Path, bytes: &'a [u8]) -> Result<(&'a [u8], Option<&'a [u8]>)> {
    if !bytes.starts_with(b"glTF") {
        return Ok((bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes), None));
    }
    let fail = |reason: String| Err(Error::file(path, reason));
    let word = |at: usize| -> Option<usize> {
        let bytes = bytes.get(at..at.checked_add(4)?)?;
        usize::try_from(u32::from_le_bytes(bytes.try_into().ok()?)).ok()
    };
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        return fail("the GLB is truncated within its header".into());
    };
    if version != 2 {
        return fail(format!("the GLB has version {version}; only version 2 can be read"));
    }
    if length > bytes.len() {
        return fail(format!("the GLB is truncated: {length} bytes announced, {} present", bytes.len()));
    }
    let (mut text, mut chunk, mut at) = (None, None, 12usize);
    while at + 8 <= length {
        let (size, kind) = (word(at).unwrap_or(0), &bytes[at + 4..at + 8]);
        let Some(data) = (at + 8).checked_add(size).filter(|end| *end <= length).map(|end| &bytes[at + 8..end]) else {
            return fail(format!("the GLB is truncated: a chunk of {size} bytes reaches beyond its end"));
        };
        match kind {
            b"JSON" if text.is_none() => text = Some(data),
            b"BIN\0" if chunk.is_none() => chunk = Some(data),
            _ => {} // the specification has unknown chunks ignored
        }
        at += 8 + size.next_multiple_of(4);
    }
    match text {
        Some(text) => Ok((text, chunk)),
        None => fail("the GLB has no JSON chunk".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::testing::glb_from;

    #[test]
    fn splits_a_glb() {
        let glb = glb_from("{}", &[1, 2, 3]);
        let (text, chunk) = split_glb(Path::new("x"), &glb).unwrap();
        assert_eq!(text, b"{}  ");
        assert_eq!(chunk.unwrap(), [1, 2, 3, 0]);
        let broken = split_glb(Path::new("x.glb"), &glb[..20]).unwrap_err().to_string();
        assert!(broken.starts_with("x.glb: the GLB is truncated"), "{broken}");
    }

    #[test]
    fn decodes_data_uris() {
        assert_eq!(decode_data_uri("application/octet-stream;base64,AAEC").unwrap(), [0, 1, 2]);
        assert_eq!(decode_data_uri(";base64,AAE").unwrap(), [0, 1], "padding is optional");
        assert_eq!(decode_data_uri(",a%20b").unwrap(), b"a b");
        assert!(decode_data_uri(";base64,!").is_err());
        assert!(decode_data_uri("nothing").is_err());
    }

    #[test]
    fn long_names_are_cut_between_characters() {
        assert_eq!(shorten("data:xyz"), "a data URI");
        assert_eq!(shorten(&"é".repeat(300)).chars().count(), 200);
    }
}
