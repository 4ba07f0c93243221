//! The picture type of all measurements.

/// A picture of linear Rec. 709 RGB in single precision, row by row from the top left.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    width: u32,
    height: u32,
    pixels: Vec<[f32; 3]>,
}

impl Image {
    /// A picture whose every pixel is `color`.
    pub fn filled(width: u32, height: u32, color: [f32; 3]) -> Self {
        Self { width, height, pixels: vec![color; width as usize * height as usize] }
    }

    /// A picture from its pixels; `None` if their number is not `width`·`height`.
    pub fn from_pixels(width: u32, height: u32, pixels: Vec<[f32; 3]>) -> Option<Self> {
        (pixels.len() == width as usize * height as usize).then_some(Self { width, height, pixels })
    }

    /// A picture from RGBA pixels, whose alpha is dropped; `None` if their number does not fit.
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
    /// If it lies outside of the picture.
    pub fn pixel(&self, x: u32, y: u32) -> [f32; 3] {
        assert!(x < self.width && y < self.height, "pixel {x},{y} of a {}x{} image", self.width, self.height);
        self.pixels[(y as usize) * self.width as usize + x as usize]
    }

    /// All channel values one after the other.
    pub fn values(&self) -> impl ExactSizeIterator<Item = f32> + '_ {
        self.pixels.as_flattened().iter().copied()
    }

    /// Mean over all pixels and channels; 0 for a picture without pixels.
    pub fn mean(&self) -> f64 {
        let count = self.values().len().max(1) as f64;
        self.values().map(f64::from).sum::<f64>() / count
    }

    /// First pixel that holds NaN or infinity, if any.
    pub fn first_non_finite(&self) -> Option<[u32; 2]> {
        let index = self.pixels.iter().position(|p| p.iter().any(|v| !v.is_finite()))? as u32;
        Some([index % self.width, index / self.width])
    }

    /// The picture with every value passed through `f`.
    pub fn map(&self, f: impl Fn(f32) -> f32) -> Self {
        Self { pixels: self.pixels.iter().map(|p| p.map(&f)).collect(), ..*self }
    }

    /// Bytes of the picture encoded in sRGB, values clamped to 0..1, three a pixel.
    pub fn to_srgb8(&self) -> Vec<u8> {
        self.values().map(|v| (srgb_encode(v.clamp(0.0, 1.0)) * 255.0).round() as u8).collect()
    }
}

/// Encodes a linear value of 0..1 by the sRGB transfer function (IEC 61966-2-1).
pub fn srgb_encode(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// Decodes an sRGB-encoded value of 0..1 to linear light.
pub fn srgb_decode(encoded: f32) -> f32 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

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
    fn pixel_counts_must_fit() {
        assert!(Image::from_pixels(2, 2, vec![[0.0; 3]; 3]).is_none());
        assert!(Image::from_rgba(2, 2, &[[0.0; 4]; 4]).is_some());
    }
}
