//! What stands for the decoders of compressed meshes and images in a build without the feature `codecs`: files that require
//! one are refused by `gltf_extensions`, and others read as by a program that does not know the extension.

use super::gltf_extensions::NEEDS_CODECS;

pub(super) mod gltf_draco {
    use crate::Result;
    use crate::scene::gltf_buffers::Document;

    /// Leaves every primitive with what it has besides.
    pub fn decompress(_: &mut Document) -> Result<()> {
        Ok(())
    }
}

pub(super) mod gltf_meshopt {
    use std::collections::{HashMap, HashSet};

    use gltf::json::Root;

    use crate::Result;
    use crate::scene::gltf_buffers::Document;

    /// None, so that every view is read from its own buffer.
    pub fn compressed_views(_: &Document) -> Result<Vec<()>> {
        Ok(Vec::new())
    }

    /// None.
    pub fn placeholders(_: &Root, _: &[()]) -> HashSet<usize> {
        HashSet::new()
    }

    /// Nothing.
    pub fn decompress(_: &Document, _: &[()]) -> Result<HashMap<usize, Vec<u8>>> {
        Ok(HashMap::new())
    }
}

pub(super) mod gltf_dds {
    use crate::scene::Texture;

    /// Says that the image is not read.
    pub fn decode(_: &str, _: &[u8]) -> Result<Texture, String> {
        Err(format!("it is a DDS image, and {}", super::NEEDS_CODECS))
    }
}

pub(super) mod ktx2 {
    /// What every KTX file begins with, of whatever version.
    pub const MAGIC: &[u8] = b"\xabKTX ";

    /// Says that the image is not read.
    pub fn decode(_: &[u8]) -> Result<([u32; 2], Vec<u8>), String> {
        Err(format!("it is a KTX image, and {}", super::NEEDS_CODECS))
    }

    /// No size, as nothing is decoded.
    pub fn announced_size(_: &[u8]) -> Option<[u32; 2]> {
        None
    }
}
