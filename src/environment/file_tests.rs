use std::path::PathBuf;

use exr::image::write::WritableImage as _;
use exr::image::{Encoding, Image, Layer, SpecificChannels};
use exr::math::Vec2;
use exr::meta::attribute::IntegerBounds;
use exr::meta::header::LayerAttributes;
use half::f16;
use image::codecs::hdr::HdrEncoder;

use super::*;

const SIZE: Vec2<usize> = Vec2(8, 4);

/// Red, green and blue at a place: different everywhere, exact in 16 bits.
fn color(at: Vec2<usize>) -> [f32; 3] {
    [at.0 as f32, at.1 as f32, 0.25 * (at.0 + at.1) as f32]
}

fn rgb() -> Vec<[f32; 3]> {
    (0..SIZE.1).flat_map(|y| (0..SIZE.0).map(move |x| color(Vec2(x, y)))).collect()
}

fn gray() -> Vec<[f32; 3]> {
    rgb().iter().map(|texel| [texel[2]; 3]).collect()
}

fn path(folder: &tempfile::TempDir, name: &str) -> PathBuf {
    folder.path().join(name)
}

fn assert_reads(path: &Path, expected: &[[f32; 3]]) {
    let found = read(path).unwrap();
    assert_eq!((found.size, found.suns.len()), ([8, 4], 0), "{}", path.display());
    assert_eq!(found.radiance, expected, "{}", path.display());
}

#[test]
fn every_encoding_and_sample_type_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let tiled =
        |compression| Encoding { compression, blocks: exr::image::Blocks::Tiles(Vec2(3, 3)), ..Encoding::UNCOMPRESSED };
    let compressions = [
        exr::compression::Compression::ZIP16,
        exr::compression::Compression::ZIP1,
        exr::compression::Compression::RLE,
        exr::compression::Compression::PIZ,
    ];
    let encodings = compressions.map(tiled).into_iter().chain([
        Encoding::UNCOMPRESSED,
        Encoding::SMALL_LOSSLESS,
        Encoding::FAST_LOSSLESS,
    ]);
    for (index, encoding) in encodings.enumerate() {
        let file = path(&folder, &format!("{index}.exr"));
        let channels = SpecificChannels::rgb(|at| (color(at)[0], color(at)[1], color(at)[2]));
        let layer = Layer::new(SIZE, LayerAttributes::default(), encoding, channels);
        Image::from_layer(layer).write().to_file(&file).unwrap();
        assert_reads(&file, &rgb());
    }
    let file = path(&folder, "mixed.exr");
    let channels = SpecificChannels::build()
        .with_channel("A")
        .with_channel("B")
        .with_channel("G")
        .with_channel("R")
        .with_pixel_fn(|at: Vec2<usize>| {
            (f16::from_f32(0.5), color(at)[2], f16::from_f32(color(at)[1]), color(at)[0] as u32)
        });
    Image::from_channels(SIZE, channels).write().to_file(&file).unwrap();
    assert_reads(&file, &rgb());
}

#[test]
fn luminance_and_named_layers_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let file = path(&folder, "y.exr");
    let channels =
        SpecificChannels::build().with_channel("A").with_channel("Y").with_pixel_fn(|at| (1.0_f32, color(at)[2]));
    Image::from_channels(SIZE, channels).write().to_file(&file).unwrap();
    assert_reads(&file, &gray());
    let channels = || {
        SpecificChannels::build()
            .with_channel("Y")
            .with_channel("light.B")
            .with_channel("light.G")
            .with_channel("light.R")
            .with_pixel_fn(|at| (7.0_f32, color(at)[2], color(at)[1], color(at)[0]))
    };
    let file = path(&folder, "layer.exr");
    Image::from_channels(SIZE, channels()).write().to_file(&file).unwrap();
    assert_reads(&file, &rgb());
    let file = path(&folder, "depth.exr");
    let depth = SpecificChannels::build().with_channel("Z").with_channel("R").with_pixel_fn(|_| (1.0_f32, 1.0_f32));
    Image::from_channels(SIZE, depth).write().to_file(&file).unwrap();
    let error = read(&file).unwrap_err().to_string();
    assert!(
        error.contains("depth.exr: the environment cannot be read: it has the channels R, Z, and neither"),
        "{error}"
    );
}

#[test]
fn a_part_of_the_picture_is_put_where_it_belongs() {
    let folder = tempfile::tempdir().unwrap();
    let file = path(&folder, "cropped.exr");
    let attributes = LayerAttributes { layer_position: Vec2(2, 1), ..LayerAttributes::default() };
    let channels = SpecificChannels::rgb(|at: Vec2<usize>| {
        let [r, g, b] = color(Vec2(at.0 + 2, at.1 + 1));
        (r, g, b)
    });
    let layer = Layer::new((4, 2), attributes, Encoding::FAST_LOSSLESS, channels);
    let mut image = Image::from_layer(layer);
    image.attributes.display_window = IntegerBounds::from_dimensions(SIZE);
    image.write().to_file(&file).unwrap();
    let inside = |index: usize| (2..6).contains(&(index % 8)) && (1..3).contains(&(index / 8));
    let expected: Vec<[f32; 3]> =
        rgb().iter().enumerate().map(|(index, texel)| if inside(index) { *texel } else { [0.0; 3] }).collect();
    assert_reads(&file, &expected);
}

#[test]
fn radiance_files_are_read_by_either_first_line_and_with_their_exposure() {
    let folder = tempfile::tempdir().unwrap();
    let mut bytes = Vec::new();
    let texels: Vec<image::Rgb<f32>> = rgb().iter().map(|texel| image::Rgb(texel.map(|value| 4.0 * value))).collect();
    HdrEncoder::new(&mut bytes).encode(&texels, SIZE.0, SIZE.1).unwrap();
    let start = bytes.windows(2).position(|two| two == b"\n\n").unwrap();
    let body = &bytes[start..];
    for (name, head) in [
        ("a.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=4"),
        ("b.HDR", "#?RGBE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=4.0"),
    ] {
        let file = path(&folder, name);
        std::fs::write(&file, [head.as_bytes(), body].concat()).unwrap();
        let found = read(&file).unwrap();
        let near = |(a, b): (&[f32; 3], &[f32; 3])| a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 0.05 * b.max(1.0));
        assert!(found.size == [8, 4] && found.radiance.iter().zip(&rgb()).all(near), "{:?}", found.radiance);
    }
}

#[test]
fn large_images_are_averaged_with_their_power() {
    let folder = tempfile::tempdir().unwrap();
    let file = path(&folder, "wide.exr");
    let bright = |at: Vec2<usize>| if at == Vec2(9_000, 7) { 4e6 } else { 1.0 + (at.0 % 3) as f32 };
    let channels = SpecificChannels::build().with_channel("Y").with_pixel_fn(|at| (bright(at),));
    Image::from_channels((16_384, 16), channels).write().to_file(&file).unwrap();
    let found = read(&file).unwrap();
    assert_eq!((found.size, found.radiance.len()), ([4096, 16], 4096 * 16));
    let texels = (0..16).flat_map(|y| (0..16_384).map(move |x| [bright(Vec2(x, y)); 3])).collect();
    let all = Environment { size: [16_384, 16], radiance: texels, suns: Vec::new() };
    let [before, after] = [&all, &found].map(|environment| environment.scalar_irradiance().x);
    assert!((after / before - 1.0).abs() < 1e-4, "{before} became {after}");
    assert!((found.radiance[7 * 4096 + 2250][0] - 1e6).abs() < 2.0);
}

#[test]
fn values_that_are_no_radiance_count_as_zero() {
    let folder = tempfile::tempdir().unwrap();
    let file = path(&folder, "bad.exr");
    let channels = SpecificChannels::rgb(|at: Vec2<usize>| match at {
        Vec2(0, 0) => (f32::NAN, 1.0, 2.0),
        Vec2(1, 0) => (f32::INFINITY, f32::NEG_INFINITY, -1.0),
        at => (color(at)[0], color(at)[1], color(at)[2]),
    });
    Image::from_channels(SIZE, channels).write().to_file(&file).unwrap();
    let mut expected = rgb();
    (expected[0], expected[1]) = ([0.0, 1.0, 2.0], [0.0; 3]);
    assert_reads(&file, &expected);
    assert_eq!(read_exr(&file, File::open(&file).unwrap()).unwrap().unusable, 4);
}

#[test]
fn sizes_that_a_file_cannot_have_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = path(&folder, "a.hdr");
    for (size, reason) in [
        ("-Y 60000 +X 60000", "268435456 texels are the most"),
        ("-Y 9000 +X 9000", "it cannot have the 9000x9000 texels"),
        ("-Y 0 +X 3", "its size is 3x0"),
    ] {
        std::fs::write(&path, format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{size}\n1234")).unwrap();
        let refused = read(&path).err().unwrap().to_string();
        assert!(refused.contains(reason), "{refused}");
    }
}
