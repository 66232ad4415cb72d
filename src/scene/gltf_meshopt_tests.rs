//! Compressed buffer views against the same bytes uncompressed.

use std::path::Path;

use ::gltf::json::Index;
use meshoptimizer_rs::Workspace;
use meshoptimizer_rs::codec::{
    ExpMode, IndexEncoding, VertexEncoding, encode_filter_color, encode_filter_exp, encode_filter_oct,
    encode_filter_quat, encode_index_buffer, encode_index_sequence, encode_vertex_buffer,
};
use serde_json::{Value, json};

use super::tests::{Parts, QUAD, open};
use super::*;
use crate::scene::testing::Random;

const EXT: &str = "EXT_meshopt_compression";
const KHR: &str = "KHR_meshopt_compression";

/// A view that is there only compressed.
struct Packed {
    view: usize,
    stride: usize,
    mode: &'static str,
    filter: Option<&'static str>,
    data: Vec<u8>,
}

/// The bytes of a view.
fn view_bytes(parts: &Parts, view: usize) -> &[u8] {
    let [start, length] = ["byteOffset", "byteLength"].map(|key| parts.views[view][key].as_u64().unwrap() as usize);
    &parts.bin[start..start + length]
}

/// The bytes of a view as they are, packed in this mode.
fn pack(parts: &Parts, view: usize, mode: &'static str, stride: usize, version: u8) -> Packed {
    let (bytes, mut workspace) = (view_bytes(parts, view), Workspace::default());
    let indices = || -> Vec<u32> {
        let one = |bytes: &[u8]| bytes.iter().rev().fold(0, |sum, byte| sum << 8 | u32::from(*byte));
        bytes.chunks_exact(stride).map(one).collect()
    };
    let index_encoding = IndexEncoding::new(1).unwrap();
    let data = match mode {
        "TRIANGLES" => encode_index_buffer(&indices(), index_encoding, &mut workspace),
        "INDICES" => encode_index_sequence(&indices(), index_encoding, &mut workspace),
        _ => {
            let encoding = VertexEncoding::new(version, 2).unwrap();
            encode_vertex_buffer(bytes, bytes.len() / stride, stride, encoding, &mut workspace)
        }
    };
    Packed { view, stride, mode, filter: None, data: data.unwrap() }
}

/// Values that a filter encodes, packed.
fn pack_filtered(view: usize, filter: &'static str, stride: usize, version: u8, values: &[f32]) -> Packed {
    let mut workspace = Workspace::default();
    let width = if filter == "EXPONENTIAL" { stride / 4 } else { 4 };
    let count = values.len() / width;
    let encoded = match filter {
        "OCTAHEDRAL" => encode_filter_oct(count, stride, 2 * stride as u32, values, &mut workspace),
        "QUATERNION" => encode_filter_quat(count, stride, 16, values, &mut workspace),
        "COLOR" => encode_filter_color(count, stride, 2 * stride as u32, values, &mut workspace),
        _ => encode_filter_exp(count, stride, 23, values, ExpMode::Separate, &mut workspace),
    };
    let encoding = VertexEncoding::new(version, 2).unwrap();
    let data = encode_vertex_buffer(&encoded.unwrap(), count, stride, encoding, &mut workspace).unwrap();
    Packed { view, stride, mode: "ATTRIBUTES", filter: Some(filter), data }
}

/// The same parts with these views compressed in the binary chunk, and the chunk's other bytes behind them.
fn compressed(parts: &Parts, extension: &str, all: &[Packed]) -> Parts {
    let mut result = Parts { bin: Vec::new(), views: parts.views.clone(), accessors: parts.accessors.clone() };
    for (i, view) in result.views.iter_mut().enumerate() {
        let Some(packed) = all.iter().find(|packed| packed.view == i) else {
            let at = result.bin.len();
            result.bin.extend(view_bytes(parts, i));
            view["byteOffset"] = json!(at);
            continue;
        };
        let count = view["byteLength"].as_u64().unwrap() as usize / packed.stride;
        view["buffer"] = json!(1);
        view["extensions"] = json!({extension: {"buffer": 0, "byteOffset": result.bin.len(),
            "byteLength": packed.data.len(), "byteStride": packed.stride, "count": count, "mode": packed.mode}});
        if let Some(filter) = packed.filter {
            view["extensions"][extension]["filter"] = json!(filter);
        }
        result.bin.extend(&packed.data);
        result.bin.resize(result.bin.len().next_multiple_of(4), 0);
    }
    result
}

/// Top-level entries of a file whose second buffer has no data.
fn extra(parts: &Parts, extension: &str, more: &Value) -> Value {
    let fallback = json!({"byteLength": 1 << 20, "extensions": {extension: {"fallback": true}}});
    let mut extra = more.clone();
    extra["buffers"] = json!([{"byteLength": parts.bin.len()}, fallback]);
    extra["extensionsRequired"] = json!([extension]);
    extra
}

fn same(a: &Scene, b: &Scene) -> bool {
    let bytes = |scene: &Scene| bytemuck::cast_slice::<_, u8>(&scene.vertices).to_vec();
    bytes(a) == bytes(b) && a.indices == b.indices && a.draws == b.draws
}

#[test]
fn bytes_are_the_same_at_every_count_and_stride() {
    let mut random = Random(3);
    for (count, stride) in
        [1, 2, 3, 15, 16, 17, 255, 256, 257, 1000].into_iter().flat_map(|c| [4, 8, 12, 20, 256].map(|s| (c, s)))
    {
        let mut parts = Parts::default();
        let bytes: Vec<u8> =
            (0..count * stride).map(|i| (i / stride) as u8 ^ (random.next_unit() * 9.0) as u8).collect();
        parts.view(&bytes);
        for (extension, version) in [(EXT, 0), (KHR, 1)] {
            let packed = [pack(&parts, 0, "ATTRIBUTES", stride, version)];
            assert_eq!(packed[0].data[0], 0xa0 | version);
            let small = compressed(&parts, extension, &packed);
            let glb = small.glb(json!([]), extra(&small, extension, &json!({})));
            let document = Document::parse(Path::new("test.glb"), None, &glb, &|_, _, _| ()).unwrap();
            let (found, _) = document.view("a test", Index::new(0)).unwrap();
            assert!(found == bytes, "{count} elements of {stride} bytes by {extension}");
        }
    }
}

/// A fan of so many corners whose every view is compressed.
fn fan(corners: u16, index_bytes: usize) -> (Parts, Value) {
    let (mut parts, mut random) = (Parts::default(), Random(7));
    let positions: Vec<f32> = (0..corners).flat_map(|i| [f32::from(i), f32::from(i % 7), random.next_unit()]).collect();
    let position = parts.floats("VEC3", &positions);
    let uv = parts.floats("VEC2", &positions[..2 * usize::from(corners)]);
    let indices: Vec<u32> = (2..u32::from(corners)).flat_map(|i| [0, i - 1, i]).collect();
    let bytes: Vec<u8> = indices.iter().flat_map(|i| i.to_le_bytes()[..index_bytes].to_vec()).collect();
    let (view, component) = (parts.view(&bytes), if index_bytes == 2 { 5123 } else { 5125 });
    let index = parts
        .accessor(json!({"bufferView": view, "componentType": component, "count": indices.len(), "type": "SCALAR"}));
    (parts, json!([{"primitives": [{"attributes": {"POSITION": position, "TEXCOORD_0": uv}, "indices": index}]}]))
}

#[test]
fn meshes_are_the_same_in_every_mode() {
    for (corners, index_bytes, mode) in [3u16, 16, 17, 257, 1001].into_iter().flat_map(|corners| {
        [(corners, 2, "TRIANGLES"), (corners, 4, "TRIANGLES"), (corners, 2, "INDICES"), (corners, 4, "INDICES")]
    }) {
        let (parts, mesh) = fan(corners, index_bytes);
        let plain = open(&parts.glb(mesh.clone(), json!({}))).unwrap();
        assert!(plain.indices.len() >= 3 * usize::from(corners / 2));
        for (extension, version) in [(EXT, 0), (EXT, 1), (KHR, 0), (KHR, 1)] {
            let mut packed = [
                pack(&parts, 0, "ATTRIBUTES", 12, version),
                pack(&parts, 1, "ATTRIBUTES", 8, version),
                pack(&parts, 2, mode, index_bytes, version),
            ];
            let small = compressed(&parts, extension, &packed);
            let of = |small: &Parts| open(&small.glb(mesh.clone(), extra(small, extension, &json!({})))).unwrap();
            assert!(same(&plain, &of(&small)), "{corners} corners, {mode} of {index_bytes} bytes, {extension}");
            // A planted fault: one bit of a texture coordinate.
            let mut other = Parts { bin: parts.bin.clone(), views: parts.views.clone(), accessors: Vec::new() };
            other.bin[parts.views[1]["byteOffset"].as_u64().unwrap() as usize] ^= 1;
            packed[1] = pack(&other, 1, "ATTRIBUTES", 8, version);
            let small = compressed(&parts, extension, &packed);
            assert!(!same(&plain, &of(&small)));
        }
    }
}

#[test]
fn sparse_values_and_images_may_lie_among_compressed_views() {
    let mut parts = Parts::default();
    parts.floats("VEC3", &QUAD);
    let at = parts.view(&1u32.to_le_bytes());
    let values = parts.view(bytemuck::cast_slice(&[4f32, 0.0, 0.0]));
    parts.accessors[0]["sparse"] = json!({"count": 1, "indices": {"bufferView": at, "componentType": 5125},
        "values": {"bufferView": values}});
    let mut png = std::io::Cursor::new(Vec::new());
    image::RgbImage::new(2, 1).write_to(&mut png, image::ImageFormat::Png).unwrap();
    let image = parts.view(&png.into_inner());
    let more = json!({"images": [{"bufferView": image}], "textures": [{"source": 0}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]});
    let mesh = json!([{"primitives": [{"attributes": {"POSITION": 0}, "mode": 5, "material": 0}]}]);
    let plain = open(&parts.glb(mesh.clone(), more.clone())).unwrap();
    let packed = [
        pack(&parts, 0, "ATTRIBUTES", 12, 0),
        pack(&parts, at, "INDICES", 4, 0),
        pack(&parts, values, "ATTRIBUTES", 12, 0),
    ];
    let small = compressed(&parts, KHR, &packed);
    let scene = open(&small.glb(mesh, extra(&small, KHR, &more))).unwrap();
    assert!(same(&plain, &scene) && scene.bounds.max.x == 4.0);
    assert_eq!((scene.textures[0].width, scene.textures[0].height), (2, 1));
}

#[test]
fn filters_give_the_values_that_were_encoded() {
    let mut random = Random(11);
    let count = 257;
    let directions: Vec<Vec3> = (0..count).map(|_| random.vector().normalize_or(Vec3::Y)).collect();
    let units: Vec<f32> = directions.iter().flat_map(|d| [d.x, d.y, d.z, 1.0]).collect();
    let colors: Vec<f32> = directions.iter().flat_map(|d| (0.5 * *d + 0.5).extend(0.25).to_array()).collect();
    // Few digits, so that 23 bits have them all.
    let exact: Vec<f32> = directions.iter().flat_map(|d| (*d * 64.0).round().to_array()).map(|v| v * 0.125).collect();
    let turns: Vec<f32> =
        units.chunks_exact(4).flat_map(|q| glam::Vec4::from_slice(q).normalize().to_array()).collect();
    // The largest difference between `wanted` and what is read where `values` were encoded; a turn has two signs.
    let worst = |filter, stride: usize, (kind, component): (&str, u32), values: &[f32], wanted: &[f32]| {
        let mut parts = Parts::default();
        parts.view(&vec![0; count * stride]);
        parts.views[0]["byteStride"] = json!(stride);
        parts.accessor(json!({"bufferView": 0, "componentType": component, "normalized": component != 5126,
            "count": count, "type": kind}));
        let errors = [0, 1].map(|version| {
            let small = compressed(&parts, KHR, &[pack_filtered(0, filter, stride, version, values)]);
            let glb = small.glb(json!([]), extra(&small, KHR, &json!({})));
            let document = Document::parse(Path::new("test.glb"), None, &glb, &|_, _, _| ()).unwrap();
            let found: Vec<f32> = match kind {
                "VEC4" => document.read_floats::<4>("test", Index::new(0)).unwrap().into_flattened(),
                _ => document.read_floats::<3>("test", Index::new(0)).unwrap().into_flattened(),
            };
            let error = |(found, wanted): (&[f32], &[f32])| {
                let of = |sign: f32| found.iter().zip(wanted).map(|(a, b)| (a - sign * b).abs()).fold(0.0, f32::max);
                if filter == "QUATERNION" { of(1.0).min(of(-1.0)) } else { of(1.0) }
            };
            let given = wanted.len() / count;
            found.chunks_exact(found.len() / count).zip(wanted.chunks_exact(given)).map(error).fold(0.0, f32::max)
        });
        assert_eq!(errors[0], errors[1], "both versions hold the same bytes");
        errors[0]
    };
    let (signed, unsigned) = ([("VEC3", 5120), ("VEC3", 5122), ("VEC4", 5122)], [("VEC4", 5121), ("VEC4", 5123)]);
    // Half a step of two coordinates, which the length may stretch by the root of 3, and half a step of the result.
    let bytes = worst("OCTAHEDRAL", 4, signed[0], &units, &units);
    let shorts = worst("OCTAHEDRAL", 8, signed[1], &units, &units);
    assert!(bytes > 1e-3 && bytes < 2.3 / 127.0, "{bytes}");
    assert!(shorts > 1e-6 && shorts < 2.3 / 32767.0, "{shorts}");
    // Half a step of 14 bits in three parts of at most the root of a half; the fourth is the rest.
    let turn = worst("QUATERNION", 8, signed[2], &turns, &turns);
    assert!(turn > 1e-6 && turn < 2.5 / 32767.0, "{turn}");
    assert_eq!(worst("EXPONENTIAL", 12, ("VEC3", 5126), &exact, &exact), 0.0);
    // Half a step of luma and of two differences, and half a step of the result.
    let bytes = worst("COLOR", 4, unsigned[0], &colors, &colors);
    let shorts = worst("COLOR", 8, unsigned[1], &colors, &colors);
    assert!(bytes > 1e-3 && bytes < 2.5 / 255.0, "{bytes}");
    assert!(shorts > 1e-6 && shorts < 2.5 / 65535.0, "{shorts}");
    // A planted fault: other values than those that were encoded.
    let turned: Vec<f32> = units.chunks_exact(4).flat_map(|d| [d[1], d[2], d[0], d[3]]).collect();
    assert!(worst("OCTAHEDRAL", 4, signed[0], &turned, &units) > 0.5);
    assert!(worst("EXPONENTIAL", 12, ("VEC3", 5126), &exact[..3].repeat(count), &exact) > 0.5);
}

/// The message about a fan of 17 corners that `change` has spoiled.
fn message(change: impl FnOnce(&mut Parts, &mut Value)) -> String {
    let (parts, mesh) = fan(17, 2);
    let packed = [pack(&parts, 0, "ATTRIBUTES", 12, 1), pack(&parts, 2, "TRIANGLES", 2, 1)];
    let mut small = compressed(&parts, EXT, &packed);
    let mut more = extra(&small, EXT, &json!({}));
    change(&mut small, &mut more);
    let message = open(&small.glb(mesh, more)).map(drop).map_or_else(|e| e.to_string(), |()| "it is read".to_owned());
    assert!(!message.contains('\n'), "{message}");
    message
}

#[test]
fn faults_are_named() {
    assert_eq!(message(|_, _| ()), "it is read");
    let set = |view: usize, key: &'static str, value: Value| {
        message(move |parts, _| parts.views[view]["extensions"][EXT][key] = value)
    };
    let cannot = |view: u32, why: &str| {
        format!("test.glb: buffer view {view} cannot be decompressed by EXT_meshopt_compression: {why}")
    };
    assert_eq!(set(0, "mode", json!("STRIPS")), cannot(0, "the mode `STRIPS` is unknown"));
    assert_eq!(set(0, "filter", json!("ROUND")), cannot(0, "the filter `ROUND` is unknown"));
    assert_eq!(
        set(0, "filter", json!("QUATERNION")),
        cannot(0, "the filter QUATERNION is not for a stride of 12 bytes")
    );
    assert_eq!(set(2, "filter", json!("EXPONENTIAL")), cannot(2, "the filter EXPONENTIAL is not for TRIANGLES"));
    assert_eq!(set(0, "byteStride", json!(260)), cannot(0, "ATTRIBUTES cannot have a stride of 260 bytes"));
    assert_eq!(set(2, "byteStride", json!(3)), cannot(2, "TRIANGLES cannot have a stride of 3 bytes"));
    assert_eq!(set(2, "count", json!(44)), cannot(2, "44 indices are no whole triangles"));
    assert_eq!(set(0, "count", json!(16)), cannot(0, "16 elements of 12 bytes are not the 204 bytes of the view"));
    assert_eq!(set(0, "count", json!(18)), cannot(0, "18 elements of 12 bytes are not the 204 bytes of the view"));
    assert_eq!(set(0, "byteStride", json!(16)), cannot(0, "17 elements of 16 bytes are not the 204 bytes of the view"));
    // The same where the view agrees.
    let announce = |view: usize, count: u32, stride: u32| {
        message(move |parts, _| {
            parts.views[view]["byteLength"] = json!(count * stride);
            parts.views[view]["extensions"][EXT]["count"] = json!(count);
            parts.views[view]["extensions"][EXT]["byteStride"] = json!(stride);
        })
    };
    assert_eq!(announce(0, 40, 12), cannot(0, "its data are damaged, or not 40 elements of 12 bytes"));
    assert_eq!(announce(0, 17, 16), cannot(0, "its data are damaged, or not 17 elements of 16 bytes"));
    assert_eq!(announce(2, 48, 2), cannot(2, "its data are damaged, or not 48 elements of 2 bytes"));
    assert_eq!(announce(0, 10_000, 12), cannot(0, "its data are damaged, or not 10000 elements of 12 bytes"));
    assert_eq!(set(0, "byteLength", json!(40)), cannot(0, "its data are damaged, or not 17 elements of 12 bytes"));
    let beyond =
        "test.glb: the EXT_meshopt_compression of buffer view 0 (4000 bytes from byte 0) reaches beyond its buffer of";
    assert!(set(0, "byteLength", json!(4000)).starts_with(beyond));
    let buffer = "test.glb: the EXT_meshopt_compression of buffer view 0 refers to buffer 9, which does not exist";
    assert_eq!(set(0, "buffer", json!(9)), buffer);
    let broken = "test.glb: buffer view 0 has a broken EXT_meshopt_compression: ";
    assert!(set(0, "count", json!("many")).starts_with(broken));
    let stride = message(|parts, _| parts.views[0]["byteStride"] = json!(16));
    assert_eq!(stride, cannot(0, "it has a stride of 12 bytes, and the view one of 16"));
    let version = message(|parts, _| parts.bin[0] = 0xa2);
    assert_eq!(version, cannot(0, "its data are of version 2; 0 and 1 are read"));
    let kind = message(|parts, _| parts.bin[0] = 0xe1);
    assert_eq!(kind, cannot(0, "its data are damaged, or not 17 elements of 12 bytes"));
}

/// What a few bytes cannot hold is not made room for, whether one view announces it or many of the same bytes do.
#[test]
fn sizes_are_believed_as_far_as_the_bytes_go() {
    let one = message(|parts, _| {
        parts.views[0]["byteLength"] = json!(12u64 << 31);
        parts.views[0]["extensions"][EXT]["count"] = json!(1u64 << 31);
    });
    assert!(one.ends_with("the file has too few bytes for what it announces"), "{one}");
    let many = message(|parts, _| {
        let view = parts.views[0].clone();
        parts.views.extend(std::iter::repeat_n(view, 100_000));
    });
    assert!(many.ends_with("the file has too few bytes for what it announces"), "{many}");
}

#[test]
fn buffers_without_data_need_no_mark_and_no_file() {
    let unmarked = message(|_, more| more["buffers"][1] = json!({"byteLength": 999}));
    assert_eq!(unmarked, "it is read");
    let elsewhere = message(|_, more| more["buffers"][1] = json!({"byteLength": 999, "uri": "not-there.bin"}));
    assert_eq!(elsewhere, "it is read");
    let needed = message(|parts, _| parts.views[1]["buffer"] = json!(1));
    assert_eq!(needed, "test.glb: buffer 1 has no uri and the file no chunk for it");
}

#[test]
fn cut_and_changed_data_never_panic() {
    let (parts, mesh) = fan(300, 4);
    let packed =
        [pack(&parts, 0, "ATTRIBUTES", 12, 1), pack(&parts, 1, "ATTRIBUTES", 8, 0), pack(&parts, 2, "TRIANGLES", 4, 1)];
    let small = compressed(&parts, KHR, &packed);
    let lengths: Vec<usize> = packed.iter().map(|packed| packed.data.len()).collect();
    let mut random = Random(5);
    let mut refused = 0;
    for round in 0..1500 {
        let mut changed =
            Parts { bin: small.bin.clone(), views: small.views.clone(), accessors: small.accessors.clone() };
        let view = round % 3;
        if round < 300 {
            let length = (random.next_unit() * lengths[view] as f32) as usize;
            changed.views[view]["extensions"][KHR]["byteLength"] = json!(length.min(lengths[view] - 1));
        } else {
            let at = (random.next_unit() * changed.bin.len() as f32) as usize;
            changed.bin[at] ^= 1 + (random.next_unit() * 254.0) as u8;
        }
        let outcome = open(&changed.glb(mesh.clone(), extra(&changed, KHR, &json!({}))));
        assert!(outcome.is_err() || round >= 300, "cut data were read");
        let said = outcome.err().map(|error| error.to_string()).unwrap_or_default();
        assert!(!said.contains("does not expect"), "the decoder panicked: round {round}");
        refused += usize::from(!said.is_empty());
    }
    assert!(refused > 400, "{refused}: changes no longer reach the decoder");
}
