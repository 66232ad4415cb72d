//! Changes of files of which only the bytes are known, and of text by lines and words.

use super::random::Random;

/// Words at the edges of what fits.
const WORDS: [u64; 12] =
    [0, 1, 0x7f, 0xff, 0x7fff, 0xffff, 0x7fff_ffff, 0x8000_0000, 0xffff_ffff, 0x7f80_0000, 0x7fc0_0000, u64::MAX];

/// Longest that a changed file may become.
const LONGEST: usize = 1 << 20;

/// Changes bytes here and there.
pub fn change(bytes: &mut Vec<u8>, random: &mut Random) {
    for _ in 0..=random.below(3) {
        change_once(bytes, random);
    }
}

fn change_once(bytes: &mut Vec<u8>, random: &mut Random) {
    let at = random.below(bytes.len());
    match random.below(9) {
        0 if !bytes.is_empty() => bytes[at] ^= 1 << random.below(8),
        1 if !bytes.is_empty() => bytes[at] = random.next() as u8,
        2 | 3 => {
            // A word of any size, in either order of bytes.
            let size = 1 << random.below(4);
            let word = random.pick(&WORDS).wrapping_add(random.below(3) as u64).wrapping_sub(1);
            let little = word.to_le_bytes();
            let mut word = little[..size].to_vec();
            if random.one_in(2) {
                word.reverse();
            }
            let end = (at + size).min(bytes.len());
            bytes.splice(at..end, word);
        }
        4 => bytes.truncate(at),
        5 => {
            let end = at + random.below(1 + (bytes.len() - at).min(64));
            bytes.drain(at..end);
        }
        6 => {
            let end = at + random.below(1 + bytes.len() - at);
            let copy = bytes[at..end].to_vec();
            let place = random.below(bytes.len() + 1);
            bytes.splice(place..place, copy);
        }
        7 => {
            let length = random.below(16);
            let new: Vec<u8> = (0..length).map(|_| random.next() as u8).collect();
            bytes.splice(at..at, new);
        }
        // Digits become other digits, so that what is written as text stays text.
        _ => {
            if let Some(digit) = bytes[at..].iter_mut().find(|byte| byte.is_ascii_digit()) {
                *digit = b'0' + random.below(10) as u8;
            }
        }
    }
    bytes.truncate(LONGEST);
}

/// Words that text may have in the place of others.
const TOKENS: [&str; 27] = [
    "",
    "0",
    "-1",
    "1",
    "4294967295",
    "18446744073709551616",
    "1e39",
    "-1e999",
    "nan",
    "inf",
    "0.5",
    "true",
    "null",
    "\"\"",
    "\"auto\"",
    "[]",
    "{}",
    "=",
    "at",
    "#",
    "{frame}",
    "é",
    "\u{0}",
    "\u{feff}",
    "0x10",
    "640x480",
    "'''",
];

/// Changes lines and words of a text, or its bytes.
pub fn change_text(bytes: &mut Vec<u8>, random: &mut Random) {
    if random.one_in(4) {
        return change(bytes, random);
    }
    let text = String::from_utf8_lossy(bytes).into_owned();
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    for _ in 0..=random.below(3) {
        let (at, other) = (random.below(lines.len()), random.below(lines.len()));
        match random.below(6) {
            0 if !lines.is_empty() => drop(lines.remove(at)),
            1 if !lines.is_empty() => lines.insert(other, lines[at].clone()),
            2 if !lines.is_empty() => lines.swap(at, other),
            _ if !lines.is_empty() => lines[at] = with_another_word(&lines[at], random),
            _ => {}
        }
    }
    *bytes = lines.join(random.word(&["\n", "\r\n", "\r"])).into_bytes();
}

fn with_another_word(line: &str, random: &mut Random) -> String {
    let mut words: Vec<&str> = line.split(' ').collect();
    let at = random.below(words.len());
    let long;
    words[at] = if random.one_in(20) {
        long = "x".repeat(100_000);
        &long
    } else {
        random.word(&TOKENS)
    };
    words.join(" ")
}
