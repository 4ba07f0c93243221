//! KTX2 images in Basis Universal form (`KHR_texture_basisu`), transcoded to eight bits a channel.
//!
//! Layout: Khronos KTX File Format 2.0, section 3. The first level alone is used: mipmaps are made as for all images.

use super::pixels::Pixels;
use super::{AssetError, Meter};
use crate::core::MAX_IMAGE_SIZE;
use basisu::{DecodeFlags, SourceFormat, TargetFormat, Transcoder};
use std::path::Path;

/// First bytes of a file.
const IDENTIFIER: [u8; 12] = *b"\xABKTX 20\xBB\r\n\x1A\n";
/// Bytes of the header before the index of the levels.
const HEADER: usize = 80;
/// Where in it the length of keys and values stands.
const KEYS_LENGTH: std::ops::Range<usize> = 60..64;
/// Bytes of a block of 4 × 4 texels, in either form.
const BLOCK: u64 = 16;

/// Whether the bytes are those of a KTX2 file.
pub(super) fn is_ktx2(bytes: &[u8]) -> bool {
    bytes.starts_with(&IDENTIFIER)
}

/// Decodes the first level.
pub(super) fn decode(path: &Path, place: &str, bytes: &[u8], meter: &Meter) -> Result<Pixels, AssetError> {
    let fail = |problem: String| AssetError::format(path, place, problem);
    let [width, height] = check(bytes).map_err(fail)?;
    meter.texels(path, [width, height])?;
    // Sizes are known to be sound by now. What the transcoder does not expect within the data must not end the program.
    let decoded = std::panic::catch_unwind(|| transcode(bytes));
    let rgba = decoded.unwrap_or_else(|_| Err("its data is corrupt".into())).map_err(fail)?;
    if rgba.len() != width as usize * height as usize * 4 {
        return Err(fail("its data is corrupt".into()));
    }
    Ok(Pixels { width, height, rgba })
}

fn transcode(bytes: &[u8]) -> Result<Vec<u8>, String> {
    let corrupt = |error: basisu::Error| format!("the KTX2 image cannot be decoded: {error:?}");
    // Keys and values say nothing about a flat image, and the transcoder stumbles over those that are not padded.
    let mut bytes = bytes.to_vec();
    bytes[KEYS_LENGTH].fill(0);
    let image = Transcoder::new(&bytes).map_err(corrupt)?;
    if !matches!(image.source_format(), SourceFormat::Etc1s | SourceFormat::UastcLdr) || image.is_video() {
        return Err("is a KTX2 image of a form that KHR_texture_basisu does not allow: use ETC1S or UASTC".into());
    }
    image.transcode(0, TargetFormat::Rgba32, DecodeFlags::NONE).map_err(corrupt)
}

/// Checks all sizes that memory is taken by. Gives width and height.
fn check(bytes: &[u8]) -> Result<[u32; 2], String> {
    let truncated = || format!("is truncated: {} bytes are no KTX2 image", bytes.len());
    let word = |at: usize| bytes.get(at..at + 4).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes);
    let long = |at: usize| bytes.get(at..at + 8).and_then(|b| b.try_into().ok()).map(u64::from_le_bytes);
    let header = |at: usize| word(at).ok_or_else(truncated);
    let [width, height] = [header(20)?, header(24)?];
    if width == 0 || height == 0 || width > MAX_IMAGE_SIZE || height > MAX_IMAGE_SIZE {
        return Err(format!("has {width}×{height} texels; both must lie between 1 and {MAX_IMAGE_SIZE}: scale it"));
    }
    if header(28)? > 1 || header(32)? > 1 || header(36)? != 1 {
        return Err("is a KTX2 file of a volume, an array or a cube, and no flat image".into());
    }
    if header(12)? != 0 {
        return Err("is a KTX2 image in a format of its own; only Basis Universal is read: ETC1S or UASTC".into());
    }
    let levels = header(40)?.max(1);
    // Each level has half the size of the one before.
    if levels > 32 - width.max(height).leading_zeros() {
        return Err(format!("has {levels} levels, which are too many for {width}×{height} texels"));
    }
    for level in 0..levels {
        let entry = HEADER + 24 * level as usize;
        let place = long(entry).zip(long(entry + 8)).zip(long(entry + 16)).ok_or_else(truncated)?;
        let ((offset, length), unpacked) = place;
        if offset.checked_add(length).is_none_or(|end| end > bytes.len() as u64) {
            return Err(format!("level {level} lies beyond the end of the file"));
        }
        let blocks = |size: u32| u64::from((size >> level).max(1).div_ceil(4));
        if unpacked > blocks(width) * blocks(height) * BLOCK {
            return Err(format!("level {level} says that it unpacks to {unpacked} bytes, more than its texels need"));
        }
    }
    Ok([width, height])
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::assets::image;

    const ETC1S: &[u8] = include_bytes!("../../../tests/data/gradient_etc1s.ktx2");
    const UASTC: &[u8] = include_bytes!("../../../tests/data/gradient_uastc.ktx2");
    const PACKED: &[u8] = include_bytes!("../../../tests/data/gradient_uastc_zstd.ktx2");
    const WEBP: &[u8] = include_bytes!("../../../tests/data/gradient.webp");

    /// Red grows to the right and green downwards, blue is a board of squares, and the right half is half transparent.
    fn original() -> Vec<u8> {
        let texel = |i: u32| {
            let (x, y) = (i % 20, i / 20);
            let part = |k: u32, last: u32| (255.0 * k as f32 / last as f32).round() as u8;
            let blue = if (x / 4 + y / 4) % 2 == 1 { 40 } else { 200 };
            [part(x, 19), part(y, 11), blue, if x < 10 { 255 } else { 128 }]
        };
        (0..240).flat_map(texel).collect()
    }

    fn read(bytes: &[u8]) -> Result<Pixels, AssetError> {
        image::decode(Path::new("model.gltf"), "image 0", bytes, &Meter::default())
    }

    #[test]
    fn images_are_those_that_were_packed() {
        // Etc1s gives each block of 4 × 4 texels four shades of one colour; mean and largest difference.
        for (name, bytes, mean, most) in [
            ("ETC1S", ETC1S, 16.0, 90),
            ("UASTC", UASTC, 3.0, 24),
            ("packed UASTC", PACKED, 3.0, 24),
            ("WebP", WEBP, 0.0, 0),
        ] {
            let pixels = read(bytes).unwrap();
            assert_eq!((pixels.width, pixels.height), (20, 12), "{name}");
            let off: Vec<u8> = pixels.rgba.iter().zip(original()).map(|(a, b)| a.abs_diff(b)).collect();
            let found = off.iter().map(|d| f32::from(*d)).sum::<f32>() / off.len() as f32;
            let worst = *off.iter().max().unwrap();
            println!("{name}: {found:.2} of 255 off, {worst} at most");
            assert!(found <= mean && worst <= most, "{name}: {found} of 255 off, {worst} at most");
        }
    }

    #[test]
    fn keys_and_values_do_not_matter() {
        for length in [7_u32, 9, u32::MAX] {
            let mut bytes = UASTC.to_vec();
            bytes[KEYS_LENGTH].copy_from_slice(&length.to_le_bytes());
            assert_eq!(read(&bytes).unwrap().rgba, read(UASTC).unwrap().rgba);
        }
    }

    #[test]
    fn broken_images_are_errors_before_memory_is_taken() {
        let with = |at: usize, word: &[u8]| {
            let mut bytes = PACKED.to_vec();
            bytes[at..at + word.len()].copy_from_slice(word);
            bytes
        };
        for (bytes, words) in [
            (PACKED[..60].to_vec(), "truncated"),
            (PACKED[..PACKED.len() - 9].to_vec(), "beyond the end"),
            (with(20, &70_000u32.to_le_bytes()), "70000×12"),
            (with(24, &0u32.to_le_bytes()), "20×0"),
            (with(12, &37u32.to_le_bytes()), "Basis Universal"),
            (with(36, &6u32.to_le_bytes()), "no flat image"),
            (with(40, &9u32.to_le_bytes()), "9 levels"),
            (with(96, &u64::MAX.to_le_bytes()), "more than its texels need"),
            (with(88, &u64::MAX.to_le_bytes()), "beyond the end"),
            (with(190, &[0xff; 24]), "cannot be decoded"),
        ] {
            let message = read(&bytes).unwrap_err().to_string();
            assert!(message.contains(words) && message.contains("image 0"), "{words}: {message}");
        }
    }

    #[test]
    fn images_broken_at_random_do_no_harm() {
        let mut state = 7_u64;
        let mut random = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as usize
        };
        let mut good = 0;
        for image in [ETC1S, UASTC, PACKED] {
            for _ in 0..1500 {
                let mut bytes = image.to_vec();
                for _ in 0..1 + random() % 3 {
                    let at = random() % bytes.len();
                    bytes[at] = random() as u8;
                }
                good += u32::from(read(&bytes).is_ok_and(|p| p.rgba.len() == 4 * (p.width * p.height) as usize));
            }
        }
        assert!(good > 100, "hardly any was read: {good}");
    }
}
