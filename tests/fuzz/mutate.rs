//! Mutations of bytes and texts.

use fastrand::Rng;

/// Words that change what a text means.
const WORDS: [&str; 36] = [
    "0",
    "-1",
    "1e38",
    "-1e-45",
    "NaN",
    "inf",
    "4294967295",
    "4294967296",
    "18446744073709551615",
    "true",
    "()",
    "[]",
    "{}",
    "((((",
    "))))",
    "\"",
    "\\",
    "\"\"",
    ",",
    ":",
    "/*",
    "//",
    "\u{0}",
    "\u{feff}",
    "\u{1F600}",
    "Some(None)",
    "..",
    "../../..",
    "#import",
    "#ifdef X",
    "#{X}",
    "@group(9999)",
    "array<f32>",
    "null",
    "data:,",
    "%00",
];

/// One of the inputs with one to four mutations.
pub fn mutated(random: &mut Rng, seeds: &[Vec<u8>]) -> Vec<u8> {
    let mut input = seeds[random.usize(..seeds.len())].clone();
    for _ in 0..random.usize(1..5) {
        mutate(random, &mut input, seeds);
    }
    input
}

fn mutate(random: &mut Rng, input: &mut Vec<u8>, seeds: &[Vec<u8>]) {
    let length = input.len();
    if length == 0 {
        input.extend(WORDS[random.usize(..WORDS.len())].bytes());
        return;
    }
    let at = random.usize(..length);
    let end = (at + 1 + random.usize(..32)).min(length);
    match random.u8(..8) {
        0 => input[at] ^= 1 << random.u8(..8),
        1 => input[at] = random.u8(..),
        2 => drop(input.drain(at..end)),
        3 => {
            let copy = input[at..end].to_vec();
            input.splice(at..at, copy);
        }
        4 => drop(input.splice(at..at, WORDS[random.usize(..WORDS.len())].bytes())),
        5 => replace_number(random, input, at),
        6 => input.truncate(at),
        _ => {
            let other = &seeds[random.usize(..seeds.len())];
            let from = random.usize(..other.len().max(1)).min(other.len());
            let until = (from + random.usize(..256)).min(other.len());
            input.splice(at..end, other[from..until].iter().copied());
        }
    }
}

/// Another number for the next one in a text; in bytes, four that are a large or a small number.
fn replace_number(random: &mut Rng, input: &mut Vec<u8>, at: usize) {
    let is_number = |byte: &u8| byte.is_ascii_digit() || matches!(byte, b'.' | b'-' | b'+' | b'e');
    if input.is_ascii() {
        let Some(start) = input[at..].iter().position(u8::is_ascii_digit).map(|from| at + from) else { return };
        let end = input[start..].iter().position(|byte| !is_number(byte)).map_or(input.len(), |to| start + to);
        input.splice(start..end, WORDS[random.usize(..10)].bytes());
    } else if at + 4 <= input.len() {
        let value = [0, 1, u32::MAX, 1 << 31, 1 << 20, u32::MAX - 3][random.usize(..6)];
        input[at..at + 4].copy_from_slice(&value.to_le_bytes());
    }
}

/// Gives the chunks of a PNG file the checksums of what they hold now, so that more than the checksums is tried.
pub fn repair_checksums(png: &mut [u8]) {
    let mut at = 8;
    while let Some(length) = png.get(at..at + 4).map(|b| u32::from_be_bytes([b[0], b[1], b[2], b[3]]) as usize) {
        let Some(end) = at.checked_add(8).and_then(|start| start.checked_add(length)) else { return };
        let Some(content) = png.get(at + 4..end) else { return };
        let sum = crc32(content);
        let Some(place) = png.get_mut(end..end + 4) else { return };
        place.copy_from_slice(&sum.to_be_bytes());
        at = end + 4;
    }
}

/// The checksum of PNG (ISO 3309).
fn crc32(bytes: &[u8]) -> u32 {
    let of_bit = |sum: u32| if sum & 1 == 1 { sum >> 1 ^ 0xEDB8_8320 } else { sum >> 1 };
    let of_byte = |sum: u32, byte: &u8| (0..8).fold(sum ^ u32::from(*byte), |sum, _| of_bit(sum));
    !bytes.iter().fold(!0, of_byte)
}
