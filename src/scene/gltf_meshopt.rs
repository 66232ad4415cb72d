//! Buffer views compressed by meshoptimizer: `EXT_meshopt_compression` and `KHR_meshopt_compression`.
//!
//! KHR is EXT with a second version of the vertex codec and one more filter; both are read under either name.

use std::collections::{HashMap, HashSet};

use ::gltf::json::{Root, buffer};
use meshoptimizer_rs::codec::{self, Mode};
use meshoptimizer_rs::{Error as Fault, Limits, Workspace};
use rayon::prelude::*;
use serde::Deserialize;

use super::gltf_buffers::Document;
use crate::Result;
use crate::files::guard::guarded;

/// The names of the extension, on views and on buffers that stand for uncompressed data.
const EXTENSIONS: [&str; 2] = ["KHR_meshopt_compression", "EXT_meshopt_compression"];

/// The most bytes that one compressed byte can stand for: version 1 of the vertex codec has at least a control byte for
/// every 4 bytes of an element in each block of at most 256 elements. The decoder holds each view to the least size of
/// its codec before it allocates anything; this holds views together that share their compressed bytes.
const MOST_PER_BYTE: u64 = 1024;

/// A buffer view with the extension.
pub(super) struct CompressedView {
    index: usize,
    extension: &'static str,
    source: Source,
}

/// The object of the extension in a buffer view.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Source {
    buffer: usize,
    #[serde(default)]
    byte_offset: u64,
    byte_length: u64,
    byte_stride: usize,
    count: usize,
    mode: String,
    filter: Option<String>,
}

/// What a filter does to so many decoded elements of such a stride, in place.
type Filter = fn(&mut [u8], usize, usize, &mut Workspace) -> std::result::Result<(), Fault>;

/// All buffer views with the extension, not looked into.
pub(super) fn compressed_views(document: &Document) -> Result<Vec<CompressedView>> {
    let mut views = Vec::new();
    for (index, view) in document.root.buffer_views.iter().enumerate() {
        let Some(others) = view.extensions.as_ref().map(|e| &e.others) else { continue };
        let Some(extension) = EXTENSIONS.into_iter().find(|name| others.contains_key(*name)) else { continue };
        if let Some(source) = document.extension(&format_args!("buffer view {index}"), Some(others), extension)? {
            views.push(CompressedView { index, extension, source });
        }
    }
    Ok(views)
}

/// The buffers that no one reads here: they are for programs without the extension, and may have no data at all.
pub(super) fn placeholders(root: &Root, compressed: &[CompressedView]) -> HashSet<usize> {
    let compressed_indices: HashSet<usize> = compressed.iter().map(|view| view.index).collect();
    let (mut unread, mut read) = (HashSet::new(), HashSet::new());
    for (i, view) in root.buffer_views.iter().enumerate() {
        let buffers = if compressed_indices.contains(&i) { &mut unread } else { &mut read };
        buffers.insert(view.buffer.value());
    }
    read.extend(compressed.iter().map(|view| view.source.buffer));
    let is_marked = |buffer: &buffer::Buffer| {
        let others = buffer.extensions.as_ref().map(|e| &e.others);
        others.is_some_and(|others| EXTENSIONS.iter().any(|name| others.contains_key(*name)))
    };
    unread.extend(root.buffers.iter().enumerate().filter(|(_, buffer)| is_marked(buffer)).map(|(i, _)| i));
    &unread - &read
}

/// What the compressed buffer views hold, by their index.
pub(super) fn decompress(document: &Document, compressed: &[CompressedView]) -> Result<HashMap<usize, Vec<u8>>> {
    let broken = |view: &CompressedView, why: String| {
        let CompressedView { index, extension, .. } = view;
        document.error(format_args!("buffer view {index} cannot be decompressed by {extension}: {why}"))
    };
    let most = document.buffer_bytes().saturating_mul(MOST_PER_BYTE);
    let (mut jobs, mut total) = (Vec::with_capacity(compressed.len()), 0u64);
    for view in compressed {
        let CompressedView { index, extension, source } = view;
        let what = format_args!("the {extension} of buffer view {index}");
        let bytes = document.range(&what, source.buffer, source.byte_offset, source.byte_length)?;
        let layout = source.layout(&document.root.buffer_views[*index]).map_err(|why| broken(view, why))?;
        total = total.saturating_add(layout.bytes() as u64);
        if total > most {
            return Err(broken(view, "the file has too few bytes for what it announces".to_owned()));
        }
        jobs.push((layout, bytes));
    }
    let decoded: Vec<_> = jobs.par_iter().map(|(layout, bytes)| guarded(|| layout.decode(bytes))).collect();
    let of_view = |(view, decoded): (&CompressedView, std::result::Result<_, String>)| {
        decoded.map(|bytes| (view.index, bytes)).map_err(|why| broken(view, why))
    };
    compressed.iter().zip(decoded).map(of_view).collect()
}

/// How the elements of a view are compressed: something that the extension allows.
struct Layout {
    mode: Mode,
    filter: Option<Filter>,
    count: usize,
    stride: usize,
}

impl Source {
    /// How `view` is compressed, or what is wrong with that.
    fn layout(&self, view: &buffer::View) -> std::result::Result<Layout, String> {
        let (count, stride) = (self.count, self.byte_stride);
        let mode = Mode::parse(&self.mode).map_err(|_| format!("the mode `{}` is unknown", self.mode))?;
        let is_fit = match mode {
            Mode::Attributes => (4..=256).contains(&stride) && stride % 4 == 0,
            Mode::Triangles | Mode::Indices => stride == 2 || stride == 4,
        };
        if !is_fit {
            return Err(format!("{} cannot have a stride of {stride} bytes", self.mode));
        }
        if mode == Mode::Triangles && count % 3 != 0 {
            return Err(format!("{count} indices are no whole triangles"));
        }
        let name = self.filter.as_deref().unwrap_or("NONE");
        let (filter, strides): (Option<Filter>, &[usize]) = match name {
            "NONE" => (None, &[]),
            "OCTAHEDRAL" => (Some(codec::decode_filter_oct), &[4, 8]),
            "QUATERNION" => (Some(codec::decode_filter_quat), &[8]),
            "EXPONENTIAL" => (Some(codec::decode_filter_exp), &[]),
            "COLOR" => (Some(codec::decode_filter_color), &[4, 8]),
            _ => return Err(format!("the filter `{name}` is unknown")),
        };
        if filter.is_some() && mode != Mode::Attributes {
            return Err(format!("the filter {name} is not for {}", self.mode));
        }
        if !strides.is_empty() && !strides.contains(&stride) {
            return Err(format!("the filter {name} is not for a stride of {stride} bytes"));
        }
        // A stride of indices is not said by the view.
        let of_view = view.byte_stride.map(|s| s.0).filter(|s| *s != 0 && mode == Mode::Attributes);
        if let Some(wanted) = of_view.filter(|wanted| *wanted != stride) {
            return Err(format!("it has a stride of {stride} bytes, and the view one of {wanted}"));
        }
        let wanted = view.byte_length.0;
        match count.checked_mul(stride) {
            Some(bytes) if bytes as u64 == wanted => Ok(Layout { mode, filter, count, stride }),
            _ => Err(format!("{count} elements of {stride} bytes are not the {wanted} bytes of the view")),
        }
    }
}

impl Layout {
    /// Bytes of all elements.
    fn bytes(&self) -> usize {
        self.count * self.stride
    }

    /// The elements, or what is wrong with their compressed bytes.
    fn decode(&self, source: &[u8]) -> std::result::Result<Vec<u8>, String> {
        let Self { mode, filter, count, stride } = *self;
        // The sizes of the source and of the result have been checked, and work is as much as they are.
        let mut workspace = Workspace::new(Limits { max_bytes: usize::MAX, max_work: u64::MAX });
        let decode = match mode {
            Mode::Attributes => codec::decode_vertex_buffer,
            Mode::Triangles => codec::decode_index_buffer,
            Mode::Indices => codec::decode_index_sequence,
        };
        let mut elements = decode(count, stride, source, &mut workspace).map_err(|fault| match fault {
            Fault::UnsupportedVersion => format!("its data are of version {}; 0 and 1 are read", source[0] & 15),
            Fault::InvalidStream => format!("its data are damaged, or not {count} elements of {stride} bytes"),
            other => other.to_string(),
        })?;
        if let Some(filter) = filter {
            let outcome = filter(&mut elements, count, stride, &mut workspace);
            outcome.map_err(|_| "its filter is undefined for some of its elements".to_owned())?;
        }
        Ok(elements)
    }
}
