//! The difference image: where an image is brighter or darker than its reference.

use super::{Image, MeasureError, metrics::check_pair};

/// Signed difference to look at: red where the image is too bright, blue where it is too dark, black where both
/// agree; full colour at an error of the reference's mean (of 1 where that is zero). Values are linear.
///
/// The strength is the mean absolute error of the three channels, so that an error of hue shows too.
///
/// # Errors
/// If the sizes differ, there are no pixels, or a value is not finite.
pub fn difference_picture(image: &Image, reference: &Image) -> Result<Image, MeasureError> {
    check_pair(image, reference)?;
    let mean = reference.mean();
    let scale = if mean > 0.0 { 1.0 / mean } else { 1.0 };
    let mut picture = image.clone();
    for (pixel, r) in picture.pixels_mut().iter_mut().zip(reference.pixels()) {
        let errors = [0, 1, 2].map(|c| f64::from(pixel[c]) - f64::from(r[c]));
        let strength = (errors.iter().map(|e| e.abs()).sum::<f64>() / 3.0 * scale).min(1.0);
        *pixel = color(strength as f32, errors.iter().sum::<f64>() < 0.0);
    }
    Ok(picture)
}

fn color(strength: f32, darker: bool) -> [f32; 3] {
    // The weaker channels lift the middle of the scale, which pure red and blue would leave too dark to see.
    let soft = strength * strength;
    if darker { [0.1 * soft, 0.4 * soft, strength] } else { [strength, 0.3 * soft, 0.05 * soft] }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn sign_and_strength_show() {
        let reference = Image::filled(3, 1, [1.0; 3]);
        let image = Image::from_pixels(3, 1, vec![[1.0; 3], [1.5; 3], [0.0; 3]]).unwrap();
        let picture = difference_picture(&image, &reference).unwrap();
        assert_eq!(picture.pixel(0, 0), [0.0; 3]);
        assert_eq!(picture.pixel(1, 0)[0], 0.5);
        assert_eq!(picture.pixel(2, 0)[2], 1.0);
    }
}
