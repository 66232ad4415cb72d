//! Files written here byte by byte, whole ones and wrong ones.

use std::io::{Read, Write};

use flate2::Compression;
use flate2::write::ZlibEncoder;

use super::decode;
use crate::files::guard::guarded;
use crate::scene::testing::Ktx2;

const R8: u32 = 9;
const R8G8: u32 = 16;
const R8G8B8: u32 = 23;
const B8G8R8: u32 = 30;
const R8G8B8A8_UNORM: u32 = 37;
const R8G8B8A8_SRGB: u32 = 43;
const B8G8R8A8: u32 = 44;
const BC1_RGB: u32 = 131;
const BC1_RGBA: u32 = 133;
const BC4: u32 = 139;
const BC7_SRGB: u32 = 146;
const NO_COMPRESSION: u32 = 0;
const ZSTANDARD: u32 = 2;
const ZLIB: u32 = 3;

/// A file whose level is not compressed.
fn plain(format: u32, size: [u32; 2], level: &[u8]) -> Ktx2<'_> {
    Ktx2 { format, color_model: 1, size, scheme: NO_COMPRESSION, level_bytes: level.len() as u64, level }
}

/// A file whose level is compressed, and comes to so many bytes.
fn packed(format: u32, size: [u32; 2], scheme: u32, level_bytes: u64, level: &[u8]) -> Ktx2<'_> {
    Ktx2 { scheme, level_bytes, ..plain(format, size, level) }
}

/// A frame of Zstandard that says how much it holds, with blocks that are each data as it is, or a byte that repeats.
fn frame(content_bytes: u32, blocks: &[(&[u8], u32)]) -> Vec<u8> {
    let mut frame = b"\x28\xb5\x2f\xfd\xa0".to_vec();
    frame.extend(content_bytes.to_le_bytes());
    for (i, (data, repeats)) in blocks.iter().enumerate() {
        let is_last = u32::from(i + 1 == blocks.len());
        let (kind, size) = if *repeats > 0 { (1, *repeats) } else { (0, data.len() as u32) };
        frame.extend(&(is_last | kind << 1 | size << 3).to_le_bytes()[..3]);
        frame.extend(*data);
    }
    frame
}

fn deflated(data: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(data).unwrap();
    encoder.finish().unwrap()
}

fn texels(file: &Ktx2) -> Vec<u8> {
    let (size, rgba) = decode(&file.file()).unwrap();
    assert_eq!(size, file.size);
    rgba
}

fn refusal(file: &[u8]) -> String {
    guarded(|| decode(file)).unwrap_err()
}

#[test]
fn formats_become_rgba() {
    let four = [1, 2, 3, 4, 5, 6, 7, 8];
    for (format, level, wanted) in [
        (R8G8B8A8_UNORM, &four[..], [1, 2, 3, 4, 5, 6, 7, 8]),
        (R8G8B8A8_SRGB, &four, [1, 2, 3, 4, 5, 6, 7, 8]),
        (B8G8R8A8, &four, [3, 2, 1, 4, 7, 6, 5, 8]),
        (R8G8B8, &four[..6], [1, 2, 3, 255, 4, 5, 6, 255]),
        (B8G8R8, &four[..6], [3, 2, 1, 255, 6, 5, 4, 255]),
        // A channel is grey, and two are a normal: its z comes from them.
        (R8, &[10, 20], [10, 10, 10, 255, 20, 20, 20, 255]),
        (R8G8, &[128, 127, 255, 128], [128, 127, 255, 255, 255, 128, 128, 255]),
    ] {
        assert_eq!(texels(&plain(format, [2, 1], level)), wanted, "{format}");
    }
}

/// Six by five texels in four blocks: only the texels of the image are there.
#[test]
fn blocks_are_cut_at_the_edges() {
    // Red and blue of 5 bits. With the larger colour first all texels are the first; else the fourth choice is nothing.
    let block =
        |first: u16, second: u16, choice: u8| [&first.to_le_bytes()[..], &second.to_le_bytes(), &[choice; 4]].concat();
    let level = [block(0xf800, 0, 0), block(0x001f, 0, 0), block(0, 0x001f, 0xff), block(0xf800, 0, 0)].concat();
    let row = |left: [u8; 4], right: [u8; 4]| [left, left, left, left, right, right].concat();
    let (red, blue) = ([255, 0, 0, 255], [0, 0, 255, 255]);
    let wanted = |hole: [u8; 4]| [row(red, blue).repeat(4), row(hole, red)].concat();
    assert_eq!(texels(&plain(BC1_RGBA, [6, 5], &level)), wanted([0; 4]));
    assert_eq!(texels(&plain(BC1_RGB, [6, 5], &level)), wanted([0, 0, 0, 255]), "a format without alpha");
    // A block between 200 and 100 whose texels are all the first, and mode 6 of BC7 with everything zero but its alpha.
    assert_eq!(texels(&plain(BC4, [4, 1], &[200, 100, 0, 0, 0, 0, 0, 0])), [200, 200, 200, 255].repeat(4));
    let bc7 = (1_u128 << 6 | 0x3fff << 49).to_le_bytes();
    assert_eq!(texels(&plain(BC7_SRGB, [1, 1], &bc7)), [0, 0, 0, 254]);
}

/// As many rows as make several strips, each with its own values.
#[test]
fn every_compression_gives_the_same_texels() {
    let size = [3, 200];
    let level: Vec<u8> = (0..2400_u32).map(|i| (i * i / 7) as u8).collect();
    let (first, second) = level.split_at(1000);
    let zstandard = frame(2400, &[(first, 0), (second, 0)]);
    assert_eq!(texels(&plain(R8G8B8A8_UNORM, size, &level)), level);
    assert_eq!(texels(&packed(R8G8B8A8_UNORM, size, ZSTANDARD, 2400, &zstandard)), level);
    assert_eq!(texels(&packed(R8G8B8A8_UNORM, size, ZLIB, 2400, &deflated(&level))), level);
}

/// More texels than are taken on trust.
#[test]
fn large_levels_are_read_twice() {
    let size = [2048, 2049];
    let bytes = size[0] * size[1];
    let blocks = [(&[7][..], 1 << 17)].repeat(bytes as usize >> 17);
    let level = frame(bytes, &[&blocks[..], &[(&[9; 2048], 0)]].concat());
    let rgba = texels(&packed(R8, size, ZSTANDARD, u64::from(bytes), &level));
    assert!(rgba[..8 << 20 << 1].chunks_exact(4).all(|texel| texel == [7, 7, 7, 255]));
    assert!(rgba.ends_with(&[9, 9, 9, 255]) && rgba.len() == 4 * bytes as usize);
}

/// Each fault of a header, as a word that is written over one of a right file.
#[test]
fn wrong_headers_are_named() {
    let right = plain(R8, [4, 4], &[0; 16]).file();
    let with = |at: usize, word: u32| {
        let mut file = right.clone();
        file[at..at + 4].copy_from_slice(&word.to_le_bytes());
        refusal(&file)
    };
    assert!(decode(&right).is_ok());
    let (announced, ends) =
        ("its first level announces", "it ends before what its header and its list of levels announce");
    for (at, word, wanted) in [
        (4, u32::from_le_bytes(*b" 11\xbb"), "it is a KTX file of another version than 2"),
        (12, 97, "its format R16G16B16A16_SFLOAT is not read"),
        (12, 157, "its format ASTC_4x4_UNORM_BLOCK is not read"),
        (12, 151, "its format ETC2_R8G8B8A8_UNORM_BLOCK is not read"),
        (12, 12345, "its format Format(12345) is not read"),
        (12, 0, "its format RGBSDA without a Vulkan format is not read"),
        (20, 0, "it has no pixels"),
        (20, 100_000, "it has 100000x4 pixels, and 16384 are the most on a side"),
        (24, 0, "it is a 1D texture, and only single 2D images are read"),
        (24, 16_385, "it has 4x16385 pixels, and 16384 are the most on a side"),
        (24, 5, "its first level announces 16 bytes, and its texels are 20"),
        (28, 1, "it is a 3D texture, and only single 2D images are read"),
        (32, 2, "it is an array of textures, and only single 2D images are read"),
        (36, 0, "its header is damaged: zero face count"),
        (36, 6, "it is a cube map, and only single 2D images are read"),
        (40, u32::MAX, ends),
        (44, 1, "its R8_UNORM is supercompressed by BasisLZ, which is for ETC1S"),
        (44, 9, "its supercompression scheme 9 is not known"),
        (48, u32::MAX, ends),
        (52, 1 << 20, "its data format descriptor of 1048576 bytes is too long"),
        (64, 1 << 31, ends),
        (80, 149, ends),
        (88, 15, announced),
        (92, 1, ends),
    ] {
        let told = with(at, word);
        assert!(told.starts_with(wanted), "{word} at {at}: {told}");
    }
    for length in 0..right.len() {
        assert_eq!(refusal(&right[..length]), ends, "{length} bytes");
    }
}

#[test]
fn wrong_levels_are_named() {
    let level = [3; 16];
    let whole = frame(16, &[(&level, 0)]);
    let zstandard = |level_bytes, level: &[u8]| refusal(&packed(R8, [4, 4], ZSTANDARD, level_bytes, level).file());
    assert_eq!(zstandard(17, &whole), "its first level announces 17 bytes, and its texels are 16");
    for (level, wanted) in [
        (&frame(17, &[(&[3; 17], 0)])[..], "its first level holds more than it announces"),
        // A bomb: it ends where its texels do.
        (&frame(100 << 17, &[(&[3][..], 1 << 17)].repeat(100)), "its first level holds more than it announces"),
        (&frame(15, &[(&[3; 15], 0)]), "its texels are damaged"),
        (&whole[..whole.len() - 1], "its texels are damaged"),
        (&frame(1 << 26, &[(&level, 0)]), "its texels are damaged"),
        (b"zstd", "its texels are damaged"),
    ] {
        let told = zstandard(16, level);
        assert!(told.starts_with(wanted), "{told}");
    }
    let zlib = |level: &[u8]| refusal(&packed(R8, [4, 4], ZLIB, 16, level).file());
    assert_eq!(zlib(&deflated(&[3; 17])), "its first level holds more than it announces");
    assert!(zlib(&deflated(&[3; 15])).starts_with("its texels are damaged"));
    assert!(zlib(&level).starts_with("its texels are damaged"));
}

/// What `tests/textures/README.md` tells of, decoded there by the transcoder of Basis Universal itself.
#[test]
fn basis_universal_is_decoded_as_by_its_own_transcoder() {
    let uastc = include_bytes!("../../../tests/textures/uastc.ktx2");
    let etc1s = include_bytes!("../../../tests/textures/etc1s.ktx2");
    let wanted = |png: &[u8]| image::load_from_memory(png).unwrap().into_rgba8().into_raw();
    let wanted_uastc = wanted(include_bytes!("../../../tests/textures/uastc.png"));
    let wanted_etc1s = wanted(include_bytes!("../../../tests/textures/etc1s.png"));
    assert!(decode(etc1s).unwrap() == ([32, 32], wanted_etc1s.clone()));
    assert!(decode(uastc).unwrap() == ([32, 32], wanted_uastc.clone()));
    assert!(wanted_uastc != wanted_etc1s);
    // The same blocks as they are, by zlib, and more of them than a strip has.
    let blocks = first_level(uastc);
    let file = Ktx2 { color_model: 166, ..plain(0, [32, 32], &blocks) };
    assert!(texels(&file) == wanted_uastc);
    assert!(texels(&Ktx2 { scheme: ZLIB, level: &deflated(&blocks), ..file }) == wanted_uastc);
    let tall = blocks.repeat(5);
    assert!(texels(&Ktx2 { color_model: 166, ..plain(0, [32, 160], &tall) }) == wanted_uastc.repeat(5));
}

/// The bytes of a file's first level, decompressed.
fn first_level(file: &[u8]) -> Vec<u8> {
    let reader = ktx2::Reader::new(file).unwrap();
    let mut source = super::level::open(&reader, 1024).unwrap();
    let mut bytes = Vec::new();
    source.read_to_end(&mut bytes).unwrap();
    bytes
}

#[test]
fn wrong_basis_files_are_named() {
    let etc1s = include_bytes!("../../../tests/textures/etc1s.ktx2");
    let with = |file: &[u8], at: usize, word: u32| {
        let mut file = file.to_vec();
        file[at..at + 4].copy_from_slice(&word.to_le_bytes());
        refusal(&file)
    };
    assert_eq!(with(etc1s, 44, 0), "its ETC1S is not supercompressed by BasisLZ");
    assert_eq!(with(etc1s, 44, 2), "its ETC1S is not supercompressed by BasisLZ");
    assert_eq!(with(etc1s, 20, 16_385), "it has 16385x32 pixels, and 16384 are the most on a side");
    let damaged = "its texels are damaged";
    let global_data = u32::from_le_bytes([etc1s[64], etc1s[65], etc1s[66], etc1s[67]]) as usize;
    assert_eq!(with(etc1s, global_data, 0), damaged, "no colours");
    assert_eq!(with(etc1s, global_data + 4, u32::MAX), damaged, "more bytes of colours than there are");
    assert_eq!(with(etc1s, global_data + 24, 1 << 20), damaged, "an image beyond the file");
    let uastc = Ktx2 { color_model: 166, ..plain(0, [4, 4], &[0x45; 16]) };
    assert_eq!(refusal(&uastc.file()), damaged, "no mode of a block");
    let basis_lz = Ktx2 { scheme: 1, ..uastc };
    assert_eq!(refusal(&basis_lz.file()), "its UASTC is supercompressed by BasisLZ, which is for ETC1S");
    assert_eq!(
        refusal(&Ktx2 { level: &[0; 15], ..uastc }.file()),
        "its first level announces 15 bytes, and its texels are 16"
    );
}

/// Metadata that `KHR_texture_basisu` forbids.
#[test]
fn other_orders_are_refused() {
    let with = |entry: &[u8]| {
        let mut file = plain(R8, [1, 1], &[9]).file();
        let at = file.len() as u32;
        let data = [&(entry.len() as u32).to_le_bytes()[..], entry, &[0; 8]].concat();
        file[56..60].copy_from_slice(&at.to_le_bytes());
        file[60..64].copy_from_slice(&(data.len() as u32 - 1).to_le_bytes());
        file.extend(data);
        decode(&file).map(|_| ())
    };
    assert_eq!(with(b"KTXorientation\0rd\0"), Ok(()));
    assert_eq!(with(b"KTXswizzle\0rgba\0"), Ok(()));
    assert_eq!(with(b"KTXwriter\0a\0"), Ok(()));
    let told = with(b"KTXorientation\0ru\0").unwrap_err();
    assert_eq!(told, "its KTXorientation is \"ru\", and only rd is read");
    assert_eq!(with(b"KTXswizzle\0rrr1\0").unwrap_err(), "its KTXswizzle is \"rrr1\", and only rgba is read");
    let mut file = plain(R8, [1, 1], &[9]).file();
    file[104 + 4 + 11] = 1;
    assert_eq!(refusal(&file), "its colours are multiplied by their alpha, which glTF does not allow");
}
