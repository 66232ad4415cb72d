//! The GLB container: its JSON text and its binary chunk.

use std::path::Path;

use crate::files::mistaken;
use crate::{Error, Result};

/// What a file consists of.
#[derive(Default)]
pub(super) struct Parts<'a> {
    /// The JSON text without byte order mark and padding.
    pub text: &'a [u8],
    /// The binary chunk.
    pub chunk: Option<&'a [u8]>,
    /// What is wrong with the container and leaves no doubt of what is meant.
    pub faults: Vec<&'static str>,
}

/// Takes a GLB apart; other bytes are taken for JSON text.
///
/// # Errors
/// [`Error::File`] for another version, and where the JSON is not whole.
pub(super) fn split<'a>(path: &Path, bytes: &'a [u8]) -> Result<Parts<'a>> {
    let mut parts = Parts::default();
    if bytes.starts_with(b"glTF") {
        parts.read_chunks(bytes).map_err(|reason| Error::file(path, reason))?;
    } else if let Some(what) = mistaken(bytes) {
        return Err(Error::file(path, what));
    } else {
        parts.text = bytes;
    }
    if is_wide(parts.text) {
        return Err(Error::file(path, "its JSON is in UTF-16, and glTF is in UTF-8"));
    }
    parts.trim();
    Ok(parts)
}

/// Whether a JSON object begins here in UTF-16, with a byte order mark or without.
fn is_wide(text: &[u8]) -> bool {
    [b"\xff\xfe", b"\xfe\xff", b"{\0", b"\0{"].iter().any(|begin| text.starts_with(*begin))
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(bytes.get(at..at.checked_add(4)?)?.try_into().ok()?))
}

impl<'a> Parts<'a> {
    /// Finds the first JSON and the first binary chunk; the specification has unknown chunks ignored.
    fn read_chunks(&mut self, bytes: &'a [u8]) -> std::result::Result<(), String> {
        let (Some(version), Some(length)) = (word(bytes, 4), word(bytes, 8)) else {
            return Err("the GLB is truncated within its header".into());
        };
        if version != 2 {
            return Err(format!("the GLB is of glTF version {version}; only version 2 can be read"));
        }
        if length as usize != bytes.len() {
            self.faults.push("a length in the header that is not the file's");
        }
        let (mut at, mut has_text) = (12, false);
        while let (Some(size), Some(kind)) = (word(bytes, at), bytes.get(at + 4..at + 8)) {
            let rest = &bytes[at + 8..];
            let data = rest.get(..size as usize);
            match (kind, data) {
                (b"JSON", None) if !has_text => {
                    let have = rest.len();
                    return Err(format!("the GLB is truncated: a JSON of {size} bytes announced, {have} present"));
                }
                (b"JSON", Some(data)) if !has_text => (self.text, has_text) = (data, true),
                (b"BIN\0", None) if self.chunk.is_none() => {
                    // Whether all of the buffer is there shows when it is read.
                    self.chunk = Some(rest);
                    self.faults.push("a length of the binary chunk that is not the file's");
                }
                (b"BIN\0", Some(data)) if self.chunk.is_none() => self.chunk = Some(data),
                _ => {}
            }
            if data.is_none() {
                break;
            }
            at = self.next_chunk(bytes, at + 8, size as usize);
        }
        if has_text { Ok(()) } else { Err("the GLB has no JSON chunk".into()) }
    }

    /// Where the chunk behind `size` bytes begins: chunks are padded to four bytes, whether or not their length says so.
    fn next_chunk(&mut self, bytes: &[u8], at: usize, size: usize) -> usize {
        let (bare, padded) = (at + size, at + size.next_multiple_of(4));
        if bare == padded {
            return padded;
        }
        let begins = |at: usize| bytes.get(at + 4..at + 8) == Some(b"BIN\0");
        self.faults.push("a chunk length that is no multiple of four");
        if begins(bare) && !begins(padded) { bare } else { padded }
    }

    /// Takes the byte order mark and the padding off the text. Padding is white space; some pad with zeros.
    fn trim(&mut self) {
        let text = self.text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(self.text);
        let end = text.iter().rposition(|byte| *byte != 0 && !byte.is_ascii_whitespace()).map_or(0, |last| last + 1);
        if text[end..].contains(&0) {
            self.faults.push("zeros behind the JSON");
        }
        self.text = &text[..end];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::testing::glb_from;

    fn parts(bytes: &[u8]) -> Parts<'_> {
        split(Path::new("x.glb"), bytes).unwrap()
    }

    #[test]
    fn a_whole_glb_has_no_fault() {
        let glb = glb_from("{}", &[1, 2, 3]);
        let found = parts(&glb);
        assert_eq!((found.text, found.chunk, found.faults.len()), (&b"{}"[..], Some(&[1, 2, 3, 0][..]), 0));
        assert_eq!(parts(b"\xef\xbb\xbf{ }\r\n ").text, b"{ }");
        let wide = split(Path::new("x.gltf"), b"\xff\xfe{\0}\0").err().unwrap().to_string();
        assert_eq!(wide, "x.gltf: its JSON is in UTF-16, and glTF is in UTF-8");
        let broken = split(Path::new("x.glb"), &glb[..20]).err().unwrap().to_string();
        assert_eq!(broken, "x.glb: the GLB is truncated: a JSON of 4 bytes announced, 0 present");
    }

    #[test]
    fn wrong_lengths_are_told() {
        for (wrong, at, length) in [("the header", 8, 20u32), ("the header", 8, 4000), ("the binary chunk", 24, 4000)] {
            let mut glb = glb_from("{}", &[1, 2, 3]);
            glb[at..at + 4].copy_from_slice(&length.to_le_bytes());
            let found = parts(&glb);
            assert_eq!((found.text, found.chunk), (&b"{}"[..], Some(&[1, 2, 3, 0][..])), "{wrong}");
            assert!(found.faults.len() == 1 && found.faults[0].contains(wrong), "{:?}", found.faults);
        }
        let behind = [glb_from("{}", &[1, 2, 3]), b"more than a header".to_vec()].concat();
        assert_eq!(parts(&behind).chunk, Some(&[1, 2, 3, 0][..]));
    }

    #[test]
    fn padding_may_be_left_out_or_zero() {
        let json = |size: u32, padding: &[u8]| {
            let binary = [&4u32.to_le_bytes()[..], b"BIN\0\x01\x02\x03\x04"].concat();
            let chunk = [&size.to_le_bytes()[..], b"JSON{}", padding, &binary].concat();
            [&b"glTF\x02\0\0\0"[..], &(12 + chunk.len() as u32).to_le_bytes(), &chunk].concat()
        };
        for (glb, fault) in [
            (json(4, b"  "), None),
            (json(4, b"\0\0"), Some("zeros behind the JSON")),
            (json(2, b"  "), Some("a chunk length that is no multiple of four")),
            (json(2, b""), Some("a chunk length that is no multiple of four")),
        ] {
            let found = parts(&glb);
            assert_eq!((found.text, found.chunk), (&b"{}"[..], Some(&[1, 2, 3, 4][..])), "{fault:?}");
            assert_eq!(found.faults, Vec::from_iter(fault));
        }
    }
}
