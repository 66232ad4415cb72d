//! What people have in place of the file that they mean.

/// What a file is by its first bytes, as a sentence about it, if it is something that stands in the place of many files.
#[must_use]
pub fn mistaken(start: &[u8]) -> Option<&'static str> {
    let text = start.strip_prefix(b"\xef\xbb\xbf").unwrap_or(start).trim_ascii_start();
    let begins = |word: &str| text.get(..word.len()).is_some_and(|begin| begin.eq_ignore_ascii_case(word.as_bytes()));
    Some(match () {
        () if start.is_empty() => "it is empty",
        () if begins("version https://git-lfs") => {
            "it is a pointer of Git LFS, and the file itself has not been fetched"
        }
        () if start.starts_with(b"\x1f\x8b") => "it is compressed by gzip",
        () if start.starts_with(b"PK\x03\x04") => "it is a ZIP archive",
        () if begins("<!doctype html") || begins("<html") => "it is a web page",
        () if begins("<?xml") || begins("<svg") => "it is XML",
        () => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_stands_in_place_of_files_is_named() {
        for (start, what) in [
            (&b""[..], Some("it is empty")),
            (b"version https://git-lfs.github.com/spec/v1\noid sha256:1", Some("Git LFS")),
            (b"\x1f\x8b\x08", Some("gzip")),
            (b"PK\x03\x04", Some("ZIP")),
            (b"\xef\xbb\xbf\r\n <!DOCTYPE HTML>", Some("web page")),
            (b"<html lang=en>", Some("web page")),
            (b"<svg xmlns=", Some("XML")),
            (b"{\"asset\":", None),
            (b"version 1", None),
            (b"<", None),
        ] {
            match what {
                Some(what) => assert!(mistaken(start).is_some_and(|said| said.contains(what)), "{what}"),
                None => assert_eq!(mistaken(start), None),
            }
        }
    }
}
