//! Shaders: sources and variants, the committed SPIR-V and its interfaces, and (feature `shader-compiler`) the compiler.

#[cfg(feature = "shader-compiler")]
pub mod compile;
pub mod interface;
#[cfg(any(test, feature = "shader-compiler"))]
pub mod reflect;
pub mod source;
pub mod spirv;
pub mod variants;
