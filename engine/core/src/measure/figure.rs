//! Images to look at: radiance as a screen shows it, and images beside their reference.

use super::difference::difference_picture;
use super::flip::{display_value, flip_exposure};
use super::{Image, MeasureError};

/// Columns between the panels of a figure \[pixels\].
const GAP: u32 = 8;

/// Radiance as it is shown beside its reference: exposed by [`flip_exposure`] of the reference and tone mapped by
/// c / (1 + c). Values are linear light of 0..1, which a PNG encodes.
pub fn displayed(image: &Image, reference: &Image) -> Image {
    let exposure = flip_exposure(reference);
    image.map(|value| display_value(value, exposure))
}

/// The image, its reference and their [difference](difference_picture) side by side, as in the thesis's figures 7.2
/// to 7.7, with a white gap between.
///
/// # Errors
/// If the sizes differ, there are no pixels, or a value is not finite.
pub fn figure(image: &Image, reference: &Image) -> Result<Image, MeasureError> {
    let difference = difference_picture(image, reference)?;
    let panels = [displayed(image, reference), displayed(reference, reference), difference];
    let [width, height] = image.size();
    let mut pixels = Vec::with_capacity(3 * image.pixels().len());
    for row in 0..height {
        for (i, panel) in panels.iter().enumerate() {
            let gap = if i == 0 { 0 } else { GAP };
            pixels.extend((0..gap).map(|_| [1.0; 3]));
            pixels.extend((0..width).map(|column| panel.pixel(column, row)));
        }
    }
    Image::from_pixels(3 * width + 2 * GAP, height, pixels).ok_or(MeasureError::Empty)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn panels_stand_side_by_side() {
        let reference = Image::filled(5, 3, [0.18; 3]);
        let image = Image::filled(5, 3, [0.27; 3]);
        let figure = figure(&image, &reference).unwrap();
        assert_eq!(figure.size(), [31, 3]);
        let middle_grey = 0.18 / 1.18;
        assert!((figure.pixel(13, 0)[1] - middle_grey).abs() < 1e-6, "{:?}", figure.pixel(13, 0));
        assert!(figure.pixel(4, 2)[1] > middle_grey, "the image is brighter");
        assert_eq!((figure.pixel(5, 1), figure.pixel(12, 1)), ([1.0; 3], [1.0; 3]), "gap");
        assert_eq!(figure.pixel(30, 2), difference_picture(&image, &reference).unwrap().pixel(4, 2));
    }
}
