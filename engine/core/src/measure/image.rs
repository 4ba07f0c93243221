//! The image type of all measurements.

use crate::core::srgb_encode;

/// An image of linear Rec. 709 RGB in single precision, row by row from the top left.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    width: u32,
    height: u32,
    pixels: Vec<[f32; 3]>,
}

impl Image {
    /// An image whose every pixel is `color`.
    pub fn filled(width: u32, height: u32, color: [f32; 3]) -> Self {
        Self { width, height, pixels: vec![color; width as usize * height as usize] }
    }

    /// An image from its pixels; `None` if their number is not `width`·`height`.
    pub fn from_pixels(width: u32, height: u32, pixels: Vec<[f32; 3]>) -> Option<Self> {
        (pixels.len() == width as usize * height as usize).then_some(Self { width, height, pixels })
    }

    /// An image from RGBA pixels, whose alpha is dropped; `None` if their number does not fit.
    pub fn from_rgba(width: u32, height: u32, pixels: &[[f32; 4]]) -> Option<Self> {
        Self::from_pixels(width, height, pixels.iter().map(|&[r, g, b, _]| [r, g, b]).collect())
    }

    /// Width and height \[pixels\].
    pub fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// Pixels, row by row from the top left.
    pub fn pixels(&self) -> &[[f32; 3]] {
        &self.pixels
    }

    /// Pixels, to be changed in place.
    pub fn pixels_mut(&mut self) -> &mut [[f32; 3]] {
        &mut self.pixels
    }

    /// The pixel in column `x` and row `y`, counted from the top left.
    ///
    /// # Panics
    /// If it lies outside of the image.
    pub fn pixel(&self, x: u32, y: u32) -> [f32; 3] {
        assert!(x < self.width && y < self.height, "pixel {x},{y} of a {}x{} image", self.width, self.height);
        self.pixels[(y as usize) * self.width as usize + x as usize]
    }

    /// All channel values one after the other.
    pub fn values(&self) -> impl ExactSizeIterator<Item = f32> + '_ {
        self.pixels.as_flattened().iter().copied()
    }

    /// Mean over all pixels and channels; 0 for an image without pixels.
    pub fn mean(&self) -> f64 {
        let count = self.values().len().max(1) as f64;
        self.values().map(f64::from).sum::<f64>() / count
    }

    /// First pixel that holds NaN or infinity, if any.
    pub fn first_non_finite(&self) -> Option<[u32; 2]> {
        let index = self.pixels.iter().position(|p| p.iter().any(|v| !v.is_finite()))? as u32;
        Some([index % self.width, index / self.width])
    }

    /// The image with every value passed through `f`.
    pub fn map(&self, f: impl Fn(f32) -> f32) -> Self {
        Self { pixels: self.pixels.iter().map(|p| p.map(&f)).collect(), ..*self }
    }

    /// The image at a smaller size, each pixel the mean of a block: what a box filter over the larger pixels gives.
    /// `None` if the size is not the same whole fraction of both edges.
    pub fn reduced(&self, size: [u32; 2]) -> Option<Self> {
        let [width, height] = size;
        let factor = self.width.checked_div(width)?;
        if factor == 0 || width * factor != self.width || height.checked_mul(factor)? != self.height {
            return None;
        }
        let mut sums = vec![[0.0f64; 3]; width as usize * height as usize];
        for (index, pixel) in self.pixels.iter().enumerate() {
            let (x, y) = (index as u32 % self.width / factor, index as u32 / self.width / factor);
            let sum = &mut sums[y as usize * width as usize + x as usize];
            sum.iter_mut().zip(pixel).for_each(|(sum, value)| *sum += f64::from(*value));
        }
        let count = f64::from(factor) * f64::from(factor);
        Self::from_pixels(width, height, sums.iter().map(|sum| sum.map(|v| (v / count) as f32)).collect())
    }

    /// First pixel whose bits differ, if any, and how many do. NaN equals NaN of the same bits, and 0 is not -0.
    /// All pixels differ if the sizes do.
    pub fn first_bit_difference(&self, other: &Self) -> Option<([u32; 2], usize)> {
        if self.size() != other.size() {
            return Some(([0; 2], self.pixels.len()));
        }
        let differ = |(a, b): (&[f32; 3], &[f32; 3])| a.map(f32::to_bits) != b.map(f32::to_bits);
        let mut different = self.pixels.iter().zip(&other.pixels).enumerate().filter(|(_, pair)| differ(*pair));
        let (first, _) = different.next()?;
        let at = [first as u32 % self.width, first as u32 / self.width];
        Some((at, 1 + different.count()))
    }

    /// Bytes of the image encoded in sRGB, values clamped to 0..1, three a pixel.
    pub fn to_srgb8(&self) -> Vec<u8> {
        self.values().map(|v| (srgb_encode(v.clamp(0.0, 1.0)) * 255.0).round() as u8).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::srgb_decode;

    #[test]
    fn srgb_round_trips_every_byte() {
        for byte in 0..=255u8 {
            let linear = srgb_decode(f32::from(byte) / 255.0);
            let image = Image::filled(1, 1, [linear; 3]);
            assert_eq!(image.to_srgb8(), [byte; 3]);
        }
    }

    #[test]
    fn non_finite_pixels_are_found_by_place() {
        let mut image = Image::filled(4, 3, [1.0; 3]);
        assert_eq!(image.first_non_finite(), None);
        image.pixels_mut()[6][2] = f32::NAN;
        assert_eq!(image.first_non_finite(), Some([2, 1]));
    }

    #[test]
    fn blocks_are_averaged() {
        let pixels = (0..24).map(|i| [i as f32, 1.0, 0.0]).collect();
        let image = Image::from_pixels(6, 4, pixels).expect("24 pixels");
        let half = image.reduced([3, 2]).expect("a half");
        assert_eq!((half.size(), half.pixel(0, 0), half.pixel(2, 1)), ([3, 2], [3.5, 1.0, 0.0], [19.5, 1.0, 0.0]));
        assert_eq!(image.reduced([6, 4]).as_ref(), Some(&image));
        for size in [[3, 4], [4, 2], [12, 8], [0, 0], [3, 0]] {
            assert_eq!(image.reduced(size), None, "{size:?}");
        }
    }

    #[test]
    fn bits_are_compared() {
        let image = Image::filled(4, 3, [0.0, f32::NAN, 1.0]);
        assert_eq!(image.first_bit_difference(&image.clone()), None);
        let mut other = image.clone();
        other.pixels_mut()[6][0] = -0.0;
        other.pixels_mut()[11][2] = f32::from_bits(1.0f32.to_bits() + 1);
        assert_eq!(image.first_bit_difference(&other), Some(([2, 1], 2)));
        assert!(image.first_bit_difference(&Image::filled(3, 4, [0.0; 3])).is_some());
    }

    #[test]
    fn pixel_counts_must_fit() {
        assert!(Image::from_pixels(2, 2, vec![[0.0; 3]; 3]).is_none());
        assert!(Image::from_rgba(2, 2, &[[0.0; 4]; 4]).is_some());
    }
}
