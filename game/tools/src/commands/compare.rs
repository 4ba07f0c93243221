//! `lightwell compare`: how far an image is from a reference.

use crate::cli::{CompareArgs, Metric};
use anyhow::{Context, Result};
use lightwell::measure::{self, Comparison, Image};
use lightwell_runtime::say;
use std::process::ExitCode;

/// Prints the metrics and writes the difference image; exit code 1 past a bound.
///
/// # Errors
/// If an image cannot be read or the two cannot be compared.
pub fn run(args: &CompareArgs) -> Result<ExitCode> {
    let image = measure::read_image(&args.image)?;
    let reference = measure::read_image(&args.reference)?;
    let pair = || format!("cannot compare {} with {}", args.image.display(), args.reference.display());
    let mut result = measure::compare(&image, &reference).with_context(pair)?;
    if let [first, second] = &args.halves[..] {
        let halves = [measure::read_image(first)?, measure::read_image(second)?];
        take_noise_out(&mut result, &image, &halves)?;
    }
    let mut metrics = args.metric.clone();
    metrics.extend(args.max.iter().map(|&(metric, _)| metric));
    let mut exceeded = false;
    let mut done = Vec::new();
    for metric in metrics {
        if done.contains(&metric) {
            continue;
        }
        done.push(metric);
        exceeded |= print_metric(metric, &result, args);
    }
    match result.exactly_zero {
        Some(true) => say!("the reference is black, and the image is exactly zero, as it must be"),
        Some(false) => {
            say!("the reference is black, but the image is not exactly zero");
            exceeded |= !args.max.is_empty();
        }
        None => {}
    }
    if let Some(path) = &args.difference {
        measure::write_image(path, &measure::difference_picture(&image, &reference)?)?;
        say!("difference picture: {}", path.display());
    }
    if let Some(path) = &args.figure {
        measure::write_image(path, &measure::figure(&image, &reference)?)?;
        say!("image, reference and difference: {}", path.display());
    }
    Ok(if exceeded { ExitCode::from(1) } else { ExitCode::SUCCESS })
}

/// Measures nrmse and rmse against two halves of the reference, so that its noise is no error, and prints that noise.
fn take_noise_out(result: &mut Comparison, image: &Image, [first, second]: &[Image; 2]) -> Result<()> {
    let unbiased = measure::two_halves(image, first, second).context("cannot compare with the two halves")?;
    result.nrmse = unbiased.nrmse;
    result.rmse = unbiased.squared_error.max(0.0).sqrt();
    say!("{:<6}{:>14.6}  of the reference, taken out of nrmse and rmse", "noise", unbiased.noise);
    Ok(())
}

/// Prints one metric with its bound, if it has one; says whether it is past it.
fn print_metric(metric: Metric, result: &Comparison, args: &CompareArgs) -> bool {
    let (name, value) = match metric {
        Metric::Nrmse => ("nrmse", result.nrmse),
        Metric::Rmse => ("rmse", result.rmse),
        Metric::Bias => ("bias", result.bias),
        Metric::P95 => ("p95", result.p95),
        Metric::Flip => ("flip", result.flip),
    };
    let bound = args.max.iter().filter(|(of, _)| *of == metric).map(|&(_, bound)| bound).reduce(f64::min);
    let exceeded = bound.is_some_and(|bound| value.abs() > bound);
    let verdict = match bound {
        Some(bound) if exceeded => format!("  past the bound {bound}"),
        Some(bound) => format!("  within the bound {bound}"),
        None => String::new(),
    };
    say!("{name:<6}{value:>14.6}{verdict}");
    exceeded
}
