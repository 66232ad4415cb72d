//! Rebuilds `shaders/spirv/` from the GLSL. Run it with `tools/compile-shaders`.

use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    match gridlight::shader::compile::compile_all(&Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders")) {
        Ok(compiled) => {
            compiled.iter().for_each(|name| eprintln!("compiled {name}"));
            eprintln!("{} shader(s) compiled", compiled.len());
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(error.exit_code())
        }
    }
}
