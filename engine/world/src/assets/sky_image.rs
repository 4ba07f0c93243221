//! The decoding of images of skies.

use super::AssetError;
use crate::core::MAX_IMAGE_SIZE;
use crate::measure::{check_exr, may_hold};
use image::{ImageDecoder, ImageFormat, ImageReader, Limits};
use std::io::Cursor;
use std::path::Path;

/// Width, height and linear RGB values of an equirectangular image, row by row from the zenith down.
///
/// # Errors
/// If it is of another format or shape, too large, or broken.
pub(super) fn decode(path: &Path, bytes: &[u8]) -> Result<(u32, u32, Vec<f32>), AssetError> {
    let broken = |error: &dyn std::fmt::Display| {
        AssetError::format(path, "sky image", format!("cannot be decoded ({error}): save it again as .hdr or .exr"))
    };
    let fail = |error: image::ImageError| broken(&error);
    let format = match image::guess_format(bytes) {
        Ok(format @ (ImageFormat::Hdr | ImageFormat::OpenExr)) => format,
        _ => {
            let problem = "is neither a Radiance (.hdr) nor an OpenEXR (.exr) image: convert it to one of them";
            return Err(AssetError::format(path, "sky image", problem));
        }
    };
    if format == ImageFormat::OpenExr && cfg!(not(feature = "exr")) {
        let problem = "is an OpenEXR image, which this program was built without: build it with the feature `exr` of \
                       `lightwell-game`, or convert the image to Radiance (.hdr)";
        return Err(AssetError::format(path, "sky image", problem));
    }
    if format == ImageFormat::OpenExr {
        check_exr(bytes).map_err(|error| broken(&error))?;
    }
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(MAX_IMAGE_SIZE), Some(MAX_IMAGE_SIZE));
    limits.max_alloc = Some(u64::from(MAX_IMAGE_SIZE) * u64::from(MAX_IMAGE_SIZE) * 8);
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(fail)?;
    let (width, height) = decoder.dimensions();
    if width == 0 || height == 0 || width > MAX_IMAGE_SIZE || height > MAX_IMAGE_SIZE {
        let problem = format!("has {width}×{height} texels; both must lie between 1 and {MAX_IMAGE_SIZE}: scale it");
        return Err(AssetError::format(path, "sky image", problem));
    }
    if !may_hold(bytes, width.into(), height.into()) {
        let problem = format!("says that it has {width}×{height} texels, more than {} bytes can hold", bytes.len());
        return Err(AssetError::format(path, "sky image", problem));
    }
    if width.abs_diff(2 * height) > 2 {
        let problem = format!("has {width}×{height} texels; an equirectangular image is twice as wide as high");
        return Err(AssetError::format(path, "sky image", problem));
    }
    let pixels = image::DynamicImage::from_decoder(decoder).map_err(fail)?.into_rgb32f();
    Ok((width, height, pixels.into_raw()))
}
