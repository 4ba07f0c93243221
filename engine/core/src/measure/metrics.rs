//! Errors of an image against a reference.

use super::Image;
#[cfg(feature = "flip")]
use super::flip::flip;

/// Why two images cannot be compared.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeasureError {
    /// Sizes differ.
    #[error(
        "the image is {}x{} pixels and the reference {}x{}: render both at one size", image[0], image[1], reference[0], reference[1]
    )]
    Size {
        /// Size of the image.
        image: [u32; 2],
        /// Size of the reference.
        reference: [u32; 2],
    },
    /// There are no pixels.
    #[error("the images have no pixels")]
    Empty,
    /// A value is NaN or infinite.
    #[error("the {which} holds NaN or infinity, first at column {} of row {}", at[0], at[1])]
    NonFinite {
        /// "image" or "reference".
        which: &'static str,
        /// Column and row from the top left, from 0.
        at: [u32; 2],
    },
    /// The mean of the reference is negative, so that nothing can be relative to it.
    #[error("the mean of the reference is {mean}: below zero, no relative error exists")]
    NegativeMean {
        /// Mean of the reference.
        mean: f64,
    },
}

/// Errors of an image against a reference (see the [module](super) for the definitions).
///
/// If [`exactly_zero`](Self::exactly_zero) is `Some(true)`, all errors are zero; if it is `Some(false)`, all relative errors are
/// infinite.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Mean of the image, over pixels and channels.
    pub mean_image: f64,
    /// Mean of the reference.
    pub mean_reference: f64,
    /// Root of the mean squared error, in the images' unit.
    pub rmse: f64,
    /// `rmse` relative to the mean of the reference.
    pub nrmse: f64,
    /// Relative error of the mean; positive: too bright.
    pub bias: f64,
    /// 95th percentile of the absolute error (nearest rank), relative to the mean of the reference.
    pub p95: f64,
    /// Mean FLIP error, 0..1.
    #[cfg(feature = "flip")]
    pub flip: f64,
    /// 99th percentile of the pixels' FLIP errors (nearest rank), 0..1: small parts of an image that are wrong.
    #[cfg(feature = "flip")]
    pub flip_p99: f64,
    /// Set where the mean of the reference is zero: whether the image is exactly zero, as it then must be.
    pub exactly_zero: Option<bool>,
}

/// Squared error against a noisy reference of which two independent halves are known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoHalves {
    /// mean((a − r₁)(a − r₂)): unbiased by the noise of the reference; may come out just below zero.
    pub squared_error: f64,
    /// Root of it (zero if below), relative to the mean of both halves.
    pub nrmse: f64,
    /// Standard error of the reference's pixels, sqrt(mean((r₁ − r₂)²)) / 2, relative to its mean.
    pub noise: f64,
}

/// Checks that two images can be compared at all.
pub(super) fn check_pair(image: &Image, reference: &Image) -> Result<(), MeasureError> {
    if image.size() != reference.size() {
        return Err(MeasureError::Size { image: image.size(), reference: reference.size() });
    }
    if image.pixels().is_empty() {
        return Err(MeasureError::Empty);
    }
    for (which, picture) in [("image", image), ("reference", reference)] {
        if let Some(at) = picture.first_non_finite() {
            return Err(MeasureError::NonFinite { which, at });
        }
    }
    Ok(())
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len().max(1) as f64;
    values.sum::<f64>() / count
}

/// `value / scale`, where zero over zero is zero.
fn relative(value: f64, scale: f64) -> f64 {
    if scale > 0.0 {
        value / scale
    } else if value == 0.0 {
        0.0
    } else {
        f64::INFINITY.copysign(value)
    }
}

/// All metrics of `image` against `reference`.
///
/// # Errors
/// If the sizes differ, there are no pixels, a value is not finite, or the mean of the reference is negative.
pub fn compare(image: &Image, reference: &Image) -> Result<Comparison, MeasureError> {
    check_pair(image, reference)?;
    let (mean_image, mean_reference) = (image.mean(), reference.mean());
    if mean_reference < 0.0 {
        return Err(MeasureError::NegativeMean { mean: mean_reference });
    }
    let mut errors: Vec<f64> =
        image.values().zip(reference.values()).map(|(a, r)| (f64::from(a) - f64::from(r)).abs()).collect();
    let rmse = mean(errors.iter().map(|e| e * e)).sqrt();
    let rank = (errors.len() * 95).div_ceil(100) - 1;
    let (_, &mut p95, _) = errors.select_nth_unstable_by(rank, f64::total_cmp);
    #[cfg(feature = "flip")]
    let flips = flip(image, reference);
    let zero = image.values().all(|v| v == 0.0);
    if mean_reference == 0.0 {
        let value = if zero { 0.0 } else { f64::INFINITY };
        return Ok(Comparison {
            mean_image,
            mean_reference,
            rmse,
            nrmse: value,
            bias: value,
            p95: value,
            #[cfg(feature = "flip")]
            flip: flips.mean(),
            #[cfg(feature = "flip")]
            flip_p99: flips.percentile(0.99),
            exactly_zero: Some(zero),
        });
    }
    Ok(Comparison {
        mean_image,
        mean_reference,
        rmse,
        nrmse: rmse / mean_reference,
        bias: mean_image / mean_reference - 1.0,
        p95: p95 / mean_reference,
        #[cfg(feature = "flip")]
        flip: flips.mean(),
        #[cfg(feature = "flip")]
        flip_p99: flips.percentile(0.99),
        exactly_zero: None,
    })
}

/// The squared error of `image` against the truth that `first` and `second` are independent, unbiased estimates of.
///
/// # Errors
/// Those of [`compare`].
pub fn two_halves(image: &Image, first: &Image, second: &Image) -> Result<TwoHalves, MeasureError> {
    check_pair(image, first)?;
    check_pair(image, second)?;
    let mean_reference = 0.5 * (first.mean() + second.mean());
    if mean_reference < 0.0 {
        return Err(MeasureError::NegativeMean { mean: mean_reference });
    }
    let (mut product, mut spread) = (0.0, 0.0);
    for ((a, r1), r2) in image.values().zip(first.values()).zip(second.values()) {
        let (a, r1, r2) = (f64::from(a), f64::from(r1), f64::from(r2));
        product += (a - r1) * (a - r2);
        spread += (r1 - r2) * (r1 - r2);
    }
    let count = image.values().len() as f64;
    let squared_error = product / count;
    Ok(TwoHalves {
        squared_error,
        nrmse: relative(squared_error.max(0.0).sqrt(), mean_reference),
        noise: relative(0.5 * (spread / count).sqrt(), mean_reference),
    })
}

#[cfg(test)]
#[path = "metrics_tests.rs"]
mod tests;
