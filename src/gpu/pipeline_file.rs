//! The driver's pipeline cache on disk: compiled pipelines of earlier runs, one file for each device and driver.
//!
//! The driver trusts what it is given, so a file is checked before: by a checksum of ours, which a torn or damaged file
//! does not have, and by the header that Vulkan prescribes, which names device and driver. Instances that end at the same
//! time each write a file of their own and rename it: one of them stays, whole.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

/// What files of this kind begin with; a checksum of the data, then the data follow.
const MAGIC: &[u8; 16] = b"gridlight pipes1";
/// Bytes of a SHA-256.
const CHECKSUM_BYTES: usize = 32;
/// Bytes of `VkPipelineCacheHeaderVersionOne`.
const HEADER_BYTES: usize = 32;
/// Its version.
const HEADER_VERSION: u32 = 1;

/// Whose pipelines they are, as in the header of the data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Owner {
    pub vendor_id: u32,
    pub device_id: u32,
    /// `pipelineCacheUUID`: another one with every driver that compiles otherwise.
    pub uuid: [u8; 16],
}

impl Owner {
    /// What is wrong with a driver's data, if anything is.
    fn objection(&self, data: &[u8]) -> Option<&'static str> {
        let word = |at: usize| data.get(at..at + 4).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes);
        match (word(0), word(4), word(8), word(12), data.get(16..HEADER_BYTES)) {
            (Some(length), _, _, _, Some(_)) if length as usize != HEADER_BYTES => {
                Some("its header has another length")
            }
            (_, Some(version), _, _, Some(_)) if version != HEADER_VERSION => Some("its header has another version"),
            (_, _, Some(vendor), _, Some(_)) if vendor != self.vendor_id => Some("it is another vendor's"),
            (_, _, _, Some(device), Some(_)) if device != self.device_id => Some("it is another device's"),
            (_, _, _, _, Some(uuid)) if uuid != self.uuid => Some("it is another driver's"),
            (_, _, _, _, Some(_)) => None,
            _ => Some("it has no header"),
        }
    }
}

/// The file of one device and driver.
pub(super) struct PipelineFile {
    path: PathBuf,
    owner: Owner,
}

impl PipelineFile {
    /// In a folder, which need not be there.
    pub fn new(folder: &Path, owner: Owner) -> Self {
        let uuid: String = owner.uuid.iter().map(|byte| format!("{byte:02x}")).collect();
        let name = format!("pipelines-{:04x}-{:04x}-{uuid}.bin", owner.vendor_id, owner.device_id);
        Self { path: folder.join(name), owner }
    }

    /// The driver's data; none when there is no file, or none that can be used.
    pub fn read(&self) -> Vec<u8> {
        let read = match std::fs::read(&self.path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Vec::new(),
            Err(error) => Err(error.to_string()),
            Ok(bytes) => self.unwrap(&bytes).map(<[u8]>::to_vec).map_err(str::to_owned),
        };
        read.unwrap_or_else(|objection| {
            log::info!("{} is not used: {objection}", self.path.display());
            Vec::new()
        })
    }

    fn unwrap<'a>(&self, bytes: &'a [u8]) -> Result<&'a [u8], &'static str> {
        let rest = bytes.strip_prefix(MAGIC.as_slice()).ok_or("it is no file of pipelines")?;
        let (checksum, data) = rest.split_at_checked(CHECKSUM_BYTES).ok_or("it is cut off")?;
        if Sha256::digest(data).as_slice() != checksum {
            return Err("its checksum is wrong");
        }
        self.owner.objection(data).map_or(Ok(data), Err)
    }

    /// Replaces the file. What stands in the way is logged, and no more.
    pub fn write(&self, data: &[u8]) {
        match self.replace(data) {
            Ok(()) => log::debug!("{} bytes of pipelines are kept in {}", data.len(), self.path.display()),
            Err(error) => log::info!("pipelines cannot be kept in {}: {error}", self.path.display()),
        }
    }

    fn replace(&self, data: &[u8]) -> io::Result<()> {
        let folder = self.path.parent().unwrap_or(Path::new("."));
        std::fs::create_dir_all(folder)?;
        let mut file = tempfile::NamedTempFile::new_in(folder)?;
        file.write_all(MAGIC)?;
        file.write_all(Sha256::digest(data).as_slice())?;
        file.write_all(data)?;
        file.persist(&self.path)?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OWNER: Owner = Owner { vendor_id: 0x1002, device_id: 0x73bf, uuid: [7; 16] };

    /// A driver's data for an owner.
    fn data(owner: Owner) -> Vec<u8> {
        let words = [HEADER_BYTES as u32, HEADER_VERSION, owner.vendor_id, owner.device_id];
        let header = words.iter().flat_map(|word| word.to_le_bytes()).chain(owner.uuid);
        header.chain(*b"pipelines").collect()
    }

    #[test]
    fn what_is_written_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let file = PipelineFile::new(&folder.path().join("a/b"), OWNER);
        assert!(file.read().is_empty(), "there is none yet");
        file.write(&data(OWNER));
        assert_eq!(file.read(), data(OWNER));
        assert_eq!(std::fs::read_dir(folder.path().join("a/b")).unwrap().count(), 1, "no temporary file is left");
        file.write(&[data(OWNER), vec![1]].concat());
        assert_eq!(file.read(), [data(OWNER), vec![1]].concat(), "it is replaced");
    }

    #[test]
    fn a_damaged_file_is_not_used_and_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let file = PipelineFile::new(folder.path(), OWNER);
        file.write(&data(OWNER));
        let whole = std::fs::read(&file.path).unwrap();
        let flipped = |at: usize| {
            let mut bytes = whole.clone();
            bytes[at] ^= 1;
            bytes
        };
        let cut = (0..whole.len()).map(|length| whole[..length].to_vec());
        let damaged = cut.chain((0..whole.len()).map(flipped)).chain([vec![0; 4096], b"garbage".to_vec()]);
        for bytes in damaged {
            std::fs::write(&file.path, &bytes).unwrap();
            assert!(file.read().is_empty(), "{bytes:?}");
        }
        file.write(&data(OWNER));
        assert_eq!(file.read(), data(OWNER));
    }

    #[test]
    fn data_of_others_is_not_used() {
        let folder = tempfile::tempdir().unwrap();
        let file = PipelineFile::new(folder.path(), OWNER);
        let mut others = vec![
            data(Owner { vendor_id: 0x10de, ..OWNER }),
            data(Owner { device_id: 1, ..OWNER }),
            data(Owner { uuid: [8; 16], ..OWNER }),
            data(OWNER)[..HEADER_BYTES - 1].to_vec(),
            Vec::new(),
        ];
        for at in [0, 4] {
            let mut other = data(OWNER);
            other[at] += 1;
            others.push(other);
        }
        for other in others {
            // Whole by our checksum, so that the header alone decides.
            file.write(&other);
            assert!(file.read().is_empty(), "{other:?}");
        }
        let named = |owner| PipelineFile::new(folder.path(), owner).path;
        assert_ne!(named(OWNER), named(Owner { uuid: [8; 16], ..OWNER }));
        assert_ne!(named(OWNER), named(Owner { device_id: 1, ..OWNER }));
    }

    #[test]
    fn a_folder_that_cannot_be_is_no_error() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("file"), "").unwrap();
        let file = PipelineFile::new(&folder.path().join("file/folder"), OWNER);
        file.write(&data(OWNER));
        assert!(file.read().is_empty());
    }
}
