//! Changes a file in the way that gets furthest into its reader.

use gridlight::scene::testing::glb_from;

use super::random::Random;
use super::seeds::Seed;
use super::targets::Shape;
use super::{bytes, json};

/// The file with some changes.
pub fn changed((name, whole): &Seed, shape: Shape, random: &mut Random) -> Seed {
    let mut all = whole.clone();
    let extension = name.rsplit('.').next().unwrap_or_default();
    // Now and then what no structure survives.
    let any = random.one_in(6);
    match extension {
        _ if any => bytes::change(&mut all, random),
        "json" | "gltf" => all = changed_json(&all, random).into_bytes(),
        "glb" => all = changed_glb(&all, random),
        "png" => change_png(&mut all, random),
        _ if shape == Shape::Text => bytes::change_text(&mut all, random),
        _ => bytes::change(&mut all, random),
    }
    (name.clone(), all)
}

fn changed_json(text: &[u8], random: &mut Random) -> String {
    json::changed(serde_json::from_slice(text).expect("seeds are JSON"), random)
}

/// The JSON of a GLB changed, or the bytes of its buffer.
fn changed_glb(glb: &[u8], random: &mut Random) -> Vec<u8> {
    let size = u32::from_le_bytes([glb[12], glb[13], glb[14], glb[15]]) as usize;
    let text = &glb[20..20 + size];
    let mut bin = glb.get(28 + size..).unwrap_or_default().to_vec();
    if random.one_in(4) {
        bytes::change(&mut bin, random);
        return glb_from(&String::from_utf8_lossy(text), &bin);
    }
    glb_from(&changed_json(text, random), &bin)
}

/// Changes bytes and mends the checksums of the chunks, which hide all else.
fn change_png(bytes: &mut Vec<u8>, random: &mut Random) {
    bytes::change(bytes, random);
    let mut at = 8;
    while let Some(size) = bytes.get(at..at + 4).map(|s| u32::from_be_bytes([s[0], s[1], s[2], s[3]]) as usize) {
        let Some(end) = at.checked_add(8 + size).filter(|end| end + 4 <= bytes.len()) else { break };
        let sum = crc32(&bytes[at + 4..end]).to_be_bytes();
        bytes[end..end + 4].copy_from_slice(&sum);
        at = end + 4;
    }
}

/// The checksum of PNG.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |sum, byte| {
        (0..8).fold(sum ^ u32::from(*byte), |sum, _| (sum >> 1) ^ (0xedb8_8320 * (sum & 1)))
    })
}
