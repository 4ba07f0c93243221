//! Shifts of the pixel grid by parts of a pixel, where the mean over frames smooths edges: see
//! `post/temporal_antialiasing.rs`.

use super::settings::{Layer, RenderSettings};
use crate::scene::SceneView;

/// Shifts before they come again.
const SHIFTS: u32 = 1 << 12;

/// Whether the edges of a frame that is averaged may be smoothed so: of images that are looked at, without anything that is
/// drawn over them, which would tremble with the shifts, and without a reference beside, which has none.
pub(super) fn is_possible(settings: &RenderSettings, view: &SceneView) -> bool {
    settings.mlaa
        && settings.display
        && settings.only == Layer::Total
        && settings.debug.is_empty()
        && settings.beside.is_none()
        && view.jitter == [0.0; 2]
}

/// Shift of the pixel grid of a frame \[pixels\]: points of Halton's sequence in bases 2 and 3, less their mean.
pub(super) fn of_frame(number: u32) -> [f32; 2] {
    [2, 3].map(|base| radical_inverse(number % SHIFTS + 1, base) - 0.5)
}

fn radical_inverse(mut index: u32, base: u32) -> f32 {
    let (mut value, mut place) = (0.0, 1.0 / f64::from(base));
    while index > 0 {
        value += f64::from(index % base) * place;
        index /= base;
        place /= f64::from(base);
    }
    value as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shifts_stay_in_the_pixel_and_have_its_center_as_their_mean() {
        for count in [64, 1000] {
            let shifts: Vec<[f32; 2]> = (0..count).map(of_frame).collect();
            assert!(shifts.iter().flatten().all(|shift| (-0.5..=0.5).contains(shift)));
            for axis in 0..2 {
                let mean: f32 = shifts.iter().map(|shift| shift[axis]).sum::<f32>() / count as f32;
                assert!(mean.abs() < 4.0 / count as f32, "{count}: {mean}");
            }
        }
    }
}
