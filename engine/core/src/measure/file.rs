//! Images in files: float EXR for measurements, 8-bit PNG to look at.

use super::Image;
use super::exr_file::{decode_exr, encode_exr};
use crate::core::{replace_file, srgb_decode};
use std::io::Cursor;
use std::path::{Path, PathBuf};

/// Why an image could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum ImageFileError {
    /// The file system refused.
    #[error("{path}: {reason}", path = .path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The error of the system.
        reason: std::io::Error,
    },
    /// The content is not an image that can be read, or could not be encoded.
    #[error("{path}: {message}", path = .path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// The fault.
        message: String,
    },
    /// The file name ends in neither `.exr` nor a format that is known.
    #[error("{path}: unknown picture format; use a name that ends in .exr (linear, float) or .png", path = .path.display())]
    Format {
        /// The file.
        path: PathBuf,
    },
}

fn content_error(path: &Path, message: impl ToString) -> ImageFileError {
    ImageFileError::Content { path: path.to_owned(), message: message.to_string() }
}

fn extension(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default()
}

/// Reads an image as linear RGB: an EXR as it is, a PNG or JPEG decoded from sRGB. Alpha is dropped.
///
/// # Errors
/// If the file cannot be read, is broken, or an EXR has no channels R, G and B.
pub fn read_image(path: &Path) -> Result<Image, ImageFileError> {
    let bytes = std::fs::read(path).map_err(|reason| ImageFileError::Io { path: path.to_owned(), reason })?;
    match extension(path).as_str() {
        "exr" => decode_exr(&bytes).map_err(|e| content_error(path, e)),
        "png" | "jpg" | "jpeg" => {
            decode_srgb(&bytes).map_err(|e| content_error(path, format!("not a readable image: {e}")))
        }
        _ => Err(ImageFileError::Format { path: path.to_owned() }),
    }
}

/// Writes an image by the ending of its name: `.exr` as uncompressed float32 linear RGB, `.png` as 8-bit sRGB of
/// the values clamped to 0..1. Equal images give equal bytes.
///
/// # Errors
/// If the name ends otherwise, or the file cannot be written.
pub fn write_image(path: &Path, image: &Image) -> Result<(), ImageFileError> {
    match extension(path).as_str() {
        "exr" => {
            let bytes = encode_exr(image).map_err(|e| content_error(path, e))?;
            write_bytes(path, &bytes)
        }
        "png" => write_png_rgb8(path, image.size(), &image.to_srgb8()),
        _ => Err(ImageFileError::Format { path: path.to_owned() }),
    }
}

/// Writes bytes that are sRGB-encoded already, three a pixel, as a PNG.
///
/// # Errors
/// If the number of bytes does not fit the size, or the file cannot be written.
pub fn write_png_rgb8(path: &Path, size: [u32; 2], rgb: &[u8]) -> Result<(), ImageFileError> {
    let picture = image::RgbImage::from_raw(size[0], size[1], rgb.to_vec()).ok_or_else(|| {
        content_error(path, format!("{} bytes do not make {}x{} pixels", rgb.len(), size[0], size[1]))
    })?;
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, image::ImageFormat::Png).map_err(|e| content_error(path, e))?;
    write_bytes(path, bytes.get_ref())
}

fn write_bytes(path: &Path, bytes: &[u8]) -> Result<(), ImageFileError> {
    replace_file(path, bytes).map_err(|reason| ImageFileError::Io { path: path.to_owned(), reason })
}

fn decode_srgb(bytes: &[u8]) -> Result<Image, image::ImageError> {
    // Sixteen bits hold every 8-bit value exactly, and keep what a 16-bit file has.
    let picture = image::load_from_memory(bytes)?.into_rgb16();
    let pixels = picture.pixels().map(|p| p.0.map(|v| srgb_decode(f32::from(v) / 65535.0))).collect();
    let (width, height) = picture.dimensions();
    Ok(Image::from_pixels(width, height, pixels).unwrap_or_else(|| Image::filled(width, height, [0.0; 3])))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn gradient() -> Image {
        let pixels = (0..35).map(|i| [i as f32 * 0.37 - 2.0, 1e-6 * i as f32, 1e6 / (i + 1) as f32]).collect();
        Image::from_pixels(7, 5, pixels).unwrap()
    }

    #[test]
    fn exr_keeps_every_bit_and_writes_equal_bytes() {
        let dir = tempfile::tempdir().unwrap();
        let (a, b) = (dir.path().join("a.exr"), dir.path().join("b.exr"));
        write_image(&a, &gradient()).unwrap();
        write_image(&b, &gradient()).unwrap();
        assert_eq!(read_image(&a).unwrap(), gradient());
        assert_eq!(std::fs::read(a).unwrap(), std::fs::read(b).unwrap());
    }

    #[test]
    fn png_keeps_bytes() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.png");
        let bytes: Vec<u8> = (0..=254).collect();
        write_png_rgb8(&path, [17, 5], &bytes).unwrap();
        assert_eq!(read_image(&path).unwrap().to_srgb8(), bytes);
    }

    #[test]
    fn broken_files_are_named() {
        let dir = tempfile::tempdir().unwrap();
        for (name, what) in [("a.exr", "EXR"), ("b.png", "image"), ("c.bmp", "unknown picture format")] {
            let path = dir.path().join(name);
            std::fs::write(&path, b"no picture at all").unwrap();
            let message = read_image(&path).unwrap_err().to_string();
            assert!(message.contains(name) && message.contains(what), "{message}");
        }
        let missing = read_image(&dir.path().join("none.exr")).unwrap_err().to_string();
        assert!(missing.contains("none.exr"), "{missing}");
    }

    #[test]
    fn no_memory_is_taken_for_what_only_the_header_says() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.exr");
        write_image(&path, &gradient()).unwrap();
        let mut bytes = std::fs::read(&path).unwrap();
        let name = b"dataWindow\0box2i\0";
        // The name, the length of the value, and the least x and y; then the greatest.
        let at = bytes.windows(name.len()).position(|part| part == name).unwrap() + name.len() + 12;
        bytes[at..at + 8].copy_from_slice(&[0xff, 0xff, 0xff, 0, 0xff, 0xff, 0xff, 0]);
        std::fs::write(&path, bytes).unwrap();
        let message = read_image(&path).unwrap_err().to_string();
        assert!(message.contains("16777216x16777216 pixels are more than"), "{message}");
    }

    #[test]
    fn truncated_exr_is_an_error() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.exr");
        write_image(&path, &gradient()).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        for length in [0, 4, bytes.len() / 2, bytes.len() - 3] {
            std::fs::write(&path, &bytes[..length]).unwrap();
            assert!(read_image(&path).is_err(), "{length} of {} bytes", bytes.len());
        }
    }
}
