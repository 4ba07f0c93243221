//! Images against what they should look like, and pictures of where they do not.

use super::document::ErrorBounds;
use anyhow::{Context, Result};
use lightwell::measure::{self, Comparison, Image, compare, difference_picture, read_image, write_image};
use std::path::{Path, PathBuf};

/// Where the pictures of a failure go.
pub struct Pictures {
    folder: PathBuf,
    /// What their names begin with.
    stem: String,
}

/// Endings of the pictures' names.
const KINDS: [&str; 6] = ["actual.png", "actual.exr", "expected.png", "expected.exr", "difference.png", "figure.png"];

impl Pictures {
    /// Pictures of that name; those of an earlier run are removed, so that none outlives its failure.
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

    /// Writes pictures and gives a sentence that names them.
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

/// What came of a look at a golden image.
#[derive(Debug)]
pub enum GoldenVerdict {
    /// Near enough.
    Same,
    /// Written anew.
    Blessed,
    /// Not as it should be, in words.
    Wrong(String),
}

/// Compares what a screen shows with a golden image, or keeps it as the golden image if `bless` is set.
///
/// # Errors
/// If a file cannot be written.
pub fn check_golden(
    actual: &Image,
    file: &Path,
    max_flip: f64,
    bless: bool,
    pictures: &Pictures,
) -> Result<GoldenVerdict> {
    let golden = file.is_file().then(|| read_image(file));
    if bless {
        let same = matches!(&golden, Some(Ok(golden)) if golden.size() == actual.size() && golden.to_srgb8() == actual.to_srgb8());
        return if same { Ok(GoldenVerdict::Same) } else { write_golden(actual, file) };
    }
    let golden = match golden {
        None => {
            let see = pictures.write(&[("actual.png", actual)])?;
            return Ok(GoldenVerdict::Wrong(format!(
                "there is no golden image {}: {see}; {HOW_TO_BLESS}",
                file.display()
            )));
        }
        Some(Err(error)) => return Ok(GoldenVerdict::Wrong(format!("the golden image cannot be read: {error}"))),
        Some(Ok(golden)) => golden,
    };
    let difference = match compare(actual, &golden) {
        Ok(comparison) if comparison.flip <= max_flip => return Ok(GoldenVerdict::Same),
        Ok(comparison) => format!("mean FLIP {:.4}, at most {max_flip}", comparison.flip),
        Err(error) => error.to_string(),
    };
    let see = pictures.write_shown(actual, &golden)?;
    Ok(GoldenVerdict::Wrong(format!("differs from {}: {difference}; {see}; {HOW_TO_BLESS}", file.display())))
}

const HOW_TO_BLESS: &str = "if it is as it should be, keep it with `lightwell test --bless` (or LIGHTWELL_BLESS=1)";

fn write_golden(actual: &Image, file: &Path) -> Result<GoldenVerdict> {
    if let Some(folder) = file.parent() {
        std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
    }
    write_image(file, actual)?;
    Ok(GoldenVerdict::Blessed)
}

/// Measures radiance against a reference; what is out of bounds, in words.
///
/// # Errors
/// If a picture cannot be written.
pub fn check_errors(
    actual: &Image,
    expected: &Image,
    bounds: &ErrorBounds,
    pictures: &Pictures,
) -> Result<Option<String>> {
    let size = actual.size();
    let Some(expected) = expected.reduced(size) else {
        let [width, height] = expected.size();
        return Ok(Some(format!(
            "the reference has {width}x{height} pixels, no whole multiple of {}x{}",
            size[0], size[1]
        )));
    };
    let broken = match compare(actual, &expected) {
        Ok(comparison) => broken_bounds(&comparison, bounds),
        Err(error) => vec![error.to_string()],
    };
    if broken.is_empty() {
        return Ok(None);
    }
    let see = pictures.write_radiance(actual, &expected)?;
    Ok(Some(format!("{}; {see}", broken.join(", "))))
}

fn broken_bounds(comparison: &Comparison, bounds: &ErrorBounds) -> Vec<String> {
    if comparison.exactly_zero == Some(false) {
        return vec!["the reference is black, but the image is not exactly zero".to_owned()];
    }
    let broken = bounds.named().filter_map(|(name, bound)| {
        let value = match name {
            "nrmse" => comparison.nrmse,
            "bias" => comparison.bias,
            "rmse" => comparison.rmse,
            "p95" => comparison.p95,
            _ => comparison.flip,
        };
        // NaN is within no bound.
        (!(value.abs() <= bound)).then(|| format!("{name} {value:.4}, at most {bound}"))
    });
    broken.collect()
}

/// Bits that differ between two runs, in words.
///
/// # Errors
/// If a picture cannot be written.
pub fn check_equal(first: &Image, second: &Image, pictures: &Pictures) -> Result<Option<String>> {
    let Some(([x, y], count)) = first.first_bit_difference(second) else { return Ok(None) };
    let see = pictures.write_radiance(second, first)?;
    Ok(Some(format!(
        "a second run, with fresh renderer and the times in reverse, differs in {count} pixels, first at column {x} of row {y}; {see}"
    )))
}
