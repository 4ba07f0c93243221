//! Comparison of images with what a test expects, and images of the differences.

use super::document::{ErrorBounds, Golden};
use anyhow::{Context, Result};
use lightwell::measure::{
    self, Comparison, Image, MeasureError, compare, difference_picture, read_image, two_halves, write_image,
};
use std::path::{Path, PathBuf};

/// Where the images of a failure go.
pub struct Pictures {
    folder: PathBuf,
    /// The prefix of their names.
    stem: String,
}

/// Endings of the images' names.
const KINDS: [&str; 6] = ["actual.png", "actual.exr", "expected.png", "expected.exr", "difference.png", "figure.png"];

impl Pictures {
    /// Images of that name; those of an earlier run are removed, so that none outlives its failure.
    pub fn new(folder: &Path, stem: String) -> Self {
        let pictures = Self { folder: folder.to_owned(), stem };
        for kind in KINDS {
            // Mostly there is none.
            let _ = std::fs::remove_file(pictures.path(kind));
        }
        pictures
    }

    fn path(&self, kind: &str) -> PathBuf {
        self.folder.join(format!("{}.{kind}", self.stem))
    }

    /// Writes images and gives a sentence that names them.
    fn write(&self, pictures: &[(&str, &Image)]) -> Result<String> {
        let mut names = Vec::new();
        for (kind, image) in pictures {
            let path = self.path(kind);
            if let Some(folder) = path.parent() {
                let failed = || format!("cannot make the folder {}", folder.display());
                std::fs::create_dir_all(folder).with_context(failed)?;
            }
            write_image(&path, image)?;
            names.push(path.display().to_string());
        }
        Ok(format!("see {}", names.join(", ")))
    }

    /// Two images as a screen shows them, and their difference if they can be compared.
    fn write_shown(&self, actual: &Image, expected: &Image) -> Result<String> {
        let difference = difference_picture(actual, expected).ok();
        let mut pictures = vec![("actual.png", actual), ("expected.png", expected)];
        pictures.extend(difference.as_ref().map(|image| ("difference.png", image)));
        self.write(&pictures)
    }

    /// Two images of radiance, with a figure to look at.
    fn write_radiance(&self, actual: &Image, expected: &Image) -> Result<String> {
        let difference = difference_picture(actual, expected).ok();
        let figure = measure::figure(actual, expected).ok();
        let mut pictures = vec![("actual.exr", actual), ("expected.exr", expected)];
        pictures.extend(difference.as_ref().map(|image| ("difference.png", image)));
        pictures.extend(figure.as_ref().map(|image| ("figure.png", image)));
        self.write(&pictures)
    }
}

/// A NaN or infinity in an image, in words.
pub fn non_finite(image: &Image, what: &str, pictures: &Pictures) -> Result<Option<String>> {
    let Some([x, y]) = image.first_non_finite() else { return Ok(None) };
    let bad = image.pixels().iter().filter(|pixel| pixel.iter().any(|value| !value.is_finite())).count();
    let see = pictures.write(&[("actual.exr", image)])?;
    Ok(Some(format!("{what}: NaN or infinity in {bad} pixels, first at column {x} of row {y}; {see}")))
}

/// The result of the comparison with a golden image.
#[derive(Debug)]
pub enum GoldenVerdict {
    /// Near enough.
    Same,
    /// Rewritten.
    Blessed,
    /// Not as it should be, in words.
    Wrong(String),
}

/// Compares what a screen shows with a golden image. Where it does not match and `bless` is set, it becomes the golden
/// image itself; one that matches is left alone, so that goldens do not drift.
///
/// # Errors
/// If a file cannot be written.
pub fn check_golden(
    actual: &Image,
    file: &Path,
    max: &Golden,
    bless: bool,
    pictures: &Pictures,
) -> Result<GoldenVerdict> {
    let (difference, golden) = match file.is_file().then(|| read_image(file)) {
        None => (format!("there is no golden image {}", file.display()), None),
        Some(Err(error)) => (format!("the golden image cannot be read: {error}"), None),
        Some(Ok(golden)) => match compare(actual, &golden) {
            Ok(Comparison { flip, flip_p99, .. }) if flip <= max.flip && flip_p99 <= max.flip_p99 => {
                return Ok(GoldenVerdict::Same);
            }
            Ok(Comparison { flip, flip_p99, .. }) => {
                let measured = format!(
                    "mean FLIP {flip:.4}, at most {}; of 99 % of the pixels {flip_p99:.4}, at most {}",
                    max.flip, max.flip_p99
                );
                (format!("differs from {}: {measured}", file.display()), Some(golden))
            }
            Err(error) => (format!("differs from {}: {error}", file.display()), Some(golden)),
        },
    };
    if bless {
        return write_golden(actual, file);
    }
    let see = match &golden {
        Some(golden) => pictures.write_shown(actual, golden)?,
        None => pictures.write(&[("actual.png", actual)])?,
    };
    Ok(GoldenVerdict::Wrong(format!("{difference}; {see}; {HOW_TO_BLESS}")))
}

const HOW_TO_BLESS: &str = "if it is as it should be, keep it with `lightwell test --bless` (or LIGHTWELL_BLESS=1)";

fn write_golden(actual: &Image, file: &Path) -> Result<GoldenVerdict> {
    if let Some(folder) = file.parent() {
        std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
    }
    write_image(file, actual)?;
    Ok(GoldenVerdict::Blessed)
}

/// The reference of an image.
pub struct Expected {
    /// Linear radiance.
    pub image: Image,
    /// Two independent halves of it, where it is known only up to noise.
    pub halves: Option<[Image; 2]>,
}

/// Measures radiance against a reference; what is out of bounds, in words. Against two halves, `nrmse` and `rmse` are
/// free of the reference's noise.
///
/// # Errors
/// If an image cannot be written.
pub fn check_errors(
    actual: &Image,
    expected: &Expected,
    bounds: &ErrorBounds,
    pictures: &Pictures,
) -> Result<Option<String>> {
    let size = actual.size();
    let Some(reference) = expected.image.reduced(size) else {
        let [width, height] = expected.image.size();
        return Ok(Some(format!(
            "the reference has {width}x{height} pixels, no whole multiple of {}x{}",
            size[0], size[1]
        )));
    };
    let broken = match measured(actual, &reference, expected.halves.as_ref()) {
        Ok((comparison, noise)) => broken_bounds(&comparison, bounds, noise),
        Err(error) => vec![error.to_string()],
    };
    if broken.is_empty() {
        return Ok(None);
    }
    let see = pictures.write_radiance(actual, &reference)?;
    Ok(Some(format!("{}; {see}", broken.join(", "))))
}

/// All metrics, and the noise of the reference where it is known.
fn measured(
    actual: &Image,
    reference: &Image,
    halves: Option<&[Image; 2]>,
) -> Result<(Comparison, Option<f64>), MeasureError> {
    let comparison = compare(actual, reference)?;
    // Relative to black there is no noise; whether the image is black too is what counts.
    let Some([first, second]) = halves.filter(|_| comparison.exactly_zero.is_none()) else {
        return Ok((comparison, None));
    };
    let unbiased = two_halves(actual, first, second)?;
    let rmse = unbiased.squared_error.max(0.0).sqrt();
    Ok((Comparison { rmse, nrmse: unbiased.nrmse, ..comparison }, Some(unbiased.noise)))
}

fn broken_bounds(comparison: &Comparison, bounds: &ErrorBounds, noise: Option<f64>) -> Vec<String> {
    if comparison.exactly_zero == Some(false) {
        return vec!["the reference is black, but the image is not exactly zero".to_owned()];
    }
    let broken = bounds.named().filter_map(|(name, bound)| {
        let value = match name {
            "nrmse" => comparison.nrmse,
            "bias" => comparison.bias,
            "rmse" => comparison.rmse,
            "p95" => comparison.p95,
            "flip_p99" => comparison.flip_p99,
            _ => comparison.flip,
        };
        // NaN is within no bound.
        (!(value.abs() <= bound)).then(|| format!("{name} {value:.4}, at most {bound}"))
    });
    let mut broken: Vec<String> = broken.collect();
    if let (Some(last), Some(noise)) = (broken.last_mut(), noise) {
        last.push_str(&format!(" (noise of the reference {noise:.4})"));
    }
    broken
}

/// Bits that differ between two runs, in words.
///
/// # Errors
/// If an image cannot be written.
pub fn check_equal(first: &Image, second: &Image, pictures: &Pictures) -> Result<Option<String>> {
    let Some(([x, y], count)) = first.first_bit_difference(second) else { return Ok(None) };
    let see = pictures.write_radiance(second, first)?;
    Ok(Some(format!(
        "a second run, with fresh renderer and the times in reverse, differs in {count} pixels, first at column {x} of row {y}; {see}"
    )))
}

#[cfg(test)]
#[path = "images_tests.rs"]
mod tests;
