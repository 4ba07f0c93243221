//! Flicker: how much more an image changes from frame to frame than the reference does, and how much of that trembles.

use super::fixture::Fixture;
use super::picture;
use super::reference::{References, Wanted};
use super::results::Flicker;
use super::variant::Variant;
use anyhow::{Context, Result};
use lightwell::measure::Image;
use lightwell::render::Layer;
use lightwell_runtime::cli::Switch;
use std::collections::VecDeque;
use std::path::Path;

/// Change of a tenth of the mean light that is shown as middle grey.
const EXPOSURE: f64 = 10.0;

/// Frames after which nothing is left of those before that.
const LEAD_IN: u32 = 20;

/// The subject of a measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Course {
    /// Image size [pixels].
    pub size: [u32; 2],
    /// First frame of the scene's clock.
    pub first: u32,
    /// Frames from that one on, 3 at least.
    pub frames: u32,
    /// Frames averaged for an image with smooth edges.
    pub aa: u32,
    /// Samples a pixel of the references.
    pub samples: u32,
}

/// The last three images of a row.
#[derive(Clone, Default)]
struct Trail(VecDeque<Image>);

impl Trail {
    fn push(&mut self, image: Image) {
        self.0.truncate(2);
        self.0.push_front(image);
    }

    /// Every value of the last image.
    fn values(&self) -> Option<Vec<f64>> {
        Some(self.0.front()?.values().map(f64::from).collect())
    }

    /// Every value's change from the image before, if there is one.
    fn step(&self) -> Option<Vec<f64>> {
        let [now, before] = [self.0.front()?, self.0.get(1)?];
        Some(now.values().zip(before.values()).map(|(now, before)| f64::from(now) - f64::from(before)).collect())
    }

    /// Every value's second difference over √3, if there are three images: of noise that is another one in each frame
    /// it is as large as the step, of a steady change nothing.
    fn bend(&self) -> Option<Vec<f64>> {
        let [now, before, first] = [self.0.front()?, self.0.get(1)?, self.0.get(2)?];
        let bend = |((now, before), first): ((f32, f32), f32)| {
            (f64::from(now) - 2.0 * f64::from(before) + f64::from(first)) / 3.0_f64.sqrt()
        };
        Some(now.values().zip(before.values()).zip(first.values()).map(bend).collect())
    }
}

/// Sums of squares over frames, for each pixel.
#[derive(Clone)]
struct Squares {
    pixels: Vec<f64>,
    frames: u32,
}

impl Squares {
    fn new(size: [u32; 2]) -> Self {
        Self { pixels: vec![0.0; (size[0] * size[1]) as usize], frames: 0 }
    }

    /// Adds (a − r₁)(a − r₂) of every value: the square of a − r without the noise of r, if that of its halves r₁ and r₂
    /// is independent.
    fn add(&mut self, a: &[f64], [r1, r2]: [&[f64]; 2]) {
        for (index, pixel) in self.pixels.iter_mut().enumerate() {
            let value = |i: usize| (a[i] - r1[i]) * (a[i] - r2[i]);
            *pixel += (3 * index..3 * index + 3).map(value).sum::<f64>() / 3.0;
        }
        self.frames += 1;
    }

    /// Root of the mean over pixels and frames.
    fn root(&self) -> f64 {
        (self.pixels.iter().sum::<f64>() / self.pixels.len() as f64 / f64::from(self.frames)).max(0.0).sqrt()
    }

    /// Root of the mean over frames of each pixel, times a factor.
    fn image(&self, size: [u32; 2], factor: f64) -> Option<Image> {
        let root = |sum: &f64| [((sum / f64::from(self.frames)).max(0.0).sqrt() * factor) as f32; 3];
        Image::from_pixels(size[0], size[1], self.pixels.iter().map(root).collect())
    }
}

/// Change and trembling of a row of images beyond the reference's, and their error.
#[derive(Clone)]
struct Sums {
    trail: Trail,
    change: Squares,
    tremble: Squares,
    error: Squares,
    /// Of the images' means.
    sum: f64,
}

/// Errors of all light of a row of images.
#[derive(Clone)]
struct TotalError {
    squares: Squares,
    /// Of the images' means.
    sum: f64,
}

impl TotalError {
    fn new(size: [u32; 2]) -> Self {
        Self { squares: Squares::new(size), sum: 0.0 }
    }

    fn push(&mut self, image: &Image, halves: &[Image; 2]) {
        let values = |image: &Image| image.values().map(f64::from).collect::<Vec<_>>();
        let [one, two] = [&halves[0], &halves[1]].map(values);
        self.squares.add(&values(image), [&one, &two]);
        self.sum += image.mean();
    }
}

/// A variant's row as it is played, and one with smooth edges.
struct Rows {
    played: Sums,
    smooth: Option<Sums>,
    total: TotalError,
}

impl Sums {
    fn new(size: [u32; 2]) -> Self {
        let [change, tremble, error] = [(); 3].map(|()| Squares::new(size));
        Self { trail: Trail::default(), change, tremble, error, sum: 0.0 }
    }

    fn push(&mut self, image: Image, halves: &[Trail; 2]) {
        self.sum += image.mean();
        self.trail.push(image);
        self.add(halves);
    }

    fn add(&mut self, [one, two]: &[Trail; 2]) {
        let part = |of: fn(&Trail) -> Option<Vec<f64>>, sum: &mut Squares| {
            if let (Some(a), Some(r1), Some(r2)) = (of(&self.trail), of(one), of(two)) {
                sum.add(&a, [&r1, &r2]);
            }
        };
        part(Trail::values, &mut self.error);
        part(Trail::step, &mut self.change);
        part(Trail::bend, &mut self.tremble);
    }
}

/// Measures the flicker of indirect light of some variants, and draws it into images below `folder`. The change beyond
/// the reference's own is sqrt(mean((Δa − Δr₁)·(Δa − Δr₂))) / mean(r), where Δ is the difference of successive frames and
/// r₁, r₂ are the reference's two halves, whose noise cancels; trembling is the same of second differences over √3. Frames are
/// single ones, and beside them such as are averaged over shifts by parts of a pixel, whose edges do not jump.
///
/// # Errors
/// If a frame cannot be drawn or traced, or an image not be written.
pub fn measure(
    fixture: &mut Fixture,
    which: &[usize],
    course: &Course,
    references: &References,
    folder: &Path,
    progress: &mut dyn FnMut(Option<&Variant>),
) -> Result<Vec<Flicker>> {
    (course.frames > 2).then_some(()).context("flicker needs three frames or more")?;
    let (_, rate) = fixture.clock();
    let (scene, size) = (fixture.name(), course.size);
    let black = Image::filled(size[0], size[1], [0.0; 3]);
    // What frames before lend to it would be lent to images that are drawn twice.
    let lends = |variant: &Variant| variant.is_traced() || variant.average == Some(Switch::On);
    let smooth = |index: &usize| (!lends(&fixture.runners[*index].0)).then(|| Sums::new(size));
    let rows = |index: &usize| Rows { played: Sums::new(size), smooth: smooth(index), total: TotalError::new(size) };
    let mut rows: Vec<Rows> = which.iter().map(rows).collect();
    let mut own = Sums::new(size);
    let mut halves = [Trail::default(), Trail::default()];
    let (mut mean, mut total_mean) = (0.0, 0.0);
    lead_in(fixture, which, course)?;
    for frame in course.first..course.first + course.frames {
        let time = f64::from(frame) / f64::from(rate.max(1));
        fixture.set_seconds(time);
        let wanted = Wanted { scene: &scene, time, size, bounces: None, samples: course.samples };
        let found = references.get(fixture.tracer(), &wanted, &mut |_| progress(None))?;
        let both = found.estimate.halves(Layer::Indirect);
        mean += 0.5 * (both[0].mean() + both[1].mean()) / f64::from(course.frames);
        let totals = found.estimate.halves(Layer::Total);
        total_mean += 0.5 * (totals[0].mean() + totals[1].mean()) / f64::from(course.frames);
        halves.iter_mut().zip(both).for_each(|(trail, half)| trail.push(half));
        own.push(black.clone(), &halves);
        for (rows, &index) in rows.iter_mut().zip(which) {
            let traced = fixture.runners[index].0.is_traced();
            let light = if traced { fixture.trace(index, size)? } else { fixture.draw(index, size, 1)? };
            rows.total.push(&light.total, &totals);
            rows.played.push(light.indirect, &halves);
            if let Some(smooth) = &mut rows.smooth {
                smooth.push(fixture.draw(index, size, course.aa)?.indirect, &halves);
            }
            progress(Some(&fixture.runners[index].0));
        }
    }
    let mut all = Vec::new();
    for (rows, &index) in rows.iter().zip(which) {
        let sums = &rows.played;
        let mut flicker = Flicker {
            scene: scene.clone(),
            variant: fixture.runners[index].0.name.clone(),
            frames: course.frames,
            change: sums.change.root() / mean,
            reference: own.change.root() / mean,
            tremble: Some(sums.tremble.root() / mean),
            reference_tremble: Some(own.tremble.root() / mean),
            error: Some(sums.error.root() / mean),
            bias: Some(sums.sum / f64::from(course.frames) / mean - 1.0),
            total_error: Some(rows.total.squares.root() / total_mean),
            total_bias: Some(rows.total.sum / f64::from(course.frames) / total_mean - 1.0),
            smooth: rows.smooth.as_ref().map(|smooth| smooth.change.root() / mean),
            ..Flicker::default()
        };
        flicker.picture = Some(draw(folder, &flicker, size, [&own.change, &sums.change, &sums.tremble], mean)?);
        all.push(flicker);
    }
    Ok(all)
}

/// Draws the frames that come before, for variants that average theirs: what they drew last may be of another time.
fn lead_in(fixture: &mut Fixture, which: &[usize], course: &Course) -> Result<()> {
    let (_, rate) = fixture.clock();
    let averaged = |&index: &usize| fixture.runners[index].0.average == Some(Switch::On);
    let which: Vec<usize> = which.iter().copied().filter(averaged).collect();
    for frame in course.first.saturating_sub(LEAD_IN)..course.first {
        fixture.set_seconds(f64::from(frame) / f64::from(rate.max(1)));
        for &index in &which {
            fixture.draw(index, course.size, 1)?;
        }
    }
    Ok(())
}

/// Draws the reference's change, that beyond it and its trembling side by side; gives the file's name.
fn draw(folder: &Path, flicker: &Flicker, size: [u32; 2], squares: [&Squares; 3], mean: f64) -> Result<String> {
    let (scene, variant) = (&flicker.scene, &flicker.variant);
    let file = format!("pictures/{}_flicker.png", picture::file_name(&format!("{scene}_{variant}")));
    let captions = ["the reference changes", "beyond that", "trembling"];
    let shown = squares.iter().zip(captions).map(|(squares, caption)| {
        let image = squares.image(size, 1.0 / mean).context("an image of another size")?;
        Ok((image, caption.to_owned()))
    });
    picture::row(&folder.join(&file), &format!("{scene}: {variant}"), &shown.collect::<Result<Vec<_>>>()?, EXPOSURE)?;
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;
    use xxhash_rust::xxh3::xxh3_64;

    const SIZE: [u32; 2] = [2, 1];

    /// Change and trembling of a row of grey images, held against a reference whose halves differ by a constant.
    fn measured(images: [f32; 4], reference: [f32; 4]) -> [f64; 2] {
        let image = |value: f32| Image::filled(SIZE[0], SIZE[1], [value; 3]);
        let mut sums = Sums::new(SIZE);
        let mut halves = [Trail::default(), Trail::default()];
        for (a, r) in images.into_iter().zip(reference) {
            halves[0].push(image(r));
            halves[1].push(image(r + 0.5));
            sums.push(image(a), &halves);
        }
        [sums.change.root(), sums.tremble.root()]
    }

    #[test]
    fn only_change_beyond_the_references_counts() {
        let reference = [1.0, 2.0, 3.0, 4.0];
        let near = |found: [f64; 2], wanted: [f64; 2]| {
            assert!(found.iter().zip(wanted).all(|(f, w)| (f - w).abs() < 1e-6), "{found:?}, not {wanted:?}");
        };
        // The image moves with the reference, half as far, and not at all.
        near(measured([5.0, 6.0, 7.0, 8.0], reference), [0.0, 0.0]);
        near(measured([5.0, 5.5, 6.0, 6.5], reference), [0.5, 0.0]);
        near(measured([5.0; 4], reference), [1.0, 0.0]);
        // To and fro beside it: the second difference of ±1 is 4.
        near(measured([6.0, 5.0, 8.0, 7.0], reference), [2.0, 4.0 / 3.0_f64.sqrt()]);
    }

    #[test]
    fn errors_are_those_of_each_frame_without_the_references_noise() {
        let image = |value: f32| Image::filled(SIZE[0], SIZE[1], [value; 3]);
        let mut sums = Sums::new(SIZE);
        let mut halves = [Trail::default(), Trail::default()];
        for (a, r) in [(1.0, 2.0), (3.0, 2.0), (4.0, 3.0)] {
            halves[0].push(image(r + 0.25));
            halves[1].push(image(r - 0.25));
            sums.push(image(a), &halves);
        }
        // (±1 − ¼)(±1 + ¼) in each.
        assert!((sums.error.root() - (1.0_f64 - 0.0625).sqrt()).abs() < 1e-6 && (sums.sum - 8.0).abs() < 1e-6);
    }

    /// Noise that is another one in each frame, of variance s²: the step's is 2 s², that of the second difference 6 s².
    #[test]
    fn noise_changes_as_much_as_it_trembles() {
        let size = [64, 64];
        let mut sums = Sums::new(size);
        let mut halves = [Trail::default(), Trail::default()];
        for frame in 0..12 {
            // Even from 0 to 1.
            let random =
                |index: u32| (xxh3_64(&[frame, index].map(u32::to_le_bytes).concat()) >> 40) as f32 / 2_f32.powi(24);
            let pixels = (0..size[0] * size[1]).map(|pixel| [0, 1, 2].map(|c| random(3 * pixel + c)));
            halves.iter_mut().for_each(|half| half.push(Image::filled(size[0], size[1], [0.3; 3])));
            sums.push(
                Image::from_pixels(size[0], size[1], pixels.collect()).unwrap_or_else(|| unreachable!()),
                &halves,
            );
        }
        let expected = (2.0_f64 / 12.0).sqrt();
        for found in [sums.change.root(), sums.tremble.root()] {
            assert!((found / expected - 1.0).abs() < 0.02, "{found}, not {expected}");
        }
    }
}
