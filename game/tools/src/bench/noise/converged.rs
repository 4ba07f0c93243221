//! The image that a method converges to, with the pixel grid where single images have it: edges of surfaces cancel, and what is
//! left is noise and bias of what is compared with it.

use anyhow::{Context, Result};
use lightwell::measure::Image;
use lightwell::render::{Layer, RenderSettings};
use lightwell::scene::SceneView;
use lightwell_runtime::session::Session;

/// Images that the filters of each frame are told of: they narrow accordingly.
const FILTERED_FOR: u32 = 64;
/// Step of the shifts that give each frame random numbers of its own [pixels]. No edge moves by so little.
const STEP: f32 = 1e-6;

/// Shift of a frame, which is none to the eye.
pub fn shift(frame: u32) -> [f32; 2] {
    let step = STEP * (frame / 2 + 1) as f32;
    [if frame.is_multiple_of(2) { step } else { -step }, 0.0]
}

/// A mean of frames, by halves.
pub struct Converged {
    size: [u32; 2],
    sums: [Vec<f64>; 2],
    /// Frames in both halves together.
    pub frames: u32,
}

impl Converged {
    /// Of no frames yet.
    pub fn new(size: [u32; 2]) -> Self {
        let zero = || vec![0.0; 3 * size[0] as usize * size[1] as usize];
        Self { size, sums: [zero(), zero()], frames: 0 }
    }

    /// Draws until there are so many frames, a multiple of four; `drawn` hears of each.
    ///
    /// # Errors
    /// If the scene cannot be drawn.
    pub fn advance_to(
        &mut self,
        frames: u32,
        session: &mut Session,
        view: &SceneView,
        drawn: &mut dyn FnMut(),
    ) -> Result<()> {
        let settings = RenderSettings { average: false, images: FILTERED_FOR, ..session.render_settings(false) };
        while self.frames < frames.next_multiple_of(4) {
            session.render(&SceneView { jitter: shift(self.frames), ..view.clone() }, &settings)?;
            // Pairs of opposite shifts take turns.
            let sum = &mut self.sums[(self.frames / 2 % 2) as usize];
            for (sum, value) in sum.iter_mut().zip(session.radiance()?.values()) {
                *sum += f64::from(value);
            }
            self.frames += 1;
            drawn();
        }
        Ok(())
    }

    /// The means of both halves.
    ///
    /// # Errors
    /// If the frames had other sizes.
    pub fn halves(&self) -> Result<[Image; 2]> {
        let count = f64::from((self.frames / 2).max(1));
        let half = |sum: &[f64]| {
            let values: Vec<f32> = sum.iter().map(|sum| (sum / count) as f32).collect();
            Image::from_pixels(self.size[0], self.size[1], values.as_chunks().0.to_vec())
                .context("the image is incomplete")
        };
        Ok([half(&self.sums[0])?, half(&self.sums[1])?])
    }
}

/// The mean direct light of some frames.
///
/// # Errors
/// If the scene cannot be drawn.
pub fn direct(session: &mut Session, view: &SceneView, frames: u32) -> Result<Image> {
    let settings = RenderSettings { average: false, only: Layer::Direct, ..session.render_settings(false) };
    let mut sum = vec![[0.0_f64; 3]; (view.size[0] * view.size[1]) as usize];
    for frame in 0..frames {
        session.render(&SceneView { jitter: shift(frame), ..view.clone() }, &settings)?;
        for (sum, value) in sum.as_flattened_mut().iter_mut().zip(session.radiance()?.values()) {
            *sum += f64::from(value) / f64::from(frames);
        }
    }
    let pixels = sum.iter().map(|pixel| pixel.map(|value| value as f32)).collect();
    Image::from_pixels(view.size[0], view.size[1], pixels).context("the image is incomplete")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn frames_have_other_random_numbers_and_the_same_pixels() {
        let shifts: Vec<f32> = (0..4096).map(|frame| shift(frame)[0]).collect();
        let bits: BTreeSet<u32> = shifts.iter().map(|shift| shift.to_bits()).collect();
        assert_eq!(bits.len(), shifts.len());
        assert!(shifts.iter().all(|shift| *shift != 0.0 && shift.abs() < 0.01));
        assert!(shifts.iter().sum::<f32>().abs() < 1e-6);
    }
}
