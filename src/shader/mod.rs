//! Shaders: sources and variants, the committed SPIR-V, and (feature `shader-compiler`) the compiler.

#[cfg(feature = "shader-compiler")]
pub mod compile;
pub mod source;
pub mod spirv;
pub mod variants;
