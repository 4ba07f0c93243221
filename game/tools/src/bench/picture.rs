//! Images for the report: method, reference and difference side by side; rows of a sweep.

use super::plot;
use anyhow::{Context, Result};
use lightwell::measure::{self, Image, difference_picture, flip_exposure, srgb_encode};
use std::path::Path;

/// Edge that small images are enlarged to, in whole factors [pixels].
const LEAST_EDGE: u32 = 256;
/// Space between images and around them [pixels].
const GAP: u32 = 8;
/// Height of a line of text [pixels].
const LINE: u32 = 24;
const PAPER: u8 = 255;

/// An image of 8-bit sRGB.
pub struct Canvas {
    size: [u32; 2],
    rgb: Vec<u8>,
}

impl Canvas {
    /// An empty one.
    pub fn new(size: [u32; 2]) -> Self {
        Self { size, rgb: vec![PAPER; 3 * size[0] as usize * size[1] as usize] }
    }

    /// Copies an image of sRGB bytes, each pixel `factor` wide and high.
    pub fn paste(&mut self, at: [u32; 2], size: [u32; 2], rgb: &[u8], factor: u32) {
        for y in 0..size[1] * factor {
            for x in 0..size[0] * factor {
                let (to_x, to_y) = (at[0] + x, at[1] + y);
                if to_x < self.size[0] && to_y < self.size[1] {
                    let from = 3 * ((y / factor) * size[0] + x / factor) as usize;
                    let to = 3 * (to_y * self.size[0] + to_x) as usize;
                    self.rgb[to..to + 3].copy_from_slice(&rgb[from..from + 3]);
                }
            }
        }
    }

    /// Writes a line of text with its upper left corner there.
    ///
    /// # Errors
    /// If the text cannot be drawn.
    pub fn text(&mut self, at: [u32; 2], text: &str) -> Result<()> {
        plot::text(&mut self.rgb, self.size, [at[0] as i32, at[1] as i32], text)
    }

    /// Writes the image as a PNG, making its folder.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn save(&self, path: &Path) -> Result<()> {
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
        }
        Ok(measure::write_png_rgb8(path, self.size, &self.rgb)?)
    }
}

/// Radiance as the report shows it: exposed by the reference, tone mapped by c / (1 + c), in sRGB.
pub fn displayed(image: &Image, exposure: f64) -> Vec<u8> {
    let display = |value: f32| {
        let exposed = (f64::from(value) * exposure).clamp(0.0, 1e12);
        (srgb_encode((exposed / (1.0 + exposed)) as f32) * 255.0).round() as u8
    };
    image.values().map(display).collect()
}

/// Exposure that shows an image well beside others of the same reference: four times what FLIP takes, for the eye.
pub fn exposure(reference: &Image) -> f64 {
    4.0 * flip_exposure(reference)
}

/// Writes an image, its reference and their difference side by side, as in the thesis's figures 7.2 to 7.7.
///
/// # Errors
/// If the images differ in size, hold NaN, or the file cannot be written.
pub fn three(path: &Path, image: &Image, reference: &Image, title: &str, caption: &str) -> Result<()> {
    let exposure = exposure(reference);
    let size = reference.size();
    let factor = LEAST_EDGE.div_ceil(size[0].max(1)).max(1);
    let [width, height] = size.map(|edge| edge * factor);
    let mut canvas = Canvas::new([3 * width + 4 * GAP, height + 2 * LINE + 2 * GAP]);
    canvas.text([GAP, GAP], title)?;
    let difference = difference_picture(image, reference)?.to_srgb8();
    let parts = [
        (displayed(image, exposure), caption),
        (displayed(reference, exposure), "reference"),
        (difference, "difference: red too bright, blue too dark"),
    ];
    for (index, (rgb, text)) in (0u32..).zip(parts) {
        let x = GAP + index * (width + GAP);
        canvas.paste([x, GAP + LINE], size, &rgb, factor);
        canvas.text([x, GAP + LINE + height + 4], text)?;
    }
    canvas.save(path)
}

/// Writes a row of images, each with its caption below.
///
/// # Errors
/// If the file cannot be written.
pub fn row(path: &Path, title: &str, images: &[(Image, String)], exposure: f64) -> Result<()> {
    let Some(size) = images.first().map(|(image, _)| image.size()) else { return Ok(()) };
    let factor = (LEAST_EDGE / 2).div_ceil(size[0].max(1)).max(1);
    let [width, height] = size.map(|edge| edge * factor);
    let count = images.len() as u32;
    let mut canvas = Canvas::new([count * (width + GAP) + GAP, height + 2 * LINE + 2 * GAP]);
    canvas.text([GAP, GAP], title)?;
    for (index, (image, caption)) in (0u32..).zip(images) {
        let x = GAP + index * (width + GAP);
        canvas.paste([x, GAP + LINE], image.size(), &displayed(image, exposure), factor);
        canvas.text([x, GAP + LINE + height + 4], caption)?;
    }
    canvas.save(path)
}

/// A name that every file system takes.
pub fn file_name(text: &str) -> String {
    let mut name: String =
        text.chars().map(|c| if c.is_ascii_alphanumeric() || "-.".contains(c) { c } else { '_' }).collect();
    while name.contains("__") {
        name = name.replace("__", "_");
    }
    name
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn names_of_files() {
        assert_eq!(file_name("cornell: 16×16 cells, 2"), "cornell_16_16_cells_2");
    }

    #[test]
    fn three_pictures_in_one() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("sub/three.png");
        let image = |value: f32| Image::filled(64, 32, [value; 3]);
        three(&path, &image(1.5), &image(1.0), "title", "caption").unwrap();
        let picture = measure::read_image(&path).unwrap();
        assert_eq!(picture.size(), [3 * 256 + 4 * GAP, 128 + 2 * LINE + 2 * GAP]);
        let at = |index: u32| picture.pixel(GAP + index * (256 + GAP) + 100, GAP + LINE + 60);
        assert!(at(0)[0] > at(1)[0], "the image is brighter than its reference");
        assert!(at(2)[0] > 2.0 * at(2)[2], "and the difference is red: {:?}", at(2));
    }
}
