//! The bytes of a file's first level, decompressed as they are read.

use std::io::Read;

use flate2::read::ZlibDecoder;
use ktx2::{Reader, SupercompressionScheme};
use ruzstd::decoding::StreamingDecoder;

/// Windows of Zstandard up to this size, in bytes, are allowed in every file. Its levels up to 20 make none larger. The
/// decoder takes up to one and a half times as much while its buffer grows.
const WINDOW_BYTES: u64 = 32 << 20;

/// The first level, which must announce so many bytes.
pub(super) fn open<'a>(reader: &'a Reader<&[u8]>, byte_count: u64) -> Result<Box<dyn Read + 'a>, String> {
    let level = reader.levels().next().ok_or("it has no levels")?;
    let scheme = reader.header().supercompression_scheme;
    let announced = if scheme.is_some() { level.uncompressed_byte_length } else { level.data.len() as u64 };
    if announced != byte_count {
        return Err(format!("its first level announces {announced} bytes, and its texels are {byte_count}"));
    }
    match scheme {
        None => Ok(Box::new(level.data)),
        Some(SupercompressionScheme::ZLIB) => Ok(Box::new(ZlibDecoder::new(level.data))),
        Some(SupercompressionScheme::Zstandard) => {
            // Three bytes of memory for one of the window stay below four for one of the file.
            let most = WINDOW_BYTES.max(level.data.len() as u64);
            let decoder = StreamingDecoder::new_with_max_window_size(level.data, most);
            Ok(Box::new(decoder.map_err(|error| format!("its texels are damaged: {error}"))?))
        }
        Some(scheme) => Err(format!("its supercompression scheme {} is not known", scheme.value())),
    }
}
