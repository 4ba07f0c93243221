//! Flicker: how much more an image changes from frame to frame than the reference does.

use super::lab::Lab;
use super::reference::{References, Wanted};
use super::results::Flicker;
use super::variant::Variant;
use anyhow::{Context, Result};
use lightwell::measure::Image;
use lightwell::render::Layer;

/// What is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Course {
    /// Image size [pixels].
    pub size: [u32; 2],
    /// Frames of the scene's clock, from its first on.
    pub frames: u32,
    /// Frames averaged for an image.
    pub aa: u32,
    /// Samples a pixel of the references.
    pub samples: u32,
}

/// Sums of one variant over the frames.
#[derive(Clone, Default)]
struct Sums {
    last: Option<Image>,
    /// Σ over pixels of (Δa − Δr₁)(Δa − Δr₂).
    change: f64,
}

/// Measures the flicker of indirect light of some variants. The change beyond the reference's own is
/// sqrt(mean((Δa − Δr₁)·(Δa − Δr₂))) / mean(r), where Δ is the difference of successive frames and r₁, r₂ are the
/// reference's two halves, whose noise cancels.
///
/// # Errors
/// If a frame cannot be drawn or traced.
pub fn measure(
    lab: &mut Lab,
    which: &[usize],
    course: &Course,
    references: &References,
    progress: &mut dyn FnMut(Option<&Variant>),
) -> Result<Vec<Flicker>> {
    let (_, rate) = lab.clock();
    let scene = lab.name();
    let mut sums = vec![Sums::default(); which.len()];
    let mut last: Option<[Image; 2]> = None;
    let (mut own, mut mean, mut values) = (0.0, 0.0, 0.0);
    for frame in 0..course.frames {
        let time = f64::from(frame) / f64::from(rate.max(1));
        lab.set_seconds(time);
        let wanted = Wanted { scene: &scene, time, size: course.size, bounces: None, samples: course.samples };
        let found = references.get(lab.tracer(), &wanted, &mut |_| progress(None))?;
        let halves = found.estimate.halves(Layer::Indirect);
        mean += 0.5 * (halves[0].mean() + halves[1].mean()) / f64::from(course.frames);
        let zero = last.as_ref().map(|_| Image::filled(course.size[0], course.size[1], [0.0; 3]));
        if let (Some(last), Some(zero)) = (&last, &zero) {
            own += product((zero, zero), last, &halves);
            values += zero.values().len() as f64;
        }
        for (sums, &index) in sums.iter_mut().zip(which) {
            let traced = lab.runners[index].0.is_traced();
            let light = if traced { lab.trace(index, course.size)? } else { lab.draw(index, course.size, course.aa)? };
            if let (Some(before), Some(last)) = (&sums.last, &last) {
                sums.change += product((before, &light.indirect), last, &halves);
            }
            sums.last = Some(light.indirect);
            progress(Some(&lab.runners[index].0));
        }
        last = Some(halves);
    }
    let relative = |sum: f64| (sum / values).max(0.0).sqrt() / mean;
    let flicker = |(sums, &index): (Sums, &usize)| Flicker {
        key: String::new(),
        scene: scene.clone(),
        variant: lab.runners[index].0.name.clone(),
        frames: course.frames,
        change: relative(sums.change),
        reference: relative(own),
    };
    (course.frames > 1).then_some(()).context("flicker needs two frames or more")?;
    Ok(sums.into_iter().zip(which).map(flicker).collect())
}

/// Σ (Δa − Δr₁)(Δa − Δr₂) over all values.
fn product((a0, a1): (&Image, &Image), r0: &[Image; 2], r1: &[Image; 2]) -> f64 {
    let change = |before: &Image, after: &Image| -> Vec<f64> {
        before.values().zip(after.values()).map(|(b, a)| f64::from(a) - f64::from(b)).collect()
    };
    let (a, first, second) = (change(a0, a1), change(&r0[0], &r1[0]), change(&r0[1], &r1[1]));
    a.iter().zip(first).zip(second).map(|((a, r1), r2)| (a - r1) * (a - r2)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_change_beyond_the_references_counts() {
        let image = |value: f32| Image::filled(2, 1, [value; 3]);
        let (before, after) = ([image(1.0), image(1.1)], [image(2.0), image(2.1)]);
        // The image moves with the reference, half as far, and not at all.
        for (a1, sum) in [(6.0, 0.0), (5.5, 6.0 * 0.25), (5.0, 6.0)] {
            let found = product((&image(5.0), &image(a1)), &before, &after);
            assert!((found - sum).abs() < 1e-5, "{a1}: {found}");
        }
    }
}
