//! Arrays of numbers and of records, as NumPy's `.npy` files hold them. Little-endian throughout.

use std::io::Write;
use std::path::Path;

use npyz::{DType, NpyHeader, Order, WriteOptions, WriterBuilder};
use serde_json::{Value, json};

use crate::files::read_whole;
use crate::shared::{FieldInfo, FieldKind, StructInfo};
use crate::{Error, Result};

/// A number in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Scalar {
    /// 16-bit float.
    F16,
    /// 32-bit float.
    F32,
    /// 16-bit signed integer.
    I16,
    /// 64-bit signed integer.
    I64,
    /// 32-bit unsigned integer.
    U32,
}

impl Scalar {
    const ALL: [Self; 5] = [Self::F16, Self::F32, Self::I16, Self::I64, Self::U32];

    /// NumPy's name of the type.
    #[must_use]
    pub fn type_string(self) -> &'static str {
        match self {
            Self::F16 => "<f2",
            Self::F32 => "<f4",
            Self::I16 => "<i2",
            Self::I64 => "<i8",
            Self::U32 => "<u4",
        }
    }

    /// Bytes of one number.
    #[must_use]
    pub fn bytes(self) -> usize {
        match self {
            Self::F16 | Self::I16 => 2,
            Self::F32 | Self::U32 => 4,
            Self::I64 => 8,
        }
    }

    fn parse(text: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|scalar| scalar.type_string() == text)
    }
}

/// One field of a record; an array of plain numbers has a single field without a name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Field {
    /// Name, or empty.
    pub name: String,
    /// Kind of number.
    pub scalar: Scalar,
    /// Shape of the field within a record; empty for one number.
    pub shape: Vec<u64>,
}

impl Field {
    /// A field of this shape.
    #[must_use]
    pub fn new(name: &str, scalar: Scalar, shape: &[u64]) -> Self {
        Self { name: name.to_owned(), scalar, shape: shape.to_vec() }
    }

    /// A field of a struct that shaders read, and where it begins.
    fn of_struct(info: &FieldInfo) -> (usize, Self) {
        let scalar = if info.kind == FieldKind::Float { Scalar::F32 } else { Scalar::U32 };
        let shape: Vec<u64> = info.shape.iter().map(|axis| *axis as u64).collect();
        (info.offset_bytes, Self::new(info.name, scalar, &shape))
    }

    /// Numbers of one record.
    #[must_use]
    pub fn count(&self) -> usize {
        self.shape.iter().fold(1_u64, |count, axis| count.saturating_mul(*axis)) as usize
    }

    /// Bytes of one record.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.count().saturating_mul(self.scalar.bytes())
    }
}

/// Numbers or records in C order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Array {
    /// What an element is made of.
    pub fields: Vec<Field>,
    /// Elements along each axis.
    pub shape: Vec<u64>,
    /// The elements, packed.
    pub bytes: Vec<u8>,
    /// Index in the resource of the first element here.
    pub first: u64,
}

impl Array {
    /// Plain numbers; as many of `bytes` as the shape needs.
    #[must_use]
    pub fn plain(scalar: Scalar, shape: &[u64], bytes: &[u8]) -> Self {
        Self::records(vec![Field::new("", scalar, &[])], shape, bytes)
    }

    /// Records; as many of `bytes` as the shape needs.
    #[must_use]
    pub fn records(fields: Vec<Field>, shape: &[u64], bytes: &[u8]) -> Self {
        let size: usize = fields.iter().map(Field::bytes).sum();
        let length = shape.iter().product::<u64>() as usize * size;
        Self { fields, shape: shape.to_vec(), bytes: bytes[..length.min(bytes.len())].to_vec(), first: 0 }
    }

    /// `count` structs that shaders read, as records of the fields that are wanted.
    #[must_use]
    pub fn structs(info: &StructInfo, is_wanted: impl Fn(&FieldInfo) -> bool, count: u64, bytes: &[u8]) -> Self {
        let wanted: Vec<(usize, Field)> = info.fields.iter().filter(|f| is_wanted(f)).map(Field::of_struct).collect();
        let structs = bytes.chunks_exact(info.size_bytes).take(count as usize);
        let parts = structs.flat_map(|s| wanted.iter().map(|(offset, field)| &s[*offset..*offset + field.bytes()]));
        let packed: Vec<u8> = parts.flatten().copied().collect();
        Self::records(wanted.into_iter().map(|(_, field)| field).collect(), &[count], &packed)
    }

    /// The same, of a part that starts at element `first` of its resource.
    #[must_use]
    pub fn starting_at(self, first: u64) -> Self {
        Self { first, ..self }
    }

    /// Bytes of one element.
    #[must_use]
    pub fn element_bytes(&self) -> usize {
        self.fields.iter().map(Field::bytes).sum()
    }

    /// The type as JSON: a type string, or for records a list of `[name, type string, shape]`.
    #[must_use]
    pub fn dtype_json(&self) -> Value {
        match self.fields.as_slice() {
            [field] if field.name.is_empty() => json!(field.scalar.type_string()),
            fields => fields.iter().map(|f| json!([f.name, f.scalar.type_string(), f.shape])).collect(),
        }
    }

    /// Writes a `.npy` file.
    ///
    /// # Errors
    /// [`Error::File`] when that fails.
    pub fn write(&self, path: &Path) -> Result<()> {
        let write = || -> std::io::Result<()> {
            let file = std::io::BufWriter::new(std::fs::File::create(path)?);
            let options = WriteOptions::new_header_only().dtype(dtype(&self.fields)).shape(&self.shape).writer(file);
            let mut file = options.write_header_only()?;
            file.write_all(&self.bytes)?;
            file.flush()
        };
        write().map_err(|error| Error::file(path, format!("cannot be written: {error}")))
    }

    /// Reads a `.npy` file of the kind that [`Array::write`] makes.
    ///
    /// # Errors
    /// [`Error::File`] when it cannot be read, is something else, or is cut short.
    pub fn read(path: &Path) -> Result<Self> {
        let whole =
            read_whole(path, || false).map_err(|error| Error::file(path, format!("cannot be read: {error}")))?;
        if !holds_its_header(&whole) {
            return Err(Error::file(path, "is not a .npy file: it ends within its header"));
        }
        let mut rest = whole.as_slice();
        let header = NpyHeader::from_reader(&mut rest)
            .map_err(|error| Error::file(path, format!("is not a .npy file: {error}")))?;
        let fields = fields(&header.dtype())
            .filter(|_| header.order() == Order::C)
            .ok_or_else(|| Error::file(path, format!("holds {}, which no dump has", header.dtype().descr())))?;
        let element = fields.iter().fold(0_u64, |sum, field| sum.saturating_add(field.bytes() as u64));
        let wanted = header.shape().iter().fold(element, |size, count| size.saturating_mul(*count));
        if element == 0 || rest.len() as u64 != wanted {
            let sentence = format!("is damaged: it holds {} bytes of numbers instead of {wanted}", rest.len());
            return Err(Error::file(path, sentence));
        }
        Ok(Self::records(fields, header.shape(), rest))
    }
}

/// Whether a file is as long as it says its header is, for which its reader takes memory before it looks. What is no `.npy` file
/// says nothing.
fn holds_its_header(file: &[u8]) -> bool {
    // The length is two bytes long in version 1, four in later ones; before it stand magic number and version.
    let length = match file {
        [0x93, b'N', b'U', b'M', b'P', b'Y', 1, _, a, b, ..] => 10 + usize::from(u16::from_le_bytes([*a, *b])),
        [0x93, b'N', b'U', b'M', b'P', b'Y', _, _, a, b, c, d, ..] => {
            12 + u32::from_le_bytes([*a, *b, *c, *d]) as usize
        }
        _ => return true,
    };
    length <= file.len()
}

fn dtype(fields: &[Field]) -> DType {
    let scalar = |field: &Field| {
        let plain = field.scalar.type_string().parse().map(DType::new_scalar).unwrap_or(DType::Record(Vec::new()));
        field.shape.iter().rev().fold(plain, |inner, count| DType::Array(*count, Box::new(inner)))
    };
    match fields {
        [field] if field.name.is_empty() => scalar(field),
        fields => {
            DType::Record(fields.iter().map(|f| npyz::Field { name: f.name.clone(), dtype: scalar(f) }).collect())
        }
    }
}

/// The fields of a type; `None` for one that [`dtype`] does not make.
fn fields(dtype: &DType) -> Option<Vec<Field>> {
    match dtype {
        DType::Record(fields) => fields.iter().map(|f| field(&f.name, &f.dtype)).collect(),
        plain => Some(vec![field("", plain)?]),
    }
}

fn field(name: &str, dtype: &DType) -> Option<Field> {
    let mut shape = Vec::new();
    let mut inner = dtype;
    while let DType::Array(count, next) = inner {
        shape.push(*count);
        inner = next;
    }
    match inner {
        DType::Plain(text) => Some(Field::new(name, Scalar::parse(&text.to_string())?, &shape)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_round_trip() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.npy");
        let fields = vec![Field::new("position_ws", Scalar::F32, &[3]), Field::new("levels", Scalar::U32, &[2, 1])];
        let bytes: Vec<u8> = (0..60).collect();
        for array in [
            Array::records(fields, &[3], &bytes),
            Array::plain(Scalar::I64, &[2, 3], &bytes),
            Array::plain(Scalar::U32, &[0], &[]),
        ] {
            array.write(&path).unwrap();
            assert_eq!(Array::read(&path).unwrap(), array);
        }
    }

    #[test]
    fn damage_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.npy");
        Array::plain(Scalar::U32, &[4], &[7; 16]).write(&path).unwrap();
        let whole = std::fs::read(&path).unwrap();
        std::fs::write(&path, &whole[..whole.len() - 3]).unwrap();
        assert!(Array::read(&path).unwrap_err().to_string().ends_with("it holds 13 bytes of numbers instead of 16"));
        // Fields whose sizes add up to more than there is: the sum must not come round to a size that fits.
        let half = format!("({},)", 1_u64 << 61);
        let head = format!(
            "{{'descr': [('a', '<f4', {half}), ('b', '<f4', {half}), ('c', '<f4')], \
                            'fortran_order': False, 'shape': (1,), }}\n"
        );
        let whole = [b"\x93NUMPY\x01\0", &(head.len() as u16).to_le_bytes()[..], head.as_bytes(), &[0; 4]].concat();
        std::fs::write(&path, whole).unwrap();
        let refused = Array::read(&path).unwrap_err().to_string();
        assert!(refused.contains("is not a .npy file"), "{refused}");
        // A header of a gigabyte, which is not there.
        std::fs::write(&path, b"\x93NUMPY\x03\0\0\0\0\x40{'descr': '<f4', ").unwrap();
        assert!(Array::read(&path).unwrap_err().to_string().ends_with("it ends within its header"));
        std::fs::write(&path, "no array").unwrap();
        assert!(Array::read(&path).unwrap_err().to_string().contains("is not a .npy file"));
        std::fs::remove_file(&path).unwrap();
        assert_eq!(Array::read(&path).unwrap_err().exit_code(), 1);
    }
}
