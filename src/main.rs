//! The gridlight program; everything is in the library.

use std::process::ExitCode;

fn main() -> ExitCode {
    gridlight::app::run(std::env::args_os())
}
