//! glTF accessors as plain vectors: every range, type and stride is checked before a byte is read.

use std::borrow::Cow;

use ::gltf::json::accessor::{Accessor, ComponentType, Type};
use ::gltf::json::validation::Checked;
use ::gltf::json::{Index, accessor::sparse::Sparse};

use super::gltf_buffers::Document;
use crate::Result;

/// The most elements an accessor without bytes of its own (all zeros, perhaps sparse) may announce, unless there are as
/// many bytes in the file's buffers: where that many vertices are zero, others are not.
const MAX_IMPLICIT_COUNT: u64 = 1 << 16;

/// The most numbers that animations, skins and morph targets may have together, read anew wherever one is named.
const MAX_MOVING_NUMBERS: u64 = 1 << 28;

/// One accessor, packed.
struct Packed<'a> {
    component: ComponentType,
    normalized: bool,
    bytes: Cow<'a, [u8]>,
}

impl Document<'_> {
    /// The accessor's announced number of elements.
    pub fn accessor_count(&self, index: Index<Accessor>) -> Result<u64> {
        Ok(self.accessor(index)?.count.0)
    }

    /// An accessor of `N` components as floats, normalised integers decoded.
    pub fn read_floats<const N: usize>(&self, what: &str, index: Index<Accessor>) -> Result<Vec<[f32; N]>> {
        let wanted = match N {
            1 => Type::Scalar,
            2 => Type::Vec2,
            3 => Type::Vec3,
            4 => Type::Vec4,
            _ => Type::Mat4,
        };
        debug_assert_eq!(wanted.multiplicity(), N);
        let packed = self.read(what, index, wanted)?;
        let (component, size) = (packed.component, packed.component.size());
        let largest = largest(component);
        let normalized = packed.normalized && component != ComponentType::F32;
        let value = |bytes: &[u8]| {
            let value = component_as_f32(component, bytes);
            if normalized { (value / largest).max(-1.0) } else { value }
        };
        let element = |bytes: &[u8]| std::array::from_fn(|c| value(&bytes[c * size..(c + 1) * size]));
        Ok(packed.bytes.chunks_exact(N * size).map(element).collect())
    }

    /// [`Self::read_floats`] for what moves: many animations may name the same numbers, so their sum has a bound.
    pub fn read_moving<const N: usize>(&self, what: &str, index: Index<Accessor>) -> Result<Vec<[f32; N]>> {
        let numbers = self.accessor_count(index)?.saturating_mul(N as u64);
        self.moving_numbers.set(self.moving_numbers.get().saturating_add(numbers));
        if self.moving_numbers.get() > MAX_MOVING_NUMBERS {
            let reason = "the scene's animations, skins and morph targets have more than";
            return Err(self.error(format_args!("{reason} {MAX_MOVING_NUMBERS} numbers")));
        }
        self.read_floats(what, index)
    }

    /// An accessor of four joints per vertex.
    pub fn read_joints(&self, what: &str, index: Index<Accessor>) -> Result<Vec<[u32; 4]>> {
        let packed = self.read(what, index, Type::Vec4)?;
        let i = index.value();
        match packed.component {
            ComponentType::U8 | ComponentType::U16 => {}
            other => return Err(self.error(format_args!("{what} (accessor {i}) has joints of type {other:?}"))),
        }
        let joints = unsigned(packed.component, &packed.bytes);
        Ok(joints.chunks_exact(4).map(|four| [four[0], four[1], four[2], four[3]]).collect())
    }

    /// Colours of vertices, RGB or RGBA, as parts of 65535. Integers are normalised, whether or not the accessor says so.
    pub fn read_colors(&self, what: &str, index: Index<Accessor>) -> Result<Vec<[u16; 4]>> {
        let with_alpha = matches!(self.accessor(index)?.type_, Checked::Valid(Type::Vec4));
        let packed = self.read(what, index, if with_alpha { Type::Vec4 } else { Type::Vec3 })?;
        let (component, size) = (packed.component, packed.component.size());
        let value = |bytes: &[u8]| {
            let value = component_as_f32(component, bytes) / largest(component);
            (value.clamp(0.0, 1.0) * 65535.0).round()
        };
        let channels = if with_alpha { 4 } else { 3 };
        let color = |bytes: &[u8]| {
            std::array::from_fn(|c| match bytes.get(c * size..(c + 1) * size) {
                Some(bytes) => value(bytes) as u16,
                None => u16::MAX,
            })
        };
        Ok(packed.bytes.chunks_exact(channels * size).map(color).collect())
    }

    /// An accessor of unsigned scalars.
    pub fn read_indices(&self, what: &str, index: Index<Accessor>) -> Result<Vec<u32>> {
        let packed = self.read(what, index, Type::Scalar)?;
        let i = index.value();
        match packed.component {
            ComponentType::U8 | ComponentType::U16 | ComponentType::U32 => {}
            other => return Err(self.error(format_args!("{what} (accessor {i}) has indices of type {other:?}"))),
        }
        Ok(unsigned(packed.component, &packed.bytes))
    }

    /// The largest index of an accessor's type, at which OpenGL and Vulkan begin another strip or fan.
    pub fn restart_index(&self, index: Index<Accessor>) -> Option<u32> {
        match self.root.accessors.get(index.value())?.component_type {
            Checked::Valid(component) => match component.0 {
                ComponentType::U8 => Some(u8::MAX.into()),
                ComponentType::U16 => Some(u16::MAX.into()),
                ComponentType::U32 => Some(u32::MAX),
                _ => None,
            },
            Checked::Invalid => None,
        }
    }

    /// The accessor with this index.
    pub fn accessor(&self, index: Index<Accessor>) -> Result<&Accessor> {
        let i = index.value();
        self.root.accessors.get(i).ok_or_else(|| self.error(format_args!("accessor {i} does not exist")))
    }

    fn read(&self, what: &str, index: Index<Accessor>, wanted: Type) -> Result<Packed<'_>> {
        let accessor = self.accessor(index)?;
        let what = format!("accessor {} ({what})", index.value());
        let (Checked::Valid(component), Checked::Valid(kind)) = (&accessor.component_type, &accessor.type_) else {
            return Err(self.error(format_args!("{what} has an unknown type")));
        };
        if *kind != wanted {
            return Err(self.error(format_args!("{what} has elements of type {kind:?}, not {wanted:?}")));
        }
        let size = component.0.size() * kind.multiplicity();
        let count = accessor.count.0;
        let mut bytes = if let Some(view) = accessor.buffer_view {
            let (view, stride) = self.view(&what, view)?;
            self.elements(&what, view, accessor.byte_offset.unwrap_or_default().0, count, size, stride)?
        } else if count <= MAX_IMPLICIT_COUNT.max(self.buffer_bytes()) {
            Cow::Owned(vec![0; count as usize * size])
        } else {
            return Err(self.error(format_args!("{what} announces {count} elements without a buffer view")));
        };
        if let Some(sparse) = &accessor.sparse {
            self.apply_sparse(&what, sparse, bytes.to_mut(), size)?;
        }
        Ok(Packed { component: component.0, normalized: accessor.normalized, bytes })
    }

    /// `count` elements of `size` bytes from `offset` on, `stride` apart, packed.
    fn elements<'b>(
        &self,
        what: &str,
        view: &'b [u8],
        offset: u64,
        count: u64,
        size: usize,
        stride: Option<usize>,
    ) -> Result<Cow<'b, [u8]>> {
        let stride = stride.unwrap_or(size);
        if stride < size {
            return Err(self.error(format_args!("{what} has a stride of {stride} bytes for elements of {size}")));
        }
        if count == 0 {
            return Ok(Cow::Borrowed(&[]));
        }
        let end = (count - 1).checked_mul(stride as u64).and_then(|n| n.checked_add(size as u64)?.checked_add(offset));
        let Some(bytes) = end.filter(|end| *end <= view.len() as u64).map(|end| &view[offset as usize..end as usize])
        else {
            let have = view.len();
            return Err(
                self.error(format_args!("{what} with {count} elements reaches beyond its buffer view of {have} bytes"))
            );
        };
        if stride == size {
            return Ok(Cow::Borrowed(bytes));
        }
        Ok(Cow::Owned(bytes.chunks(stride).flat_map(|element| &element[..size]).copied().collect()))
    }

    fn apply_sparse(&self, what: &str, sparse: &Sparse, target: &mut [u8], size: usize) -> Result<()> {
        let count = sparse.count.0;
        let Checked::Valid(component) = &sparse.indices.component_type else {
            return Err(self.error(format_args!("{what} has sparse indices of an unknown type")));
        };
        let (view, _) = self.view(what, sparse.indices.buffer_view)?;
        let indices = self.elements(what, view, sparse.indices.byte_offset.0, count, component.0.size(), None)?;
        let (view, _) = self.view(what, sparse.values.buffer_view)?;
        let values = self.elements(what, view, sparse.values.byte_offset.0, count, size, None)?;
        for (at, value) in unsigned(component.0, &indices).into_iter().zip(values.chunks_exact(size)) {
            match target.chunks_exact_mut(size).nth(at as usize) {
                Some(slot) => slot.copy_from_slice(value),
                None => return Err(self.error(format_args!("{what} has the sparse index {at} beyond its end"))),
            }
        }
        Ok(())
    }
}

/// Unsigned components widened to 32 bits.
fn unsigned(component: ComponentType, bytes: &[u8]) -> Vec<u32> {
    match component {
        ComponentType::U8 => bytes.iter().map(|b| u32::from(*b)).collect(),
        ComponentType::U16 => bytes.chunks_exact(2).map(|b| u32::from(u16::from_le_bytes([b[0], b[1]]))).collect(),
        _ => bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect(),
    }
}

fn component_as_f32(component: ComponentType, b: &[u8]) -> f32 {
    match component {
        ComponentType::I8 => f32::from(b[0] as i8),
        ComponentType::U8 => f32::from(b[0]),
        ComponentType::I16 => f32::from(i16::from_le_bytes([b[0], b[1]])),
        ComponentType::U16 => f32::from(u16::from_le_bytes([b[0], b[1]])),
        ComponentType::U32 => u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as f32,
        ComponentType::F32 => f32::from_le_bytes([b[0], b[1], b[2], b[3]]),
    }
}

/// The integer that means 1 in a normalised accessor.
fn largest(component: ComponentType) -> f32 {
    match component {
        ComponentType::I8 => 127.0,
        ComponentType::U8 => 255.0,
        ComponentType::I16 => 32767.0,
        ComponentType::U16 => 65535.0,
        ComponentType::U32 => u32::MAX as f32,
        ComponentType::F32 => 1.0,
    }
}
