//! How a struct that shaders read is described: declared once, in Rust, from which come the GLSL and a table of fields.

use std::fmt::Write as _;

/// Kind of the numbers in a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FieldKind {
    /// 32-bit floats.
    Float,
    /// 32-bit unsigned integers.
    Uint,
    /// Structs, described by themselves.
    Struct,
}

/// One field of a shared struct.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FieldInfo {
    /// Name, the same in GLSL.
    pub name: &'static str,
    /// Where it begins in the struct.
    pub offset_bytes: usize,
    /// Its type, or its elements' type, in GLSL.
    pub glsl_type: &'static str,
    /// Length in GLSL where it is an array.
    pub array_length: Option<usize>,
    /// Kind of its numbers.
    pub kind: FieldKind,
    /// Shape of its numbers; empty for one number and for structs.
    pub shape: &'static [usize],
}

impl FieldInfo {
    /// Whether it only fills up the struct.
    #[must_use]
    pub fn is_padding(&self) -> bool {
        self.name == "padding"
    }
}

/// A struct that shaders read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StructInfo {
    /// Name in GLSL.
    pub name: &'static str,
    /// Its size, also the stride of arrays of it.
    pub size_bytes: usize,
    /// Its fields in order.
    pub fields: &'static [FieldInfo],
}

impl StructInfo {
    /// The field of this name.
    #[must_use]
    pub fn field(&self, name: &str) -> Option<&'static FieldInfo> {
        self.fields.iter().find(|field| field.name == name)
    }

    /// Its declaration in GLSL.
    #[must_use]
    pub fn glsl(&self) -> String {
        let mut text = format!("struct {} {{\n", self.name);
        for FieldInfo { name, glsl_type, array_length, .. } in self.fields {
            let length = array_length.map_or(String::new(), |length| format!("[{length}]"));
            let _ = writeln!(text, "    {glsl_type} {name}{length};");
        }
        text + "};\n"
    }
}

/// A struct with its description.
pub trait SharedStruct {
    /// The description.
    const INFO: StructInfo;
}

/// A type that a field may have.
pub(super) trait FieldType {
    /// Name in GLSL.
    const NAME: &'static str;
    /// Length in GLSL where it is an array.
    const ARRAY_LENGTH: Option<usize> = None;
    /// Kind of its numbers.
    const KIND: FieldKind;
    /// Shape of its numbers.
    const SHAPE: &'static [usize];
}

macro_rules! field_types {
    ($($type:ty => $name:literal, $kind:ident, $shape:expr;)*) => {
        $(impl FieldType for $type {
            const NAME: &'static str = $name;
            const KIND: FieldKind = FieldKind::$kind;
            const SHAPE: &'static [usize] = &$shape;
        })*
    };
}

field_types! {
    f32 => "float", Float, [];
    [f32; 2] => "vec2", Float, [2];
    [f32; 3] => "vec3", Float, [3];
    [f32; 4] => "vec4", Float, [4];
    [[f32; 4]; 4] => "mat4", Float, [4, 4];
    u32 => "uint", Uint, [];
    [u32; 2] => "uvec2", Uint, [2];
}

impl<const N: usize> FieldType for [[u32; 4]; N] {
    const NAME: &'static str = "uvec4";
    const ARRAY_LENGTH: Option<usize> = Some(N);
    const KIND: FieldKind = FieldKind::Uint;
    const SHAPE: &'static [usize] = &[N, 4];
}

impl<T: SharedStruct, const N: usize> FieldType for [T; N] {
    const NAME: &'static str = T::INFO.name;
    const ARRAY_LENGTH: Option<usize> = Some(N);
    const KIND: FieldKind = FieldKind::Struct;
    const SHAPE: &'static [usize] = &[];
}

/// Declares structs that shaders read, and [`structs::ALL`](super::structs::ALL). The name in GLSL follows the one in Rust.
macro_rules! shared_structs {
    ($(
        $(#[$doc:meta])*
        pub struct $type:ident as $name:literal {
            $($(#[$field_doc:meta])* pub $field:ident: $field_type:ty,)*
        }
    )*) => {
        $(
            $(#[$doc])*
            #[repr(C)]
            #[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
            pub struct $type {
                $($(#[$field_doc])* pub $field: $field_type,)*
            }

            impl SharedStruct for $type {
                const INFO: StructInfo = StructInfo {
                    name: $name,
                    size_bytes: size_of::<$type>(),
                    fields: &[$(FieldInfo {
                        name: stringify!($field),
                        offset_bytes: offset_of!($type, $field),
                        glsl_type: <$field_type as FieldType>::NAME,
                        array_length: <$field_type as FieldType>::ARRAY_LENGTH,
                        kind: <$field_type as FieldType>::KIND,
                        shape: <$field_type as FieldType>::SHAPE,
                    }),*],
                };
            }
        )*

        /// Every struct that shaders read.
        pub const ALL: &[StructInfo] = &[$($type::INFO),*];
    };
}
pub(super) use shared_structs;
