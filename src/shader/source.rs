//! GLSL sources as they are compiled: includes resolved, Rust constants inserted, a hash to detect stale SPIR-V.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use super::variants::{Stage, Variant, variants_of};
use crate::error::{Error, Result};
use crate::shared;

/// The virtual include that carries the constants of [`crate::shared`].
pub const CONSTANTS_INCLUDE: &str = "constants.glsl";

/// The virtual folder of the includes that carry the structs of [`crate::shared`].
const STRUCT_INCLUDES: &str = "shared/";

/// One shader variant with its whole source in one string.
pub struct ShaderSource {
    /// Name of the variant: folder, verb_noun, optional suffix and stage, as in `gbuffer/draw_scene.frag`.
    pub name: String,
    /// Pipeline stage.
    pub stage: Stage,
    /// The source with includes expanded and defines inserted.
    pub text: String,
    /// File and line that each line of the text is from.
    pub origins: Vec<(PathBuf, usize)>,
}

impl ShaderSource {
    /// A message of the compiler with lines of the text replaced by those of the files that they are from.
    #[must_use]
    pub fn relocate(&self, message: &str) -> String {
        let place = format!("{}:", self.name);
        let mut parts = message.split(&place);
        let mut relocated = parts.next().unwrap_or_default().to_owned();
        for part in parts {
            let digits = part.bytes().take_while(u8::is_ascii_digit).count();
            let origin = part[..digits].parse::<usize>().ok().and_then(|line| self.origins.get(line.checked_sub(1)?));
            match origin {
                Some((file, line)) => relocated += &format!("{}:{line}{}", file.display(), &part[digits..]),
                None => relocated += &format!("{place}{part}"),
            }
        }
        relocated
    }

    /// SHA-256 of the flattened source, as lower-case hex.
    #[must_use]
    pub fn hash(&self) -> String {
        Sha256::digest(self.text.as_bytes()).iter().fold(String::new(), |mut hex, byte| {
            let _ = write!(hex, "{byte:02x}");
            hex
        })
    }
}

/// Every shader variant under `shaders_dir`, sorted by name.
///
/// # Errors
/// When a file cannot be read, an include does not exist or a name has an unknown stage.
pub fn all_sources(shaders_dir: &Path) -> Result<Vec<ShaderSource>> {
    let mut files = Vec::new();
    collect(shaders_dir, &mut files)?;
    files.sort();
    let mut sources = Vec::new();
    for file in files {
        let relative = file.strip_prefix(shaders_dir).unwrap_or(&file).to_string_lossy().replace('\\', "/");
        for variant in variants_of(&relative)? {
            sources.push(flatten(shaders_dir, &file, &variant)?);
        }
    }
    sources.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(sources)
}

/// Entry points are the files named `*.vert.glsl`, `*.frag.glsl` and `*.comp.glsl`; other `.glsl` files are includes.
fn collect(dir: &Path, files: &mut Vec<PathBuf>) -> Result<()> {
    for entry in std::fs::read_dir(dir).map_err(|e| Error::file(dir, e))? {
        let path = entry.map_err(|e| Error::file(dir, e))?.path();
        let name = path.to_string_lossy();
        if path.is_dir() {
            collect(&path, files)?;
        } else if [".vert.glsl", ".frag.glsl", ".comp.glsl"].iter().any(|end| name.ends_with(end)) {
            files.push(path);
        }
    }
    Ok(())
}

fn flatten(shaders_dir: &Path, file: &Path, variant: &Variant) -> Result<ShaderSource> {
    let mut text = String::from("#version 460\n");
    for (key, value) in &variant.defines {
        let _ = writeln!(text, "#define {key} {value}");
    }
    let origins = vec![(file.to_path_buf(), 0); 1 + variant.defines.len()];
    let mut source = ShaderSource { name: variant.name.clone(), stage: variant.stage, text, origins };
    include(shaders_dir, file, &mut BTreeSet::new(), &mut source)?;
    Ok(source)
}

/// The text of an include that is made from Rust: the constants, or one struct of [`crate::shared`].
fn generated(target: &str) -> Option<String> {
    let name = target.strip_prefix(STRUCT_INCLUDES).and_then(|file| file.strip_suffix(".glsl"));
    if target == CONSTANTS_INCLUDE { Some(shared::glsl_constants()) } else { shared::glsl_struct(name?) }
}

/// Appends `file` with its `#include "path"` lines (relative to `shaders/`) expanded, each file once.
fn include(shaders_dir: &Path, file: &Path, seen: &mut BTreeSet<PathBuf>, into: &mut ShaderSource) -> Result<()> {
    if !seen.insert(file.to_path_buf()) {
        return Ok(());
    }
    let source = std::fs::read_to_string(file).map_err(|e| Error::file(file, e))?;
    for (index, line) in source.lines().enumerate() {
        let Some(rest) = line.trim_start().strip_prefix("#include \"") else {
            into.text.push_str(line);
            into.text.push('\n');
            into.origins.push((file.to_path_buf(), index + 1));
            continue;
        };
        let target = rest.trim_end().trim_end_matches('"');
        if let Some(generated) = generated(target) {
            if seen.insert(PathBuf::from(target)) {
                let lines = generated.lines().count();
                into.text.push_str(&generated);
                into.origins.extend((1..=lines).map(|line| (PathBuf::from(target), line)));
            }
        } else {
            include(shaders_dir, &shaders_dir.join(target), seen, into)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn includes_are_expanded_once_and_constants_inserted() {
        let dir = tempfile::tempdir().unwrap();
        std::fs::write(dir.path().join("a.glsl"), "// a\n").unwrap();
        std::fs::write(dir.path().join("b.glsl"), "#include \"a.glsl\"\n// b\n").unwrap();
        let main = dir.path().join("do_it.comp.glsl");
        std::fs::write(
            &main,
            "#include \"a.glsl\"\n#include \"b.glsl\"\n#include \"constants.glsl\"\nvoid main() {}\n",
        )
        .unwrap();
        let sources = all_sources(dir.path()).unwrap();
        assert_eq!(sources.len(), 1);
        assert_eq!(sources[0].name, "do_it.comp");
        assert_eq!(sources[0].text.matches("// a").count(), 1);
        assert!(sources[0].text.contains("#define WORKGROUP_SIZE"));
        // The text's lines and their origins go together.
        assert_eq!(sources[0].origins.len(), sources[0].text.lines().count());
        let line = 1 + sources[0].text.lines().position(|line| line == "// b").unwrap();
        let message = sources[0].relocate(&format!("do_it.comp:{line}: error: no such thing"));
        assert!(message.ends_with("b.glsl:2: error: no such thing"), "{message}");
    }

    #[test]
    fn a_missing_include_names_the_file() {
        let dir = tempfile::tempdir().unwrap();
        std::fs::write(dir.path().join("x.comp.glsl"), "#include \"nowhere.glsl\"\n").unwrap();
        let error = all_sources(dir.path()).err().unwrap().to_string();
        assert!(error.contains("nowhere.glsl"), "{error}");
    }
}
