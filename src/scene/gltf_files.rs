//! The files that a glTF names, found as the specification has it, or else as whoever wrote the name will have meant.

use std::borrow::Cow;
use std::path::{Component, Path, PathBuf};

/// A file that a glTF names.
#[derive(Debug, PartialEq)]
pub(super) struct Named {
    /// Where it is; where it should be if it is not there.
    pub path: PathBuf,
    /// What is wrong with the name, as things that the file has.
    pub faults: Vec<&'static str>,
}

/// What follows the scheme of a data URI.
pub(super) fn data_of(uri: &str) -> Option<&str> {
    let (scheme, data) = uri.trim_start().split_at_checked(5)?;
    scheme.eq_ignore_ascii_case("data:").then_some(data)
}

/// Whether a URI names something that is no file.
pub(super) fn is_remote(uri: &str) -> bool {
    uri.contains("://") && !has_file_scheme(uri)
}

fn has_file_scheme(uri: &str) -> bool {
    uri.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case("file:"))
}

/// The file that `uri` names, relative to `base`.
pub(super) fn find(base: &Path, uri: &str) -> Named {
    let decoded = percent_encoding::percent_decode_str(uri).decode_utf8_lossy();
    let as_written = [decoded.as_ref(), uri].map(|name| base.join(name)); // the second for a bare percent sign
    if let Some(path) = as_written.iter().find(|path| path.exists()) {
        return Named { path: path.clone(), faults: Vec::new() };
    }
    let (name, mut faults) = mend(&decoded);
    let path = base.join(name.as_ref());
    if path.exists() {
        return Named { path, faults };
    }
    // The folders of another machine are unknown here, but what lay in them may lie beside the glTF.
    let parts: Vec<&Path> = Path::new(name.as_ref())
        .components()
        .filter_map(|part| if let Component::Normal(part) = part { Some(Path::new(part)) } else { None })
        .collect();
    let rests = (0..parts.len()).map(|first| parts[first..].iter().collect::<PathBuf>());
    if let Some((is_whole, path)) = rests.enumerate().find_map(|(i, rest)| Some((i == 0, in_any_case(base, &rest)?))) {
        let relative = path.strip_prefix(base).unwrap_or(&path);
        if !(is_whole && Path::new(name.as_ref()).is_relative()) {
            faults.push("names of files in folders that are not there");
        }
        if !Path::new(name.as_ref()).ends_with(relative) {
            faults.push("names of files in another case");
        }
        return Named { path, faults };
    }
    let [path, _] = as_written;
    Named { path, faults: Vec::new() }
}

/// A name without a scheme, a drive, backslashes and a query, with what of these it had.
fn mend(name: &str) -> (Cow<'_, str>, Vec<&'static str>) {
    let (mut text, mut faults) = (Cow::Borrowed(name.trim()), Vec::new());
    if text.len() < name.len() {
        faults.push("spaces around names of files");
    }
    let name = name.trim();
    if has_file_scheme(name) {
        let path = name[5..].trim_start_matches("//localhost/").trim_start_matches("//");
        text = Cow::Borrowed(path);
        faults.push("file: URIs");
    }
    if text.contains('\\') {
        text = text.replace('\\', "/").into();
        faults.push("backslashes in names of files");
    }
    let rooted = text.trim_start_matches('/');
    if rooted.len() > 1 && rooted.as_bytes()[0].is_ascii_alphabetic() && rooted.as_bytes()[1] == b':' {
        text = format!("/{}", rooted[2..].trim_start_matches('/')).into();
    }
    if let Some(end) = text.find(['?', '#']) {
        text = text[..end].to_owned().into();
        faults.push("queries behind names of files");
    }
    (text, faults)
}

/// The file of this relative name, whatever the case of its letters.
fn in_any_case(base: &Path, name: &Path) -> Option<PathBuf> {
    let mut path = base.to_path_buf();
    for part in name.components() {
        let exact = path.join(part);
        if exact.exists() {
            path = exact;
            continue;
        }
        let wanted = part.as_os_str().to_str()?.to_lowercase();
        let folder = if path.as_os_str().is_empty() { Path::new(".") } else { path.as_path() };
        let mut names: Vec<_> = std::fs::read_dir(folder).ok()?.flatten().map(|entry| entry.file_name()).collect();
        names.sort();
        let found = names.into_iter().find(|name| name.to_str().is_some_and(|name| name.to_lowercase() == wanted))?;
        path = path.join(found);
    }
    Some(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_found_by_what_tools_write() {
        let folder = tempfile::tempdir().unwrap();
        let base = folder.path();
        std::fs::create_dir(base.join("Textures")).unwrap();
        for name in ["Textures/a b.PNG", "50%.bin", "plain.bin", "what?.bin"] {
            std::fs::write(base.join(name), [0]).unwrap();
        }
        let whole = base.join("plain.bin").display().to_string();
        let elsewhere = "names of files in folders that are not there";
        for (uri, file, faults) in [
            ("plain.bin", "plain.bin", &[][..]),
            ("./plain.bin", "./plain.bin", &[]),
            ("Textures/a%20b.PNG", "Textures/a b.PNG", &[]),
            ("50%.bin", "50%.bin", &[]),
            ("what?.bin", "what?.bin", &[]),
            (&whole, "plain.bin", &[]),
            ("Textures\\a b.PNG", "Textures/a b.PNG", &["backslashes in names of files"]),
            ("Textures%5Ca%20b.PNG", "Textures/a b.PNG", &["backslashes in names of files"]),
            (".\\plain.bin", "./plain.bin", &["backslashes in names of files"]),
            ("textures/A B.png", "Textures/a b.PNG", &["names of files in another case"]),
            ("/home/me/model/plain.bin", "plain.bin", &[elsewhere]),
            ("/home/me/Textures/a b.PNG", "Textures/a b.PNG", &[elsewhere]),
            ("C:\\me\\Textures\\a b.PNG", "Textures/a b.PNG", &["backslashes in names of files", elsewhere]),
            ("file:///C:/me/plain.bin", "plain.bin", &["file: URIs", elsewhere]),
            ("FILE:plain.bin", "plain.bin", &["file: URIs"]),
            (" plain.bin\n", "plain.bin", &["spaces around names of files"]),
            ("plain.bin?v=3", "plain.bin", &["queries behind names of files"]),
            ("there/plain.bin", "plain.bin", &[elsewhere]),
        ] {
            let expected = Named { path: base.join(file), faults: faults.to_vec() };
            assert_eq!(find(base, uri), expected, "{uri}");
        }
        let uri = format!("file://{whole}");
        assert_eq!(find(base, &uri), Named { path: base.join("plain.bin"), faults: vec!["file: URIs"] });
        assert_eq!(find(base, "no\\where.bin").path, base.join("no\\where.bin"), "the name stays as written");
    }

    #[test]
    fn other_schemes_are_no_files() {
        assert!(is_remote("http://a/b.png") && is_remote("data://x"));
        assert!(!is_remote("file:///a/b.png") && !is_remote("a/b.png") && !is_remote("C:/b.png"));
    }
}
