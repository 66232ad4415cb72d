//! Input files as a whole, wherever they come from.

use std::fs::{File, Metadata};
use std::io::{self, Read};
use std::path::Path;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// The most that is read of a pipe, which could be endless.
const MOST_OF_A_PIPE_BYTES: u64 = 4 << 30;
/// How often a read of a pipe asks whether to stop.
const STEP: Duration = Duration::from_millis(50);

/// Opens a file for reading; what is no regular file is refused before it is opened, as a pipe would wait for its writer.
///
/// # Errors
/// Those of the system, and one for a folder, a pipe or a device.
pub fn open_regular(path: &Path) -> io::Result<File> {
    let kind = std::fs::metadata(path)?;
    if kind.is_file() { File::open(path) } else { Err(unsuitable(&kind)) }
}

/// All of a file or of what comes through a pipe. While a pipe keeps it waiting, it stops once `is_stopped` says so.
///
/// # Errors
/// Those of the system, one for a folder or a device, which could be endless, and [`io::ErrorKind::Interrupted`] when it
/// was stopped.
pub fn read_whole(path: &Path, is_stopped: impl Fn() -> bool) -> io::Result<Vec<u8>> {
    let kind = std::fs::metadata(path)?;
    if kind.is_file() {
        return std::fs::read(path);
    }
    if !is_pipe(&kind) {
        return Err(unsuitable(&kind));
    }
    let (sender, receiver) = channel();
    let path = path.to_path_buf();
    // Opening waits for a writer and reading for what it writes, neither of which can be called off: the thread is left
    // behind when nobody waits for it any more.
    std::thread::spawn(move || sender.send(read_pipe(&path)));
    loop {
        match receiver.recv_timeout(STEP) {
            Ok(read) => return read,
            Err(RecvTimeoutError::Timeout) if !is_stopped() => {}
            Err(RecvTimeoutError::Timeout) => return Err(io::ErrorKind::Interrupted.into()),
            Err(RecvTimeoutError::Disconnected) => return Err(io::Error::other("the reader failed")),
        }
    }
}

/// All of a file of text, or of what comes through a pipe.
///
/// # Errors
/// Those of [`read_whole`], and one for what is not UTF-8.
pub fn read_text(path: &Path) -> io::Result<String> {
    let bytes = read_whole(path, || false)?;
    String::from_utf8(bytes).map_err(|_| io::Error::other("it is not text in UTF-8"))
}

fn read_pipe(path: &Path) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(MOST_OF_A_PIPE_BYTES).read_to_end(&mut bytes)?;
    if bytes.len() as u64 == MOST_OF_A_PIPE_BYTES {
        let gib = MOST_OF_A_PIPE_BYTES >> 30;
        return Err(io::Error::other(format!("more than {gib} GiB come through the pipe")));
    }
    Ok(bytes)
}

fn unsuitable(kind: &Metadata) -> io::Error {
    io::Error::other(if kind.is_dir() { "it is a folder" } else { "it is not a regular file" })
}

#[cfg(unix)]
fn is_pipe(kind: &Metadata) -> bool {
    use std::os::unix::fs::FileTypeExt;
    kind.file_type().is_fifo()
}

#[cfg(not(unix))]
fn is_pipe(_: &Metadata) -> bool {
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_read_and_all_else_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        std::fs::write(&path, "all").unwrap();
        assert_eq!(read_whole(&path, || true).unwrap(), b"all");
        assert!(open_regular(&path).is_ok());
        assert_eq!(read_text(&path).unwrap(), "all");
        std::fs::write(&path, [0xff]).unwrap();
        assert!(read_text(&path).unwrap_err().to_string().contains("UTF-8"));
        for error in [read_whole(folder.path(), || false).err(), open_regular(folder.path()).err()] {
            assert_eq!(error.unwrap().to_string(), "it is a folder");
        }
        assert_eq!(read_whole(&folder.path().join("gone"), || false).unwrap_err().kind(), io::ErrorKind::NotFound);
    }

    #[cfg(unix)]
    #[test]
    fn devices_are_not_read() {
        for error in [read_whole(Path::new("/dev/zero"), || false).err(), open_regular(Path::new("/dev/zero")).err()] {
            assert_eq!(error.unwrap().to_string(), "it is not a regular file");
        }
    }
}
