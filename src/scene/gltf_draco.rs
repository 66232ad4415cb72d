//! Meshes compressed by Draco: `KHR_draco_mesh_compression`.
//!
//! What the extension has of a primitive becomes buffer views and accessors of their own when the file is read, and the
//! primitive names those. Whatever it names besides stays.

use std::collections::{BTreeMap, HashMap};

use ::gltf::json::Index;
use ::gltf::json::accessor::{Accessor, ComponentType, GenericComponentType, Type};
use ::gltf::json::mesh::{Mode, Primitive};
use ::gltf::json::validation::{Checked, USize64};
use draco_core::{DataType, DecodeLimits, DecoderBuffer, ErrorKind, Mesh, MeshDecoder, PointIndex};
use rayon::prelude::*;
use serde::Deserialize;

use super::gltf_buffers::Document;
use crate::files::guard::{could_hold, guarded};
use crate::{Error, Result};

const EXTENSION: &str = "KHR_draco_mesh_compression";

/// The most bytes that a vertex has of one attribute: four floats.
const MOST_ATTRIBUTE_BYTES: u64 = 16;

/// The object of the extension in a primitive.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Source {
    buffer_view: u32,
    /// Ids in the stream by the name of the attribute.
    attributes: BTreeMap<String, u32>,
}

/// A primitive with the extension: its mesh, its index in there and the object.
struct Compressed {
    mesh: usize,
    primitive: usize,
    source: Source,
}

impl Compressed {
    fn primitive<'a>(&self, document: &'a Document) -> &'a Primitive {
        &document.root.meshes[self.mesh].primitives[self.primitive]
    }

    fn broken(&self, document: &Document, why: impl std::fmt::Display) -> Error {
        let Self { mesh, primitive, .. } = self;
        document.error(format_args!("mesh {mesh}, primitive {primitive} cannot be decompressed by {EXTENSION}: {why}"))
    }

    /// What the stream may hold at most by the accessors of the primitive, and the bytes of that.
    fn announced(&self, document: &Document) -> Result<(DecodeLimits, u64)> {
        let (primitive, mut vertices) = (self.primitive(document), 0);
        for accessor in primitive.attributes.values() {
            vertices = document.accessor_count(*accessor)?.max(vertices);
        }
        let corners = primitive.indices.map_or(Ok(vertices), |indices| document.accessor_count(indices))?;
        let is_strip = primitive.mode != Checked::Valid(Mode::Triangles);
        let triangles = if is_strip { corners } else { corners.div_ceil(3) };
        // Where attributes jump a vertex is split, though never into more than its corners.
        let points = triangles.saturating_mul(3).max(vertices);
        // The stream may hold an attribute that the file does not name.
        let attributes = self.source.attributes.len() as u64 + 1;
        let values = points.saturating_mul(MOST_ATTRIBUTE_BYTES * attributes);
        let limits = DecodeLimits::default().with_max_points(points).with_max_faces(triangles);
        Ok((limits.with_max_decoded_bytes(values), values.saturating_add(triangles.saturating_mul(12))))
    }
}

/// Decodes all compressed primitives of triangles and has them name what was decoded.
pub(super) fn decompress(document: &mut Document) -> Result<()> {
    let compressed = compressed_primitives(document)?;
    let streams = decode_streams(document, &compressed)?;
    let mut made = HashMap::new();
    for primitive in &compressed {
        replace(document, primitive, &streams[&primitive.source.buffer_view], &mut made)?;
    }
    Ok(())
}

fn compressed_primitives(document: &Document) -> Result<Vec<Compressed>> {
    let mut compressed = Vec::new();
    for (m, mesh) in document.root.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let has_triangles = matches!(primitive.mode, Checked::Valid(Mode::Triangles | Mode::TriangleStrip));
            let others = primitive.extensions.as_ref().map(|e| &e.others).filter(|_| has_triangles);
            let what = format_args!("mesh {m}, primitive {p}");
            if let Some(source) = document.extension(&what, others, EXTENSION)? {
                compressed.push(Compressed { mesh: m, primitive: p, source });
            }
        }
    }
    Ok(compressed)
}

/// The meshes of all streams by their buffer view.
fn decode_streams(document: &Document, compressed: &[Compressed]) -> Result<HashMap<u32, Mesh>> {
    let first_of: BTreeMap<u32, &Compressed> = compressed.iter().rev().map(|c| (c.source.buffer_view, c)).collect();
    let file_bytes = document.buffer_bytes();
    let (mut jobs, mut total) = (Vec::with_capacity(first_of.len()), 0u64);
    for (view, first) in first_of {
        let what = format!("mesh {}, primitive {}", first.mesh, first.primitive);
        let (bytes, _) = document.view(&what, Index::new(view))?;
        let (limits, size) = first.announced(document)?;
        total = total.saturating_add(size);
        if !could_hold(file_bytes, total) {
            return Err(first.broken(document, "the file has too few bytes for what it announces"));
        }
        jobs.push((view, first, bytes, limits));
    }
    let decoded: Vec<_> = jobs.par_iter().map(|(.., bytes, limits)| guarded(|| decode(bytes, *limits))).collect();
    let named = jobs.into_iter().zip(decoded);
    named.map(|((view, first, ..), mesh)| Ok((view, mesh.map_err(|why| first.broken(document, why))?))).collect()
}

/// The mesh of a stream, or what is wrong with it.
fn decode(stream: &[u8], limits: DecodeLimits) -> std::result::Result<Mesh, String> {
    // Behind the name come the version in two bytes and what is encoded: 0 is a point cloud.
    match stream.strip_prefix(b"DRACO") {
        Some([1 | 2, _, 0, ..]) => return Err("its data are a point cloud".to_owned()),
        Some([1 | 2, ..]) => {}
        Some([major, minor, ..]) => return Err(format!("its data are of version {major}.{minor}; 1 and 2 are read")),
        _ => return Err("its data are not of Draco".to_owned()),
    }
    let mut mesh = Mesh::new();
    let outcome = MeshDecoder::new().decode(&mut DecoderBuffer::new(stream).with_limits(limits), &mut mesh);
    outcome.map_err(|error| match error.kind() {
        ErrorKind::LimitExceeded | ErrorKind::AllocationExceedsInput => {
            "its data hold more than its accessors announce".to_owned()
        }
        _ if error.message().is_empty() => "its data are damaged".to_owned(),
        _ => format!("its data are damaged ({})", error.message()),
    })?;
    Ok(mesh)
}

/// Accessors made so far, by the buffer view of the stream and, but for those of indices, by the id in the stream and by
/// the type of numbers, as OpenGL has it, and whether they are normalised.
type Made = HashMap<(u32, Option<(u32, u32, bool)>), Index<Accessor>>;

/// Has a primitive name what its stream holds.
fn replace(document: &mut Document, compressed: &Compressed, mesh: &Mesh, made: &mut Made) -> Result<()> {
    let Source { buffer_view, attributes: ids } = &compressed.source;
    let mut attributes = compressed.primitive(document).attributes.clone();
    for (semantic, accessor) in &mut attributes {
        let name = semantic.to_string();
        let Some(id) = ids.get(&name) else { continue };
        let replaced = document.accessor(*accessor)?;
        let broken = |why| compressed.broken(document, why);
        let component = number_type(mesh, *id, &name, replaced).map_err(broken)?;
        let key = (*buffer_view, Some((*id, component.as_gl_enum(), replaced.normalized)));
        let values = match made.get(&key) {
            Some(values) => *values,
            None => {
                let bytes = attribute_bytes(mesh, *id, component).map_err(broken)?;
                document.add_accessor(replaced.clone(), mesh.num_points(), bytes)
            }
        };
        made.insert(key, values);
        *accessor = values;
    }
    let indices = *made.entry((*buffer_view, None)).or_insert_with(|| {
        let corners = mesh.faces().iter().flatten();
        document.add_accessor(index_accessor(), 3 * mesh.num_faces(), corners.flat_map(|p| p.0.to_le_bytes()).collect())
    });
    let primitive = &mut document.root.meshes[compressed.mesh].primitives[compressed.primitive];
    primitive.attributes = attributes;
    primitive.indices = Some(indices);
    // A stream holds a list of triangles, whatever the primitive would be without it.
    primitive.mode = Checked::Valid(Mode::Triangles);
    Ok(())
}

/// The type of numbers of the accessor that an attribute replaces, if both have as many components.
fn number_type(mesh: &Mesh, id: u32, name: &str, accessor: &Accessor) -> std::result::Result<ComponentType, String> {
    let (Checked::Valid(component), Checked::Valid(kind)) = (&accessor.component_type, &accessor.type_) else {
        return Err(format!("the accessor of {name} has an unknown type"));
    };
    let Some(attribute) = mesh.attribute_by_unique_id(id) else {
        return Err(format!("its data have no attribute {id}, which is to be {name}"));
    };
    let width = usize::from(attribute.num_components());
    if width == kind.multiplicity() {
        Ok(component.0)
    } else {
        Err(format!("attribute {id} has {width} components, and {name} is {kind:?}"))
    }
}

/// The values of an attribute for all points as numbers of this type.
fn attribute_bytes(mesh: &Mesh, id: u32, component: ComponentType) -> std::result::Result<Vec<u8>, String> {
    let damaged = || format!("its data are damaged in attribute {id}");
    let attribute = mesh.attribute_by_unique_id(id).ok_or_else(damaged)?;
    let width = usize::from(attribute.num_components());
    let from = attribute.data_type();
    let size = number_bytes(from).ok_or_else(|| format!("attribute {id} has numbers of type {from:?}"))?;
    let (data, stride) = (attribute.buffer().data(), attribute.byte_stride() as usize);
    let mut bytes = Vec::with_capacity(mesh.num_points() * width * component.size());
    for point in 0..mesh.num_points() as u32 {
        let start = (attribute.mapped_index(PointIndex(point)).0 as usize).saturating_mul(stride);
        let element = data.get(start..start.saturating_add(width * size)).ok_or_else(damaged)?;
        element.chunks_exact(size).for_each(|number| push_number(component, number_of(from, number), &mut bytes));
    }
    Ok(bytes)
}

/// Bytes of a number of an attribute, of the types that become numbers of glTF.
fn number_bytes(data_type: DataType) -> Option<usize> {
    match data_type {
        DataType::Int8 | DataType::Uint8 => Some(1),
        DataType::Int16 | DataType::Uint16 => Some(2),
        DataType::Int32 | DataType::Uint32 | DataType::Float32 => Some(4),
        _ => None,
    }
}

/// A number of an attribute; 64 bits hold all of them exactly.
fn number_of(data_type: DataType, b: &[u8]) -> f64 {
    match data_type {
        DataType::Int8 => f64::from(b[0] as i8),
        DataType::Uint8 => f64::from(b[0]),
        DataType::Int16 => f64::from(i16::from_le_bytes([b[0], b[1]])),
        DataType::Uint16 => f64::from(u16::from_le_bytes([b[0], b[1]])),
        DataType::Int32 => f64::from(i32::from_le_bytes([b[0], b[1], b[2], b[3]])),
        DataType::Uint32 => f64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]])),
        _ => f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])),
    }
}

/// Appends a number in a type of glTF.
fn push_number(component: ComponentType, number: f64, bytes: &mut Vec<u8>) {
    match component {
        ComponentType::I8 => bytes.extend((number as i8).to_le_bytes()),
        ComponentType::U8 => bytes.push(number as u8),
        ComponentType::I16 => bytes.extend((number as i16).to_le_bytes()),
        ComponentType::U16 => bytes.extend((number as u16).to_le_bytes()),
        ComponentType::U32 => bytes.extend((number as u32).to_le_bytes()),
        ComponentType::F32 => bytes.extend((number as f32).to_le_bytes()),
    }
}

/// An accessor of indices, without any.
fn index_accessor() -> Accessor {
    Accessor {
        buffer_view: None,
        byte_offset: None,
        count: USize64(0),
        component_type: Checked::Valid(GenericComponentType(ComponentType::U32)),
        extensions: None,
        extras: Default::default(),
        type_: Checked::Valid(Type::Scalar),
        min: None,
        max: None,
        name: None,
        normalized: false,
        sparse: None,
    }
}
