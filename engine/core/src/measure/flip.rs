//! FLIP, the perceptual difference of Andersson et al. 2020, on tone-mapped images.

use super::Image;
#[cfg(feature = "flip")]
use crate::core::srgb_encode;

/// Luminance that the mean of the reference is exposed to: photographic middle grey.
const MIDDLE_GREY: f64 = 0.18;

/// Rec. 709 luminance weights.
const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// FLIP errors of all pixels.
#[cfg(feature = "flip")]
#[derive(Clone, Debug, PartialEq)]
pub struct FlipMap {
    /// Width and height \[pixels\].
    pub size: [u32; 2],
    /// Error of each pixel, 0..1, row by row from the top left.
    pub errors: Vec<f32>,
}

#[cfg(feature = "flip")]
impl FlipMap {
    /// Mean over all pixels, the one number that the authors recommend.
    pub fn mean(&self) -> f64 {
        self.errors.iter().map(|&e| f64::from(e)).sum::<f64>() / self.errors.len().max(1) as f64
    }

    /// The error that a share of the pixels does not exceed (nearest rank).
    pub fn percentile(&self, share: f64) -> f64 {
        let mut sorted = self.errors.clone();
        sorted.sort_unstable_by(f32::total_cmp);
        let rank = (share * sorted.len() as f64).ceil() as usize;
        sorted.get(rank.saturating_sub(1)).copied().map_or(0.0, f64::from)
    }
}

/// Factor by which images are exposed before the comparison: it brings the mean luminance of the reference to 0.18.
/// One where the reference is black.
pub fn flip_exposure(reference: &Image) -> f64 {
    let count = reference.pixels().len().max(1) as f64;
    let luminance = |p: &[f32; 3]| p.iter().zip(LUMINANCE).map(|(&v, w)| f64::from(v.max(0.0)) * w).sum::<f64>();
    let mean = reference.pixels().iter().map(luminance).sum::<f64>() / count;
    if mean > 0.0 { MIDDLE_GREY / mean } else { 1.0 }
}

/// FLIP of `image` against `reference`, both exposed by [`flip_exposure`] of the reference, tone mapped by
/// c / (1 + c) per channel, encoded in sRGB and rounded to 8 bits.
///
/// # Panics
/// If the sizes differ or there are no pixels; [`super::compare`] checks that before.
#[cfg(feature = "flip")]
pub fn flip(image: &Image, reference: &Image) -> FlipMap {
    let exposure = flip_exposure(reference);
    flip_with(image, reference, |picture| display_bytes(picture, exposure))
}

/// FLIP of `image` against `reference` where both are what a screen shows already: linear light of 0..1, encoded in sRGB
/// and rounded to 8 bits.
///
/// # Panics
/// Those of [`flip`].
#[cfg(feature = "flip")]
pub fn flip_displayed(image: &Image, reference: &Image) -> FlipMap {
    flip_with(image, reference, Image::to_srgb8)
}

#[cfg(feature = "flip")]
fn flip_with(image: &Image, reference: &Image, bytes: impl Fn(&Image) -> Vec<u8>) -> FlipMap {
    assert_eq!(image.size(), reference.size(), "FLIP needs images of one size");
    assert!(!reference.pixels().is_empty(), "FLIP needs pixels");
    let [width, height] = image.size();
    let displayed = |picture: &Image| nv_flip::FlipImageRgb8::with_data(width, height, &bytes(picture));
    let map = nv_flip::flip(displayed(reference), displayed(image), nv_flip::DEFAULT_PIXELS_PER_DEGREE);
    FlipMap { size: [width, height], errors: map.to_vec() }
}

#[cfg(feature = "flip")]
fn display_bytes(image: &Image, exposure: f64) -> Vec<u8> {
    image.values().map(|value| (srgb_encode(display_value(value, exposure)) * 255.0).round() as u8).collect()
}

/// A value exposed and tone mapped by c / (1 + c): 0..1, linear.
pub(super) fn display_value(value: f32, exposure: f64) -> f32 {
    let exposed = (f64::from(value) * exposure).max(0.0);
    // Huge values would be infinity over infinity.
    let mapped = if exposed < 1e12 { exposed / (1.0 + exposed) } else { 1.0 };
    mapped as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exposure_brings_the_reference_to_middle_grey() {
        let reference = Image::filled(3, 3, [2.0; 3]);
        assert!((flip_exposure(&reference) - 0.09).abs() < 1e-12);
        assert_eq!(flip_exposure(&Image::filled(3, 3, [0.0; 3])), 1.0);
    }

    #[test]
    fn percentiles_see_what_the_mean_hides() {
        let mut errors = vec![0.0; 1000];
        errors[..11].fill(0.8);
        let map = FlipMap { size: [100, 10], errors };
        assert!(map.mean() < 0.01);
        assert_eq!(
            [map.percentile(0.98), map.percentile(0.99), map.percentile(1.0)],
            [0.0, f64::from(0.8_f32), f64::from(0.8_f32)]
        );
    }

    #[test]
    fn flip_orders_errors_as_an_eye_does() {
        let reference = Image::filled(32, 32, [1.0; 3]);
        let near = flip(&Image::filled(32, 32, [1.1; 3]), &reference).mean();
        let far = flip(&Image::filled(32, 32, [2.0; 3]), &reference).mean();
        let other_hue = flip(&Image::filled(32, 32, [2.0, 0.2, 0.2]), &reference).mean();
        assert!(0.0 < near && near < far && far < other_hue && other_hue <= 1.0, "{near} {far} {other_hue}");
    }

    #[test]
    fn displayed_images_are_not_exposed_again() {
        let [dark, darker] = [0.01, 0.008].map(|value| Image::filled(32, 32, [value; 3]));
        let shown = flip_displayed(&darker, &dark).mean();
        assert!(0.0 < shown && shown < 0.5 * flip(&darker, &dark).mean(), "{shown}");
        assert_eq!(flip_displayed(&dark, &dark).mean(), 0.0);
    }

    #[test]
    fn extreme_values_stay_in_range() {
        let reference = Image::filled(8, 8, [1e-30; 3]);
        let mean = flip(&Image::filled(8, 8, [1e30, 0.0, -5.0]), &reference).mean();
        assert!((0.0..=1.0).contains(&mean), "{mean}");
    }
}
