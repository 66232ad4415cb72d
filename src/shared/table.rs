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

    /// In GLSL, its value among the texels of the struct `of`.
    fn glsl_in_texel(&self, of: &str) -> String {
        let Self { name, offset_bytes, kind, shape, array_length, .. } = self;
        let words = shape.iter().product::<usize>();
        let (texel, first) = (offset_bytes / TEXEL_BYTES, offset_bytes % TEXEL_BYTES / 4);
        assert!(array_length.is_none() && first + words <= 4, "{name} of {of} does not lie in one texel");
        let value = format!("texel{texel}.{}", &"xyzw"[first..first + words]);
        if *kind == FieldKind::Float { format!("uintBitsToFloat({value})") } else { value }
    }
}

/// A texel of four words.
const TEXEL_BYTES: usize = 16;

/// `BvhNode` as `bvh_node`.
fn snake_case(name: &str) -> String {
    let mut snake = String::new();
    for (i, c) in name.char_indices() {
        if c.is_uppercase() && i > 0 {
            snake.push('_');
        }
        snake.extend(c.to_lowercase());
    }
    snake
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

    /// In GLSL, how many texels of four words it takes, and the function that puts it together from their words.
    ///
    /// # Panics
    /// When a field lies in two texels, or the last texel is not full.
    #[must_use]
    pub(super) fn glsl_from_texels(&self) -> String {
        let Self { name, size_bytes, .. } = self;
        assert!(size_bytes % TEXEL_BYTES == 0, "{name} does not fill its texels");
        let texels = size_bytes / TEXEL_BYTES;
        let snake = snake_case(name);
        let parameters: Vec<String> = (0..texels).map(|i| format!("uvec4 texel{i}")).collect();
        let values: Vec<String> = self.fields.iter().map(|field| field.glsl_in_texel(name)).collect();
        format!(
            "const uint {}_TEXELS = {texels}u;\n{name} {snake}_from_texels({}) {{\n    return {name}({});\n}}\n",
            snake.to_uppercase(),
            parameters.join(", "),
            values.join(", ")
        )
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
    [u32; 3] => "uvec3", Uint, [3];
    [u32; 4] => "uvec4", Uint, [4];
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

/// Declares structs that shaders read, and `ALL` of them. The name in GLSL follows the one in Rust.
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

        /// Every struct that is declared here.
        pub const ALL: &[StructInfo] = &[$($type::INFO),*];
    };
}
pub(super) use shared_structs;

#[cfg(test)]
mod tests {
    use super::super::{BvhTriangle, glsl_struct};
    use super::*;

    #[test]
    fn a_struct_is_put_together_from_texels() {
        let text = glsl_struct("BvhTriangle").unwrap();
        assert!(text.contains("const uint BVH_TRIANGLE_TEXELS = 3u;\n"), "{text}");
        let function = "BvhTriangle bvh_triangle_from_texels(uvec4 texel0, uvec4 texel1, uvec4 texel2) {\n    \
                        return BvhTriangle(uintBitsToFloat(texel0.xyz), texel0.w, uintBitsToFloat(texel1.xyz), \
                        texel1.w, uintBitsToFloat(texel2.xyz), texel2.w);\n}\n";
        assert!(text.contains(function), "{text}");
        assert!(glsl_struct("BvhNode").unwrap().contains("texel1.x, texel1.y, texel1.zw, texel2.xyzw"));
    }

    /// A triangle whose field `index` begins elsewhere.
    fn moved(index: usize, offset_bytes: usize) -> StructInfo {
        let mut fields = BvhTriangle::INFO.fields.to_vec();
        fields[index].offset_bytes = offset_bytes;
        StructInfo { fields: fields.leak(), ..BvhTriangle::INFO }
    }

    #[test]
    #[should_panic(expected = "edge1 of BvhTriangle does not lie in one texel")]
    fn a_field_in_two_texels_is_noticed() {
        let _ = moved(2, 8).glsl_from_texels();
    }

    #[test]
    #[should_panic(expected = "BvhTriangle does not fill its texels")]
    fn a_texel_that_is_not_full_is_noticed() {
        let _ = StructInfo { size_bytes: 40, ..BvhTriangle::INFO }.glsl_from_texels();
    }
}
