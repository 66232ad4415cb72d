//! Files that are right, small, and between them have everything that is read. Inputs are changes of these.

use std::io::{Cursor, Write};
use std::path::Path;

use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes, LineOrder,
    SmallVec, Vec2, WritableImage, f16,
};
use gridlight::dump::{Array, Field, Scalar};
use gridlight::report::dump::images::Picture;
use gridlight::report::dump::manifest::{FILE_NAME, FileEntry, Manifest};
use gridlight::scene::testing::{Ktx2, glb_from};
use gridlight::settings::Settings;
use image::{DynamicImage, ImageFormat, RgbaImage};
use meshoptimizer_rs::{Workspace, codec};
use serde_json::{Value, json};

/// A name, of which the extension counts, and the file's bytes.
pub type Seed = (String, Vec<u8>);

fn seed(name: &str, bytes: impl Into<Vec<u8>>) -> Seed {
    (name.to_owned(), bytes.into())
}

/// Binary data of a glTF, with its views and accessors.
#[derive(Default)]
struct Data {
    bin: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Data {
    fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        self.views.push(json!({"buffer": 0, "byteOffset": self.bin.len(), "byteLength": bytes.len()}));
        self.bin.extend(bytes);
        self.views.len() - 1
    }

    fn add(&mut self, component: u32, kind: &str, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        self.accessors.push(json!({"bufferView": view, "componentType": component, "count": count, "type": kind}));
        self.accessors.len() - 1
    }

    fn floats(&mut self, kind: &str, width: usize, values: &[f32]) -> usize {
        self.add(5126, kind, values.len() / width, bytemuck::cast_slice(values))
    }

    fn glb(&self, rest: Value) -> Vec<u8> {
        let mut root = json!({
            "asset": {"version": "2.0"}, "scene": 0, "accessors": self.accessors, "bufferViews": self.views,
            "buffers": [{"byteLength": self.bin.len()}],
        });
        if let (Value::Object(root), Value::Object(rest)) = (&mut root, rest) {
            root.extend(rest);
        }
        glb_from(&root.to_string(), &self.bin)
    }
}

const CORNERS: [f32; 12] = [0., 0., 0., 1., 0., 0., 0., 1., 0., 1., 1., 0.];

/// A scene that stands still: lights, cameras, textures, instances, strips, extensions.
fn still() -> Vec<u8> {
    let mut data = Data::default();
    let position = data.floats("VEC3", 3, &CORNERS);
    let normal = data.floats("VEC3", 3, &[0., 0., 1.].repeat(4));
    let uv = data.floats("VEC2", 2, &[0., 0., 1., 0., 0., 1., 1., 1.]);
    let color = data.add(5121, "VEC4", 4, &[200; 16]);
    let short = data.add(5123, "SCALAR", 6, bytemuck::cast_slice(&[0u16, 1, 2, 1, 3, 2]));
    let byte = data.add(5121, "SCALAR", 4, &[0, 1, 2, 3]);
    let places = data.floats("VEC3", 3, &[0., 0., 1., 0., 0., 2.]);
    let turns = data.floats("VEC4", 4, &[0., 0., 0., 1., 0., 1., 0., 0.]);
    let at = data.view(&[1, 0, 0, 0]);
    let values = data.view(&[0; 12]);
    data.accessors.push(json!({"componentType": 5126, "count": 4, "type": "VEC3", "bufferView": 0, "sparse": {
        "count": 1, "indices": {"bufferView": at, "componentType": 5125}, "values": {"bufferView": values}}}));
    let sparse = data.accessors.len() - 1;
    let image = data.view(&picture_file(ImageFormat::Png, 4));
    let attributes = json!({"POSITION": position, "NORMAL": normal, "TEXCOORD_0": uv, "COLOR_0": color});
    data.glb(json!({
        "extensionsUsed": ["KHR_lights_punctual", "KHR_texture_transform"],
        "scenes": [{"nodes": [0, 1, 4]}],
        "nodes": [
            {"mesh": 0, "scale": [1, 2, 3], "name": "a"},
            {"children": [2, 3], "camera": 0, "rotation": [0, 0, 0, 1], "translation": [0, 0, 5]},
            {"extensions": {"KHR_lights_punctual": {"light": 0}}},
            {"mesh": 1, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1],
                "extensions": {"KHR_node_visibility": {"visible": true}}},
            {"mesh": 1, "extensions": {"EXT_mesh_gpu_instancing": {"attributes":
                {"TRANSLATION": places, "ROTATION": turns}}}}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1, "aspectRatio": 1.5}}],
        "extensions": {"KHR_lights_punctual": {"lights": [
            {"type": "spot", "intensity": 3, "color": [1, 1, 0.5], "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.5}}]}},
        "meshes": [
            {"primitives": [{"attributes": attributes, "indices": short, "material": 0}]},
            {"primitives": [{"attributes": {"POSITION": sparse}, "indices": byte, "mode": 5, "material": 1},
                {"attributes": {"POSITION": position}, "mode": 6}]}],
        "materials": [
            {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "extensions":
                {"KHR_texture_transform": {"offset": [0.5, 0], "rotation": 0.1, "scale": [2, 2], "texCoord": 0}}}},
                "normalTexture": {"index": 0, "scale": 0.5}, "alphaMode": "MASK", "alphaCutoff": 0.4, "doubleSided": true},
            {"pbrMetallicRoughness": {"baseColorFactor": [1, 0.5, 0.2, 1]}, "emissiveFactor": [0, 0, 1],
                "extensions": {"KHR_materials_pbrSpecularGlossiness": {"diffuseFactor": [1, 1, 1, 1]}}}],
        "textures": [{"source": 0, "sampler": 0}],
        "samplers": [{"magFilter": 9728, "minFilter": 9987, "wrapS": 33071, "wrapT": 10497}],
        "images": [{"bufferView": image, "mimeType": "image/png"}],
    }))
}

/// A scene that moves: animations of all kinds, a skin, morph targets, normal maps with tangents of the file and without.
fn moving() -> Vec<u8> {
    let mut data = Data::default();
    let position = data.floats("VEC3", 3, &CORNERS);
    let index = data.add(5125, "SCALAR", 6, bytemuck::cast_slice(&[0u32, 1, 2, 1, 3, 2]));
    let joints = data.add(5121, "VEC4", 4, &[0, 1, 0, 0].repeat(4));
    let weights = data.floats("VEC4", 4, &[0.5, 0.5, 0., 0.].repeat(4));
    let bind = data.floats("MAT4", 16, &glam::Mat4::IDENTITY.to_cols_array().repeat(2));
    let times = data.floats("SCALAR", 1, &[0., 1.]);
    let moves = data.floats("VEC3", 3, &[0., 0., 0., 1., 0., 0.]);
    let turns = data.floats("VEC4", 4, &[0., 0., 0., 1., 0., 1., 0., 0.]);
    let spline = data.floats("VEC3", 3, &[0.5; 18]);
    let morphs = data.floats("SCALAR", 1, &[0., 1.]);
    let normal = data.floats("VEC3", 3, &[0., 0., 1.].repeat(4));
    // Of the two triangles, the second has the texture mirrored.
    let uv = data.floats("VEC2", 2, &[0., 0., 1., 0., 0., 1., 0., 1.]);
    let tangent = data.floats("VEC4", 4, &[1., 0., 0., -1.].repeat(4));
    let image = data.view(&picture_file(ImageFormat::Png, 4));
    let bent =
        json!({"POSITION": position, "NORMAL": normal, "TEXCOORD_0": uv, "JOINTS_0": joints, "WEIGHTS_0": weights});
    let morphed = json!({"POSITION": position, "NORMAL": normal, "TEXCOORD_0": uv, "TANGENT": tangent});
    let target = json!({"POSITION": position, "NORMAL": position, "TANGENT": position});
    let channel =
        |sampler: u32, node: u32, path: &str| json!({"sampler": sampler, "target": {"node": node, "path": path}});
    data.glb(json!({
        "scenes": [{"nodes": [0, 1, 3]}],
        "nodes": [{"mesh": 0, "skin": 0}, {"children": [2]}, {"translation": [1, 0, 0]}, {"mesh": 1, "weights": [0.5]}],
        "skins": [{"joints": [1, 2], "inverseBindMatrices": bind, "skeleton": 1}],
        "meshes": [
            {"primitives": [{"attributes": bent, "indices": index, "material": 0}]},
            {"primitives": [{"attributes": morphed, "targets": [target], "material": 0}, {"attributes": bent, "targets": [target],
                "material": 0}], "weights": [0]}],
        "materials": [{"normalTexture": {"index": 0, "scale": 0.5}}], "textures": [{"source": 0}],
        "images": [{"bufferView": image, "mimeType": "image/png"}],
        "animations": [{"name": "all",
            "channels": [channel(0, 1, "translation"), channel(1, 2, "rotation"), channel(2, 2, "scale"), channel(3, 3, "weights")],
            "samplers": [{"input": times, "output": moves}, {"input": times, "output": turns, "interpolation": "STEP"},
                {"input": times, "output": spline, "interpolation": "CUBICSPLINE"}, {"input": times, "output": morphs}]}],
    }))
}

/// The same as text, with its data in a URI.
fn embedded() -> Vec<u8> {
    use base64::Engine as _;
    let bytes = base64::engine::general_purpose::STANDARD.encode(bytemuck::cast_slice::<f32, u8>(&CORNERS));
    json!({
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "buffers": [{"byteLength": 48, "uri": format!("data:application/octet-stream;base64,{bytes}")}],
        "bufferViews": [{"buffer": 0, "byteLength": 48, "byteStride": 12}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
    })
    .to_string()
    .into_bytes()
}

/// A quad whose views are compressed by meshoptimizer in every mode, with a filter.
fn meshopt() -> Vec<u8> {
    let (mut data, mut workspace) = (Data::default(), Workspace::default());
    let add = |data: &mut Data, mode: &str, filter: &str, count: usize, stride: usize, packed: &[u8]| {
        let view = data.view(packed);
        let source = json!({"buffer": 0, "byteOffset": data.views[view]["byteOffset"], "byteLength": packed.len(),
            "byteStride": stride, "count": count, "mode": mode, "filter": filter});
        data.views[view] = json!({"buffer": 1, "byteLength": count * stride,
            "extensions": {"KHR_meshopt_compression": source}});
    };
    let encoding = codec::VertexEncoding::DEFAULT;
    let positions = bytemuck::cast_slice(&CORNERS);
    let packed = codec::encode_vertex_buffer(positions, 4, 12, encoding, &mut workspace).unwrap();
    add(&mut data, "ATTRIBUTES", "NONE", 4, 12, &packed);
    let normals = codec::encode_filter_oct(4, 8, 16, &[0., 0., 1., 1.].repeat(4), &mut workspace).unwrap();
    let packed = codec::encode_vertex_buffer(&normals, 4, 8, encoding, &mut workspace).unwrap();
    add(&mut data, "ATTRIBUTES", "OCTAHEDRAL", 4, 8, &packed);
    data.views[1]["byteStride"] = json!(8);
    let indices = [0, 1, 2, 1, 3, 2];
    let packed = codec::encode_index_buffer(&indices, codec::IndexEncoding::DEFAULT, &mut workspace).unwrap();
    add(&mut data, "TRIANGLES", "NONE", 6, 4, &packed);
    let packed = codec::encode_index_sequence(&indices, codec::IndexEncoding::DEFAULT, &mut workspace).unwrap();
    add(&mut data, "INDICES", "NONE", 6, 2, &packed);
    let accessor = |view: u32, component: u32, kind: &str, count: u32| json!({"bufferView": view, "componentType": component, "count": count, "type": kind, "normalized": view == 1});
    data.accessors = vec![
        accessor(0, 5126, "VEC3", 4),
        accessor(1, 5122, "VEC3", 4),
        accessor(2, 5125, "SCALAR", 6),
        accessor(3, 5123, "SCALAR", 6),
    ];
    let attributes = json!({"POSITION": 0, "NORMAL": 1});
    data.glb(json!({
        "extensionsRequired": ["KHR_meshopt_compression"], "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "buffers": [{"byteLength": data.bin.len()},
            {"byteLength": 200, "extensions": {"KHR_meshopt_compression": {"fallback": true}}}],
        "meshes": [{"primitives": [{"attributes": attributes, "indices": 2}, {"attributes": attributes, "indices": 3}]}],
    }))
}

/// A torus that is there only as Google's encoder has compressed it.
fn draco(stream: &[u8], vertices: u32, corners: u32) -> Vec<u8> {
    let mut data = Data::default();
    let view = data.view(stream);
    let mut accessor = |component: u32, kind: &str, count: u32| {
        data.accessors.push(json!({"componentType": component, "count": count, "type": kind}));
        data.accessors.len() - 1
    };
    let attributes = json!({"POSITION": accessor(5126, "VEC3", vertices), "NORMAL": accessor(5126, "VEC3", vertices),
        "TEXCOORD_0": accessor(5126, "VEC2", vertices), "COLOR_0": accessor(5121, "VEC4", vertices)});
    let indices = accessor(5123, "SCALAR", corners);
    let source = json!({"bufferView": view,
        "attributes": {"POSITION": 13, "NORMAL": 12, "TEXCOORD_0": 11, "COLOR_0": 10}});
    data.glb(json!({
        "extensionsRequired": ["KHR_draco_mesh_compression"], "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": attributes, "indices": indices,
            "extensions": {"KHR_draco_mesh_compression": source}}]}],
    }))
}

pub fn scenes() -> Vec<Seed> {
    vec![
        seed("still.glb", still()),
        seed("moving.glb", moving()),
        seed("embedded.gltf", embedded()),
        seed("meshopt.glb", meshopt()),
        seed("sequential.glb", draco(include_bytes!("../draco/sequential.drc"), 54, 240)),
        seed("standard.glb", draco(include_bytes!("../draco/standard.drc"), 54, 240)),
        seed("valence.glb", draco(include_bytes!("../draco/valence.drc"), 594, 3276)),
    ]
}

/// A scene whose texture is a file beside it.
pub fn textured(image: &str) -> Vec<u8> {
    let mut data = Data::default();
    let position = data.floats("VEC3", 3, &CORNERS);
    data.glb(json!({
        "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": position}, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "textures": [{"source": 0}], "images": [{"uri": image}],
    }))
}

fn picture_file(format: ImageFormat, size: u32) -> Vec<u8> {
    let rgba = RgbaImage::from_fn(size, size, |x, y| image::Rgba([(40 * x) as u8, (30 * y) as u8, 90, 255]));
    let picture = DynamicImage::ImageRgba8(rgba);
    let mut bytes = Cursor::new(Vec::new());
    let picture = if format == ImageFormat::Jpeg { DynamicImage::ImageRgb8(picture.into_rgb8()) } else { picture };
    picture.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

/// A PNG of this kind, with its palette where it has one.
fn png_file(color: png::ColorType, depth: png::BitDepth) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 8, 8);
    encoder.set_color(color);
    encoder.set_depth(depth);
    if color == png::ColorType::Indexed {
        encoder.set_palette(vec![7; 48]);
        encoder.set_trns(vec![100; 16]);
    }
    let row_bytes = (8 * color.samples() * depth as usize).div_ceil(8);
    let data: Vec<u8> = (0..8 * row_bytes).map(|i| (i * 37) as u8).collect();
    encoder.write_header().unwrap().write_image_data(&data).unwrap();
    bytes
}

/// A DDS header of a square block-compressed texture by its DXGI format, with its blocks.
fn dds_file(format: u32, size: u32, block_bytes: u32) -> Vec<u8> {
    let mut words = vec![0x2053_4444, 124, 0x0008_1007, size, size, (size / 4).pow(2) * block_bytes, 0, 1];
    words.resize(19, 0);
    words.extend([32, 4, u32::from_le_bytes(*b"DX10"), 0, 0, 0, 0, 0, 0x1000, 0, 0, 0, 0]);
    words.extend([format, 3, 0, 1, 0]);
    let mut bytes: Vec<u8> = bytemuck::cast_slice(&words).to_vec();
    bytes.extend((0..(size / 4).pow(2) * block_bytes).map(|i| (i * 41) as u8));
    bytes
}

/// A KTX2 file of 16 x 16 texels by Vulkan's format, its bytes compressed by a scheme.
fn ktx2_file(format: u32, scheme: u32, level_bytes: u32) -> Vec<u8> {
    let data: Vec<u8> = (0..level_bytes).map(|i| (i * 41) as u8).collect();
    let level = match scheme {
        // One frame with one block, both as long as the data.
        2 => {
            [b"\x28\xb5\x2f\xfd\xa0", &level_bytes.to_le_bytes()[..], &(1 | level_bytes << 3).to_le_bytes()[..3], &data]
                .concat()
        }
        3 => {
            let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
            encoder.write_all(&data).unwrap();
            encoder.finish().unwrap()
        }
        _ => data,
    };
    Ktx2 { format, color_model: 1, size: [16, 16], scheme, level_bytes: level_bytes.into(), level: &level }.file()
}

pub fn textures() -> Vec<Seed> {
    use png::{BitDepth, ColorType};
    let mut all = vec![
        seed("a.jpg", picture_file(ImageFormat::Jpeg, 24)),
        seed("a.webp", picture_file(ImageFormat::WebP, 12)),
        seed("bc1.dds", dds_file(71, 8, 8)),
        seed("bc5.dds", dds_file(83, 8, 16)),
        seed("bc6.dds", dds_file(95, 8, 16)),
        seed("bc7.dds", dds_file(98, 8, 16)),
        seed("rgba8.ktx2", ktx2_file(43, 0, 1024)),
        seed("r8.ktx2", ktx2_file(9, 2, 256)),
        seed("bc7.ktx2", ktx2_file(145, 3, 256)),
        seed("etc1s.ktx2", include_bytes!("../textures/etc1s.ktx2")),
        seed("uastc.ktx2", include_bytes!("../textures/uastc.ktx2")),
    ];
    let kinds =
        [(ColorType::Rgb, BitDepth::Eight), (ColorType::Rgba, BitDepth::Sixteen), (ColorType::Indexed, BitDepth::Four)];
    all.extend(kinds.map(|(color, depth)| seed("a.png", png_file(color, depth))));
    all
}

pub fn pictures() -> Vec<Seed> {
    use png::{BitDepth, ColorType};
    let mut all = exrs();
    let kinds =
        [(ColorType::Rgb, BitDepth::Eight), (ColorType::Grayscale, BitDepth::One), (ColorType::Indexed, BitDepth::Two)];
    all.extend(kinds.map(|(color, depth)| seed("a.png", png_file(color, depth))));
    all
}

pub fn environments() -> Vec<Seed> {
    let mut all = exrs();
    let texels: Vec<image::Rgb<f32>> = (0..32).map(|i| image::Rgb([i as f32, 0.5, 1.0])).collect();
    let mut bytes = Vec::new();
    image::codecs::hdr::HdrEncoder::new(&mut bytes).encode(&texels, 16, 2).unwrap();
    all.push(seed("a.hdr", bytes));
    // Runs as the first version of the format has them.
    let old = [
        b"#?RGBE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=2\n\n-Y 2 +X 4\n".as_slice(),
        &[9, 8, 7, 128, 1, 1, 1, 3].repeat(2),
    ]
    .concat();
    all.push(seed("old.hdr", old));
    all
}

/// OpenEXR files of all kinds of numbers, compressions and blocks.
fn exrs() -> Vec<Seed> {
    let half = |names: &[&str]| {
        exr_file(names, Compression::ZIP16, Blocks::ScanLines, |i| {
            FlatSamples::F16((0..15).map(|j| f16::from_f32((i + j) as f32)).collect())
        })
    };
    let float = |names: &[&str], compression, blocks| {
        exr_file(names, compression, blocks, |i| FlatSamples::F32((0..15).map(|j| (i + j) as f32).collect()))
    };
    let rgb = &["B", "G", "R"];
    let tiles = Blocks::Tiles(Vec2(2, 2));
    vec![
        seed("half.exr", half(rgb)),
        seed("gray.exr", half(&["Y"])),
        seed("layers.exr", half(&["left.B", "left.G", "left.R", "Z"])),
        seed("plain.exr", float(rgb, Compression::Uncompressed, Blocks::ScanLines)),
        seed("rle.exr", float(rgb, Compression::RLE, Blocks::ScanLines)),
        seed("zip.exr", float(rgb, Compression::ZIP1, Blocks::ScanLines)),
        seed("piz.exr", float(rgb, Compression::PIZ, Blocks::ScanLines)),
        seed("pxr.exr", float(rgb, Compression::PXR24, Blocks::ScanLines)),
        seed("b44.exr", half(rgb)),
        seed("tiles.exr", float(rgb, Compression::ZIP16, tiles)),
        seed("tiles-plain.exr", float(&["Y"], Compression::Uncompressed, tiles)),
    ]
}

fn exr_file(
    names: &[&str],
    compression: Compression,
    blocks: Blocks,
    samples: impl Fn(usize) -> FlatSamples,
) -> Vec<u8> {
    let channels: SmallVec<[AnyChannel<FlatSamples>; 4]> =
        names.iter().enumerate().map(|(i, name)| AnyChannel::new(*name, samples(i))).collect();
    let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
    let layer = Layer::new((5, 3), LayerAttributes::default(), encoding, AnyChannels::sort(channels));
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

pub fn settings() -> Vec<Seed> {
    let defaults = Settings::default();
    let some = "technique = \"pbgi\"\nsize = \"640x360\"\nlevels = 5\nexposure = 2.0\nalpha = 1.5\nsun = \"130,40\"\n\
                environment = \"0.5,0.5,1\"\ncamera = \"court\"\nvpls = 5000\nframes = 3\ntimings = [\"a.json\"]\n";
    vec![
        seed("a.json", serde_json::to_vec(&defaults).unwrap()),
        seed("a.toml", defaults.to_toml().unwrap()),
        seed("b.toml", some),
        seed(
            "b.json",
            r#"{"frames": 2, "size": "9x9", "levels": "auto", "exposure": "auto", "scene": "a.glb", "sun": "1,2"}"#,
        ),
    ]
}

pub fn timings() -> Vec<Seed> {
    let ms = |median: f64| json!({"min": 1.0, "median": median, "mean": 2.0, "p95": 3.0, "max": 4.0});
    let file = json!({
        "schema": gridlight::files::TIMINGS_SCHEMA, "device": {"name": "a"}, "machine": {"cpu": "b"},
        "scene": {"name": "c", "triangles": 3, "camera": "d"}, "settings": serde_json::to_value(Settings::default()).unwrap(),
        "passes": [{"name": "gbuffer", "frames": 2, "ms": ms(1.5)}, {"name": "light_gather", "frames": 2, "ms": ms(3.5)}],
        "frame_gpu_ms": ms(5.0), "frame_cpu_ms": ms(5.5),
    });
    vec![seed("a.json", file.to_string())]
}

pub fn scripts() -> Vec<Seed> {
    let text = "# a demo\nat 0 camera 0\nat 5 key w 40\nat 60 screenshot around\nat 1.5s look 10 -3\nat 2 resize 640x360\n\
                at 3 set alpha 2\nat 3 technique pbgi\nat 4 divider 0.5\nat 4 inspect 0.5 0.5\nat 9 drop a.glb\n\
                at 2s key right 0.5\nat 10 split\nat 61 quit\n";
    vec![seed("a.txt", text)]
}

/// A dump of two files in a folder, complete.
pub fn write_dump(folder: &Path) {
    std::fs::create_dir_all(folder).unwrap();
    let fields = vec![Field::new("position_ws", Scalar::F32, &[3]), Field::new("levels", Scalar::U32, &[2])];
    let array = Array::records(fields, &[3], &(0..60).collect::<Vec<u8>>());
    array.write(&folder.join("a.npy")).unwrap();
    let channels = ["B", "G"].map(|name| (name.to_owned(), vec![0; 24])).to_vec();
    let picture = Picture { width_px: 3, height_px: 2, scalar: Scalar::F32, channels };
    picture.write(&folder.join("b.exr")).unwrap();
    let entry = |name: &str, file: &str, dtype: Value, shape: &[u64]| FileEntry {
        pass_index: Some(0),
        pass: "gbuffer".to_owned(),
        resource: name.to_owned(),
        kind: "buffer".to_owned(),
        file: file.to_owned(),
        dtype,
        shape: shape.to_vec(),
        channels: Vec::new(),
        first_element: 0,
        resource_bytes: 60,
        layout: None,
        scale: [("position_ws".to_owned(), 0.5)].into(),
        units: "metres".to_owned(),
        meaning: "points".to_owned(),
    };
    let files = vec![entry("a", "a.npy", array.dtype_json(), &[3]), entry("b", "b.exr", json!("<f4"), &[2, 3])];
    let manifest = Manifest {
        schema: gridlight::report::dump::manifest::SCHEMA.to_owned(),
        settings: serde_json::to_value(Settings::default()).unwrap(),
        scene: json!({"name": "a"}),
        passes: vec!["gbuffer".to_owned()],
        files,
        ..Manifest::default()
    };
    manifest.write(folder).unwrap();
}

/// The files of a dump; where one lies is its name.
pub fn dump_files() -> Vec<Seed> {
    let folder = tempfile::tempdir().unwrap();
    write_dump(folder.path());
    [FILE_NAME, "a.npy", "b.exr"].map(|name| seed(name, std::fs::read(folder.path().join(name)).unwrap())).to_vec()
}
