//! Basis Universal: blocks of UASTC, and whole images of ETC1S.

use basisu::{DecodeFlags, Error, TargetFormat, Transcoder};
use ktx2::{ColorModel, Header, Index, LevelIndex};

/// Bytes of a block of UASTC, of 4 x 4 texels.
pub(super) const UASTC_BLOCK_BYTES: u64 = 16;

/// RGBA8 of an image of UASTC, from its blocks.
pub(super) fn decode_uastc(blocks: &[u8], size: [u32; 2]) -> Result<Vec<u8>, String> {
    let file = uastc_file(blocks, size);
    let transcoder = Transcoder::new(&file).map_err(|error| told(&error))?;
    transcoder.transcode(0, TargetFormat::Rgba32, DecodeFlags::NONE).map_err(|error| told(&error))
}

/// RGBA8 of the first level of a file of ETC1S. Unless `is_small`, it is first decoded to blocks of a GPU's format, which
/// take an eighth of the memory, a quarter with alpha: a file of any length may announce any size.
pub(super) fn decode_etc1s(file: &[u8], is_small: bool) -> Result<Vec<u8>, String> {
    let transcoder = Transcoder::new(file).map_err(|error| told(&error))?;
    let decode = |target| transcoder.transcode(0, target, DecodeFlags::NONE).map_err(|error| told(&error));
    if !is_small {
        decode(if transcoder.has_alpha() { TargetFormat::Etc2Rgba } else { TargetFormat::Etc1Rgb })?;
    }
    decode(TargetFormat::Rgba32)
}

fn told(error: &Error) -> String {
    match error {
        Error::VideoRequiresState => "it is a video, and only still images are read".to_owned(),
        _ => "its texels are damaged".to_owned(),
    }
}

/// The smallest file around blocks: the decoder takes nothing else.
fn uastc_file(blocks: &[u8], [pixel_width, pixel_height]: [u32; 2]) -> Vec<u8> {
    const DESCRIPTOR_WORDS: usize = 11;
    let descriptor_bytes = 4 * DESCRIPTOR_WORDS as u32;
    let descriptor_at = (Header::LENGTH + LevelIndex::LENGTH) as u32;
    // A transfer function is demanded, and has no effect: 1 is linear.
    let model = u32::from(ColorModel::UASTC.value()) | 1 << 16;
    let block_size_minus_1 = 0x0303;
    // One sample of 128 bits that has RGBA.
    let sample_bits_and_channel = 127 << 16 | 3 << 24;
    let descriptor: [u32; DESCRIPTOR_WORDS] = [
        descriptor_bytes,
        0,
        2 | (descriptor_bytes - 4) << 16,
        model,
        block_size_minus_1,
        UASTC_BLOCK_BYTES as u32,
        0,
        sample_bits_and_channel,
        0,
        0,
        u32::MAX,
    ];
    let header = Header {
        format: None,
        type_size: 1,
        pixel_width,
        pixel_height,
        pixel_depth: 0,
        layer_count: 0,
        face_count: 1,
        level_count: 1,
        supercompression_scheme: None,
        index: Index {
            dfd_byte_offset: descriptor_at,
            dfd_byte_length: descriptor_bytes,
            kvd_byte_offset: 0,
            kvd_byte_length: 0,
            sgd_byte_offset: 0,
            sgd_byte_length: 0,
        },
    };
    let byte_length = blocks.len() as u64;
    let byte_offset = u64::from(descriptor_at + descriptor_bytes);
    let level = LevelIndex { byte_offset, byte_length, uncompressed_byte_length: byte_length };
    let descriptor = descriptor.map(u32::to_le_bytes).concat();
    [&header.as_bytes()[..], &level.as_bytes(), &descriptor, blocks].concat()
}
