//! Image files decoded to eight bits a channel.

use super::pixels::Pixels;
use super::{AssetError, Meter, ktx2};
use crate::core::MAX_IMAGE_SIZE;
use image::{ImageDecoder, ImageReader, Limits};
use std::io::Cursor;
use std::path::Path;

/// Decodes PNG, JPEG, WebP or KTX2 by content, whatever the file's name says. Sixteen bits a channel are rounded to eight, grey
/// becomes RGB, and alpha is 1 where there is none.
pub(super) fn decode(path: &Path, place: &str, bytes: &[u8], meter: &Meter) -> Result<Pixels, AssetError> {
    if ktx2::is_ktx2(bytes) {
        return ktx2::decode(path, place, bytes, meter);
    }
    let fail = |e: image::ImageError| AssetError::format(path, place, format!("the image cannot be decoded: {e}"));
    if bytes.is_empty() {
        return Err(AssetError::format(path, place, "is empty: export the image again"));
    }
    let format = image::guess_format(bytes).map_err(|_| {
        AssetError::format(path, place, "is neither PNG, JPEG, WebP nor KTX2: convert the image to one of them")
    })?;
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_IMAGE_SIZE);
    limits.max_image_height = Some(MAX_IMAGE_SIZE);
    limits.max_alloc = Some(u64::from(MAX_IMAGE_SIZE) * u64::from(MAX_IMAGE_SIZE) * 8);
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(fail)?;
    let (width, height) = decoder.dimensions();
    if width == 0 || height == 0 || width > MAX_IMAGE_SIZE || height > MAX_IMAGE_SIZE {
        let problem = format!("has {width}×{height} texels; both must lie between 1 and {MAX_IMAGE_SIZE}: scale it");
        return Err(AssetError::format(path, place, problem));
    }
    meter.texels(path, [width, height])?;
    let rgba = image::DynamicImage::from_decoder(decoder).map_err(fail)?.into_rgba8();
    Ok(Pixels { width, height, rgba: rgba.into_raw() })
}
