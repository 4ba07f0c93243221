//! Errors of methods in one room.

use super::edges;
use super::figures::{PartError, ReferenceFigures, RoomError, RoomFigures};
use super::methods::Judged;
use super::room::RoomFacts;
use crate::bench::error::{layer_error, mean};
use crate::bench::fixture::{Fixture, Light};
use anyhow::{Context, Result};
use lightwell::measure::{Image, two_halves};
use lightwell::render::Layer;
use lightwell::render::reference::{Estimate, TraceSettings};
use lightwell::scene::SceneView;
use std::time::Instant;

/// Seed of references, another one than that of the path tracing that is measured.
const SEED: u32 = 0x1157;
/// Samples that a reference begins with.
const FIRST_SAMPLES: u32 = 64;
/// Samples of the reference of one bounce, of which the mean alone counts.
const ONE_BOUNCE_SAMPLES: u32 = 64;
/// Noise of a reference over the least error that is taken with it.
const NOISE: f64 = 0.25;

/// The settings that a room is drawn with.
#[derive(Clone, Copy, Debug)]
pub struct Course {
    /// Image size [pixels].
    pub size: [u32; 2],
    /// Most samples a pixel of the reference.
    pub most_samples: u32,
}

/// A room as it was measured, with its images.
pub struct Measured {
    /// The figures.
    pub figures: RoomFigures,
    /// Indirect light of each method.
    pub images: Vec<Image>,
    /// Indirect light of the reference.
    pub reference: Image,
}

/// Measures all methods in the room that the fixture holds, whose runners are those of the methods.
///
/// # Errors
/// If it cannot be drawn or traced, or an image holds NaN.
pub fn measure(fixture: &mut Fixture, methods: &[Judged], course: &Course, facts: &RoomFacts) -> Result<Measured> {
    let begun = Instant::now();
    let mut drawn = Vec::new();
    for method in methods {
        let light = match method.variant.is_traced() {
            true => fixture.trace(method.runner, course.size),
            false => fixture.draw(method.runner, course.size, method.images),
        };
        drawn.push(light.with_context(|| method.name.clone())?);
        log::info!("{}: {:.1} s after the start", method.name, begun.elapsed().as_secs_f64());
    }
    let near = edges::near_edges(fixture.tracer(), course.size)?;
    let (estimate, limited) = reference(fixture, &drawn, course)?;
    log::info!("reference of {} samples: {:.1} s after the start", estimate.samples, begun.elapsed().as_secs_f64());
    let one_bounce =
        trace(fixture, course, Some(1), &mut |_, samples| Ok((samples == 0).then_some(ONE_BOUNCE_SAMPLES)))?;
    let mut errors = Vec::new();
    for (method, light) in methods.iter().zip(&drawn) {
        let error =
            |image: &Image, layer| layer_error(image, &estimate.halves(layer)).with_context(|| method.name.clone());
        errors.push(RoomError {
            method: method.name.clone(),
            uncertainty: uncertainty(&light.indirect, &estimate.indirect),
            indirect: error(&light.indirect, Layer::Indirect)?,
            total: error(&light.total, Layer::Total)?,
            edges: part_error(&light.indirect, &estimate, &near, true),
            elsewhere: part_error(&light.indirect, &estimate, &near, false),
        });
    }
    let indirect = estimate.indirect().mean();
    let reference = ReferenceFigures {
        samples: estimate.samples,
        noise: estimate.noise(Layer::Indirect)?,
        limited,
        direct: estimate.direct().mean(),
        indirect,
        further_bounces: if indirect > 0.0 { 1.0 - one_bounce.indirect().mean() / indirect } else { 0.0 },
        near_edges: near.iter().filter(|near| **near).count() as f64 / near.len().max(1) as f64,
    };
    Ok(Measured {
        figures: RoomFigures { facts: facts.clone(), reference, errors, seconds: begun.elapsed().as_secs_f64() },
        images: drawn.into_iter().map(|light| light.indirect).collect(),
        reference: mean(&estimate.indirect),
    })
}

/// Tells how many samples there shall be after those of an estimate; none: enough.
type More<'a> = dyn FnMut(Option<&Estimate>, u32) -> Result<Option<u32>> + 'a;

/// Traces until `more` asks for no more: it is given what there is and its samples, at first none, and tells how many there
/// shall be.
fn trace(fixture: &mut Fixture, course: &Course, bounces: Option<u32>, more: &mut More) -> Result<Estimate> {
    let session = fixture.tracer();
    let view = SceneView { camera: session.camera()?, size: course.size, jitter: [0.0; 2] };
    let settings = TraceSettings { bounces, seed: SEED };
    session.begin_trace(&view, &settings)?.0.tracer.restart();
    let (mut tracing, _) = session.begin_trace(&view, &settings)?;
    let mut estimate = None;
    while let Some(samples) = more(estimate.as_ref(), estimate.as_ref().map_or(0, |estimate| estimate.samples))? {
        tracing.advance_to(samples, &mut |_| {})?;
        estimate = Some(tracing.estimate()?);
    }
    estimate.context("nothing was traced")
}

/// Traces the reference until its noise is small against all errors, or the limit is reached; tells whether it was.
fn reference(fixture: &mut Fixture, drawn: &[Light], course: &Course) -> Result<(Estimate, bool)> {
    let mut limited = false;
    let estimate = trace(fixture, course, None, &mut |estimate, samples| {
        let Some(estimate) = estimate else { return Ok(Some(FIRST_SAMPLES.min(course.most_samples))) };
        let excess = excess_of_noise(estimate, drawn)?;
        limited = excess > 1.0 && samples >= course.most_samples;
        if excess <= 1.0 || limited {
            return Ok(None);
        }
        // Noise falls with the root of the samples; what it is now is uncertain.
        let wanted = (f64::from(samples) * (1.1 * excess * excess).clamp(1.5, 4.0)).ceil() as u32;
        Ok(Some(wanted.min(course.most_samples)))
    })?;
    Ok((estimate, limited))
}

/// Noise of the reference over what is allowed, the worst of indirect and all light.
fn excess_of_noise(estimate: &Estimate, drawn: &[Light]) -> Result<f64> {
    let mut excess = 0.0_f64;
    for light in drawn {
        for (image, layer) in [(&light.indirect, Layer::Indirect), (&light.total, Layer::Total)] {
            let [first, second] = estimate.halves(layer);
            let error = two_halves(image, &first, &second)?;
            if error.noise > 0.0 {
                // An error below the noise is not known; the noise itself is then the best guess.
                excess = excess.max(error.noise / (NOISE * error.nrmse.max(1e-3)));
            }
        }
    }
    Ok(excess)
}

/// How much larger the nrmse of an image may be than what [`two_halves`] finds, by one standard error: what the noise of the
/// reference leaves open. Noise of the channels of a pixel is taken to be the same.
fn uncertainty(image: &Image, [first, second]: &[Image; 2]) -> f64 {
    let (mut square, mut variance) = (0.0, 0.0);
    for ((a, r1), r2) in image.pixels().iter().zip(first.pixels()).zip(second.pixels()) {
        let (mut product, mut spread) = (0.0, 0.0);
        for channel in 0..3 {
            let [a, r1, r2] = [a, r1, r2].map(|pixel| f64::from(pixel[channel]));
            product += (a - r1) * (a - r2);
            spread += (r1 - r2) * (r1 - r2);
        }
        square += product;
        // With an error e, and normal noise of variance s² in each half, the product varies by 2e²s² + s⁴. That is the mean
        // of this term; where some samples are far brighter than others it is more.
        variance += product * spread + 0.25 * spread * spread;
    }
    let count = 3.0 * image.pixels().len() as f64;
    let (square, error) = ((square / count).max(0.0), variance.max(0.0).sqrt() / count);
    let mean = 0.5 * (first.mean() + second.mean());
    if error == 0.0 { 0.0 } else { ((square + error).sqrt() - square.sqrt()) / mean }
}

/// The error within a part of the image.
fn part_error(image: &Image, estimate: &Estimate, near: &[bool], which: bool) -> Option<PartError> {
    let [first, second] = &estimate.indirect;
    let scale = 0.5 * (first.mean() + second.mean());
    let (mut square, mut sum, mut count) = (0.0, 0.0, 0.0);
    for (index, _) in near.iter().enumerate().filter(|(_, near)| **near == which) {
        for channel in 0..3 {
            let [a, r1, r2] = [image, first, second].map(|image| f64::from(image.pixels()[index][channel]));
            square += (a - r1) * (a - r2);
            sum += a - 0.5 * (r1 + r2);
            count += 1.0;
        }
    }
    let relative = |value: f64| if value == 0.0 { 0.0 } else { value / scale };
    (count > 0.0).then(|| PartError { nrmse: relative((square / count).max(0.0).sqrt()), bias: relative(sum / count) })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn the_uncertainty_is_how_far_errors_scatter() {
        let mut random = super::super::random::Random::new(3, 4);
        let image = Image::filled(32, 32, [1.3; 3]);
        let mut normal = move || (0..12).map(|_| random.within(-0.5, 0.5)).sum::<f64>();
        let mut half = || {
            let pixels = (0..32 * 32).map(|_| [1.0 + normal() as f32; 3]).collect();
            Image::from_pixels(32, 32, pixels).unwrap()
        };
        let (mut scatter, mut told) = (0.0, 0.0);
        for _ in 0..200 {
            let halves = [half(), half()];
            let found = two_halves(&image, &halves[0], &halves[1]).unwrap();
            let mean = 0.5 * (halves[0].mean() + halves[1].mean());
            // The upper end of what was found, taken back to the square.
            let upper = (found.nrmse + uncertainty(&image, &halves)) * mean;
            told += (upper * upper - found.squared_error.max(0.0)) / 200.0;
            scatter += (found.squared_error - 0.09).powi(2) / 200.0;
        }
        assert!((told / scatter.sqrt() - 1.0).abs() < 0.25, "{told} {}", scatter.sqrt());
    }

    #[test]
    fn errors_of_parts_make_up_that_of_the_whole() {
        let image =
            |f: &dyn Fn(usize) -> f32| Image::from_pixels(8, 8, (0..64).map(|i| [f(i), 1.0, 0.5]).collect()).unwrap();
        let truth = || image(&|i| 1.0 + i as f32 / 64.0);
        let estimate = Estimate { direct: [truth(), truth()], indirect: [truth(), truth()], samples: 2 };
        let method = image(&|i| 1.1 + (i % 3) as f32 / 10.0 + i as f32 / 64.0);
        let near: Vec<bool> = (0..64).map(|i| i % 5 < 2).collect();
        let (edges, elsewhere) = (
            part_error(&method, &estimate, &near, true).unwrap(),
            part_error(&method, &estimate, &near, false).unwrap(),
        );
        let whole = layer_error(&method, &estimate.indirect).unwrap();
        let share = near.iter().filter(|near| **near).count() as f64 / 64.0;
        let square = share * edges.nrmse.powi(2) + (1.0 - share) * elsewhere.nrmse.powi(2);
        assert!((square.sqrt() - whole.nrmse).abs() < 1e-6);
        assert!((share * edges.bias + (1.0 - share) * elsewhere.bias - whole.bias).abs() < 1e-6);
        assert_eq!(part_error(&method, &estimate, &[false; 64], true), None);
    }
}
