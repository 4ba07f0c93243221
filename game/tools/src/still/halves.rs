//! Two independent halves of an average, and what their difference tells of its error.

use anyhow::{Context, Result};
use lightwell::measure::{Image, flip_displayed};

/// Share of the pixels that the second figure of an estimate bounds.
const MOST_PIXELS: f64 = 0.99;

/// Estimated error of an average, as FLIP, 0..1, against the limit of ever more images.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Mean over all pixels.
    pub mean: f64,
    /// The 99th percentile of the pixels.
    pub most: f64,
}

/// Sums of displayed images, in linear light, by halves.
pub struct Halves {
    size: [u32; 2],
    sums: [Vec<f64>; 2],
    pairs: u32,
}

impl Halves {
    /// Of no images yet.
    pub fn new(size: [u32; 2]) -> Self {
        Self { size, sums: [Vec::new(), Vec::new()], pairs: 0 }
    }

    /// Adds an image to each half.
    pub fn add(&mut self, images: &[Image; 2]) {
        for (sum, image) in self.sums.iter_mut().zip(images) {
            // Only now is it known that the device can draw so large an image.
            sum.resize(3 * image.pixels().len(), 0.0);
            sum.iter_mut().zip(image.values()).for_each(|(sum, value)| *sum += f64::from(value));
        }
        self.pairs += 1;
    }

    /// How many images there are in both halves together.
    pub fn images(&self) -> u32 {
        2 * self.pairs
    }

    /// The mean of all images: linear light of 0..1.
    ///
    /// # Errors
    /// If the images had other sizes.
    pub fn mean(&self) -> Result<Image> {
        let [first, second] = &self.sums;
        self.image(first.iter().zip(second).map(|(a, b)| 0.5 * (a + b)))
    }

    /// Estimates the error of the mean.
    ///
    /// The means a and b of the halves have independent errors of one distribution, with covariance C over the pixels.
    /// The error of their mean m = (a + b)/2 has covariance C/2, and so has a − m = (a − b)/2: from m to a half it is as
    /// far as from m to what m converges to. So FLIP between those two, whose filters see the same patterns of noise in
    /// both, stands for FLIP against the converged image. FLIP is no linear measure: half the distance from a to b, taken
    /// as half of its FLIP, would be too small, for FLIP grows about as the distance to the power 0.7.
    ///
    /// It leaves out errors that all images have in common, such as the blur of a filter in each of them.
    ///
    /// # Errors
    /// As [`Halves::mean`].
    pub fn estimate(&self) -> Result<Estimate> {
        let half = self.image(self.sums[0].iter().copied())?;
        let map = flip_displayed(&half, &self.mean()?);
        Ok(Estimate { mean: map.mean(), most: map.percentile(MOST_PIXELS) })
    }

    fn image(&self, sums: impl Iterator<Item = f64>) -> Result<Image> {
        let count = f64::from(self.pairs.max(1));
        let values: Vec<f32> = sums.map(|sum| (sum / count) as f32).collect();
        Image::from_pixels(self.size[0], self.size[1], values.as_chunks().0.to_vec()).context("the image is incomplete")
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// Noise of a pixel of an image, in −1..1.
    fn noise(image: u32, index: usize) -> f32 {
        let mixed =
            (image.wrapping_mul(0x9e37_79b9) ^ (index as u32).wrapping_mul(0x85eb_ca6b)).wrapping_mul(0xc2b2_ae35);
        let mixed = (mixed ^ mixed >> 15).wrapping_mul(0x2c1b_3c6d);
        ((mixed ^ mixed >> 13) >> 8) as f32 / (1 << 23) as f32 - 1.0
    }

    fn noisy(image: u32) -> Image {
        let truth = |index: usize| 0.1 + 0.4 * (index % 48) as f32 / 48.0;
        let pixels = (0..48 * 32).map(|index| [truth(index) * (1.0 + 0.6 * noise(image, index)); 3]).collect();
        Image::from_pixels(48, 32, pixels).unwrap()
    }

    #[test]
    fn the_estimate_is_the_distance_to_the_converged_image() {
        let truth = Image::from_pixels(48, 32, (0..48 * 32).map(|i| [0.1 + 0.4 * (i % 48) as f32 / 48.0; 3]).collect());
        let truth = truth.unwrap();
        let mut halves = Halves::new([48, 32]);
        let mut last = f64::INFINITY;
        for pair in 0..32 {
            halves.add(&[noisy(2 * pair), noisy(2 * pair + 1)]);
            if !halves.pairs.is_power_of_two() {
                continue;
            }
            let estimate = halves.estimate().unwrap();
            let error = flip_displayed(&halves.mean().unwrap(), &truth);
            assert!((0.9..1.1).contains(&(error.mean() / estimate.mean)), "{} {estimate:?}", error.mean());
            assert!((0.8..1.25).contains(&(error.percentile(0.99) / estimate.most)), "{estimate:?}");
            assert!(estimate.mean < last && estimate.most > estimate.mean);
            last = estimate.mean;
        }
        assert_eq!(halves.images(), 64);
    }

    #[test]
    fn images_that_do_not_vary_have_no_error() {
        let mut halves = Halves::new([48, 32]);
        halves.add(&[noisy(0), noisy(0)]);
        assert_eq!(halves.estimate().unwrap(), Estimate { mean: 0.0, most: 0.0 });
        assert_eq!(halves.mean().unwrap(), noisy(0));
    }
}
