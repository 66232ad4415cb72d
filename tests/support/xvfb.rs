//! A virtual display, and what it shows.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};

use tempfile::TempDir;

/// An X server without a screen; ends when dropped.
pub struct Xvfb {
    server: Child,
    number: String,
    folder: TempDir,
}

impl Xvfb {
    /// Starts a server with a screen of this size, `None` where there is none to start.
    pub fn start(width: u32, height: u32) -> Option<Self> {
        let folder = tempfile::tempdir().ok()?;
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-nolisten", "tcp", "-screen", "0", &format!("{width}x{height}x24")])
            .arg("-fbdir")
            .arg(folder.path())
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .ok()?;
        let mut number = String::new();
        BufReader::new(server.stdout.take()?).read_line(&mut number).ok()?;
        let number = number.trim().to_owned();
        assert!(!number.is_empty(), "Xvfb ended at once");
        Some(Self { server, number, folder })
    }

    /// Lets a program open its windows here.
    pub fn show<'a>(&self, command: &'a mut Command) -> &'a mut Command {
        command.env("DISPLAY", format!(":{}", self.number)).env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET")
    }

    /// What the top left corner of the screen shows, RGB.
    pub fn corner(&self, width: usize, height: usize) -> Vec<u8> {
        let file = std::fs::read(self.folder.path().join("Xvfb_screen0")).expect("the server's framebuffer");
        // An XWD file: big-endian words, a table of colours, rows of blue, green, red and nothing.
        let word = |index: usize| u32::from_be_bytes(file[4 * index..4 * index + 4].try_into().unwrap()) as usize;
        let (header_bytes, bytes_per_row, colors) = (word(0), word(12), word(19));
        assert_eq!((word(7), word(11)), (0, 32), "little-endian pixels of 32 bits");
        let start = header_bytes + 12 * colors;
        let row = |y: usize| &file[start + y * bytes_per_row..start + y * bytes_per_row + 4 * width];
        (0..height).flat_map(|y| row(y).chunks_exact(4).flat_map(|p| [p[2], p[1], p[0]])).collect()
    }
}

impl Drop for Xvfb {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}
