//! Each invariant, checked for one row of the matrix.

use super::invariant::Invariant;
use super::rig::{self, Rig};
use super::setup::{CELL, Grid, Lamps, Method, Setup};
use anyhow::Result;
use lightwell::measure::Image;

/// Images of other random numbers that tell how large noise is.
const OTHERS: u32 = 3;

/// Deviations that were found.
pub type Found = Vec<(Invariant, f64)>;

/// Checks all invariants that compare images of a row.
///
/// # Errors
/// If an image cannot be drawn.
pub fn check(rig: &mut Rig, row: &Setup) -> Result<Found> {
    rig.take_not_finite();
    let base = rig.image(row)?;
    let noise = noise(rig, row, &base)?;
    let mut found = vec![(Invariant::Superposition, superposition(rig, row, &base)? / noise)];
    for (invariant, other, of_other) in twins(row) {
        let image = rig.image(&other)?;
        let image = if invariant == Invariant::Mirror { mirrored(&image) } else { (*image).clone() };
        let unit = if invariant == Invariant::Intensity { 1.0 } else { noise };
        found.push((invariant, nrmse(&base, &image, of_other) / unit));
    }
    found.push((Invariant::Doubling, doubling(rig, row, &base)?));
    found.extend(against_truth(rig, row, &base)?);
    found.push((Invariant::Moved, moved(rig, row, &base)?));
    found.extend(in_one_session(rig, row, &base)?);
    found.push((Invariant::Finite, rig.take_not_finite() as f64));
    Ok(found)
}

/// The unit of deviations that random numbers have a part in: how far images of other random numbers differ, the root of
/// the mean square over three of them, since one may be off by twice that. One where there are no such numbers.
fn noise(rig: &mut Rig, row: &Setup, base: &Image) -> Result<f64> {
    if !row.method.is_random() {
        return Ok(1.0);
    }
    let mut sum = 0.0;
    for seed in 1..=OTHERS {
        let other = rig.image(&Setup { seed, ..row.clone() })?;
        sum += nrmse(base, &other, 1.0).powi(2);
    }
    let noise = (sum / f64::from(OTHERS)).sqrt();
    Ok(if noise > 0.0 { noise } else { 1.0 })
}

/// Setups that must look as the row does, each with the factor from its light to the row's.
fn twins(row: &Setup) -> Vec<(Invariant, Setup, f64)> {
    let like = row.clone();
    let shifted = |by: [f32; 3]| Setup {
        position: std::array::from_fn(|axis| row.position[axis] + CELL * by[axis]),
        ..row.clone()
    };
    let mut all = vec![
        (Invariant::Mirror, Setup { mirrored: true, ..like.clone() }, 1.0),
        (Invariant::QuarterTurn, Setup { quarter_turn: true, ..like.clone() }, 1.0),
        (Invariant::PartOfCell, shifted([0.37, 0.21, -0.73]), 1.0),
        (Invariant::Order, Setup { reversed: true, ..like.clone() }, 1.0),
    ];
    // Cells of an automatic grid are of no simple size.
    if row.grid != Grid::Auto {
        all.push((Invariant::WholeCells, shifted([8.0, 4.0, -16.0]), 1.0));
    }
    if row.intensity != 1.0 {
        all.push((Invariant::Intensity, Setup { intensity: 1.0, ..like.clone() }, f64::from(row.intensity)));
    }
    if row.scale != 1.0 {
        all.push((Invariant::Length, Setup { scale: 1.0, ..like.clone() }, 1.0));
    }
    if row.position != [0.0; 3] {
        all.push((Invariant::Position, Setup { position: [0.0; 3], ..like.clone() }, 1.0));
    }
    if row.tilt != [0.0; 3] {
        all.push((Invariant::Orientation, Setup { tilt: [0.0; 3], ..like }, 1.0));
    }
    all
}

/// Samples of each of the two path-traced images that an image is held against.
const TRUTH_SAMPLES: u32 = 32;

/// Invariants against the path tracer: an image that is black, even, or of other light breaks one of these.
fn against_truth(rig: &mut Rig, row: &Setup, base: &Image) -> Result<Found> {
    let mut traced = |seed: u32| {
        let mut look = Method::Reference.look(row.grid, seed);
        look.only = row.method.look(row.grid, 0).only;
        (look.trace.spp, look.trace.bounces) = (TRUTH_SAMPLES, row.method.bounces());
        let mut session = rig.open(&row.text(), &look)?;
        rig.draw(&mut session, false)
    };
    let (first, second) = (traced(101)?, traced(102)?);
    let truth = (first.mean() + second.mean()) / 2.0;
    let share = base.mean() / truth;
    // Each image's noise is independent of the other's: what both agree on is the error of the image.
    let squares = base.values().zip(first.values()).zip(second.values());
    let error = squares.map(|((a, b), c)| (f64::from(a) - f64::from(b)) * (f64::from(a) - f64::from(c))).sum::<f64>();
    let error = (error / base.values().len() as f64).max(0.0).sqrt() / truth;
    let contrast = spread(base, base).sqrt() / base.mean() / (spread(&first, &second).sqrt() / truth);
    log::info!("{}: {share:.3} of the light, nrmse {error:.3}, {contrast:.3} of the contrast", row.method.name());
    Ok(vec![(Invariant::Share, (share - 1.0).abs()), (Invariant::Truth, error), (Invariant::Contrast, 1.0 - contrast)])
}

/// Variance of the values that two images have in common; of one image with itself, its own.
fn spread(a: &Image, b: &Image) -> f64 {
    let (mean_a, mean_b) = (a.mean(), b.mean());
    let products = a.values().zip(b.values()).map(|(a, b)| (f64::from(a) - mean_a) * (f64::from(b) - mean_b));
    (products.sum::<f64>() / a.values().len() as f64).max(0.0)
}

/// sqrt(mean((a − k·b)²)) / mean(a); both black: zero.
fn nrmse(a: &Image, b: &Image, factor: f64) -> f64 {
    let squared = a.values().zip(b.values()).map(|(a, b)| (f64::from(a) - factor * f64::from(b)).powi(2)).sum::<f64>();
    of_mean((squared / a.values().len() as f64).sqrt(), a)
}

/// A difference relative to the mean of an image.
fn of_mean(difference: f64, image: &Image) -> f64 {
    if difference == 0.0 { 0.0 } else { difference / image.mean() }
}

fn mirrored(image: &Image) -> Image {
    let mut mirrored = image.clone();
    let width = image.size()[0] as usize;
    mirrored.pixels_mut().chunks_mut(width).for_each(<[_]>::reverse);
    mirrored
}

fn superposition(rig: &mut Rig, row: &Setup, base: &Image) -> Result<f64> {
    let inside = rig.image(&Setup { lamps: Lamps::Inside, ..row.clone() })?;
    let sun = rig.image(&Setup { lamps: Lamps::Sun, ..row.clone() })?;
    let mut sum = (*inside).clone();
    for (sum, sun) in sum.pixels_mut().as_flattened_mut().iter_mut().zip(sun.values()) {
        *sum += sun;
    }
    Ok(nrmse(base, &sum, 1.0))
}

fn doubling(rig: &mut Rig, row: &Setup, base: &Image) -> Result<f64> {
    let bright = rig.image(&Setup { intensity: 128.0 * row.intensity, ..row.clone() })?;
    let differences = base.values().zip(bright.values()).map(|(a, b)| (f64::from(a) - f64::from(b) / 128.0).abs());
    Ok(of_mean(differences.fold(0.0, f64::max), base))
}

fn moved(rig: &mut Rig, row: &Setup, base: &Image) -> Result<f64> {
    let moved = rig.image(&Setup { moved: 0.02, ..row.clone() })?;
    let change = base.values().zip(moved.values()).map(|(a, b)| (f64::from(a) - f64::from(b)).abs()).sum::<f64>();
    Ok(of_mean(change / base.values().len() as f64, base))
}

/// Invariants from frame to frame of a running scene.
fn in_one_session(rig: &mut Rig, row: &Setup, base: &Image) -> Result<Found> {
    let mut session = rig.open(&row.text(), &row.method.look(row.grid, row.seed))?;
    let again = rig.draw(&mut session, false)?;
    let uncached = rig.draw(&mut session, true)?;
    let intensities = rig::dim(&mut session, 0.0);
    let off = rig.draw(&mut session, false)?;
    rig::relight(&mut session, &intensities);
    let on = rig.draw(&mut session, false)?;
    let mut dark = rig.open(&row.text(), &row.method.look(row.grid, row.seed))?;
    rig::dim(&mut dark, 0.0);
    let dark = rig.draw(&mut dark, false)?;
    Ok(vec![
        (Invariant::Repeat, differing(base, &again)),
        (Invariant::Cache, differing(base, &uncached)),
        (Invariant::SwitchedOff, brightest(&off)),
        (Invariant::Undo, differing(base, &on)),
        (Invariant::Dark, brightest(&dark)),
    ])
}

fn differing(a: &Image, b: &Image) -> f64 {
    a.values().zip(b.values()).filter(|(a, b)| a.to_bits() != b.to_bits()).count() as f64
}

fn brightest(image: &Image) -> f64 {
    image.values().map(|value| f64::from(value.abs())).fold(0.0, f64::max)
}
