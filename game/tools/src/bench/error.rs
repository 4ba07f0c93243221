//! Errors against the reference, and the images that show them.

use super::fixture::{Fixture, Light};
use super::picture;
use super::results::{ErrorFigures, LayerError};
use anyhow::{Context, Result};
use lightwell::measure::{Image, compare, two_halves, write_image};
use lightwell::render::Layer;
use lightwell::render::reference::Estimate;
use std::path::Path;

/// The subject of an error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Time [s].
    pub time: f64,
    /// Image size [pixels].
    pub size: [u32; 2],
    /// Frames averaged.
    pub aa: u32,
    /// Indirect bounces of the reference.
    pub bounces: Option<u32>,
}

/// Errors of an image against both halves of its reference.
///
/// # Errors
/// If an image holds NaN or infinity.
pub fn layer_error(image: &Image, halves: &[Image; 2]) -> Result<LayerError> {
    let mean = mean(halves);
    let plain = compare(image, &mean)?;
    let unbiased = two_halves(image, &halves[0], &halves[1])?;
    Ok(LayerError {
        mean: plain.mean_reference,
        rmse: unbiased.squared_error.max(0.0).sqrt(),
        nrmse: unbiased.nrmse,
        noisy_nrmse: plain.nrmse,
        bias: plain.bias,
        p95: plain.p95,
        flip: plain.flip,
        noise: unbiased.noise,
    })
}

/// The mean of two halves.
pub fn mean(halves: &[Image; 2]) -> Image {
    let mut mean = halves[0].clone();
    for (pixel, other) in mean.pixels_mut().iter_mut().zip(halves[1].pixels()) {
        *pixel = [0, 1, 2].map(|c| 0.5 * (pixel[c] + other[c]));
    }
    mean
}

/// Takes the errors of one variant, the scene being at that time, and writes its images below `folder`.
///
/// # Errors
/// If it cannot be drawn, or holds NaN, or an image cannot be written.
pub fn measure(
    fixture: &mut Fixture,
    runner: usize,
    look: &Look,
    reference: &Estimate,
    folder: &Path,
) -> Result<ErrorFigures> {
    let traced = fixture.runners[runner].0.is_traced();
    let light = if traced { fixture.trace(runner, look.size)? } else { fixture.draw(runner, look.size, look.aa)? };
    let (scene, variant) = (fixture.name(), fixture.runners[runner].0.name.clone());
    let error = |image: &Image, layer| {
        layer_error(image, &reference.halves(layer)).with_context(|| format!("{scene}, {variant}"))
    };
    let mut figures = ErrorFigures {
        key: String::new(),
        time: look.time,
        size: look.size,
        aa: if traced { 1 } else { look.aa },
        bounces: look.bounces,
        reference_spp: reference.samples,
        total: error(&light.total, Layer::Total)?,
        direct: error(&light.direct, Layer::Direct)?,
        indirect: error(&light.indirect, Layer::Indirect)?,
        pictures: Vec::new(),
        scene: scene.clone(),
        variant: variant.clone(),
    };
    figures.pictures = pictures(&light, reference, look, &figures, folder, fixture.runners[runner].0.sweep.is_some())?;
    Ok(figures)
}

fn pictures(
    light: &Light,
    reference: &Estimate,
    look: &Look,
    figures: &ErrorFigures,
    folder: &Path,
    swept: bool,
) -> Result<Vec<String>> {
    let bounces = look.bounces.map_or(String::new(), |bounces| format!("_k{bounces}"));
    let base = picture::file_name(&format!("{}_{:.0}ms{bounces}_{}", figures.scene, 1e3 * look.time, figures.variant));
    let mut written = Vec::new();
    for (name, image, layer, error) in [
        ("total", &light.total, Layer::Total, &figures.total),
        ("indirect", &light.indirect, Layer::Indirect, &figures.indirect),
    ] {
        let reference = mean(&reference.halves(layer));
        let file = format!("pictures/{base}_{name}.png");
        let title = format!("{}, {name} light: {}", figures.scene, figures.variant);
        let caption = format!("nrmse {:.3}, bias {:+.3}", error.nrmse, error.bias);
        picture::three(&folder.join(&file), image, &reference, &title, &caption)?;
        written.push(file);
    }
    if swept {
        let of_reference = picture::file_name(&format!("{}_{:.0}ms{bounces}", figures.scene, 1e3 * look.time));
        let reference = mean(&reference.halves(Layer::Indirect));
        let files = [
            (format!("pictures/{base}_image.exr"), &light.indirect),
            (format!("pictures/{of_reference}_reference.exr"), &reference),
        ];
        for (file, image) in files {
            write_image(&folder.join(&file), image)?;
            written.push(file);
        }
    }
    Ok(written)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn noise_of_the_reference_is_no_error_of_the_image() {
        // The truth is 1 everywhere; the halves deviate from it independently.
        let noise = |seed: u32| {
            let value =
                |i: u32| 1.0 + ((i.wrapping_mul(747_796_405).wrapping_add(seed) >> 9) % 1000) as f32 / 2500.0 - 0.2;
            let pixels = (0..128 * 128).map(|i: u32| [value(i.wrapping_mul(2_654_435_761) ^ seed); 3]).collect();
            Image::from_pixels(128, 128, pixels).unwrap()
        };
        let halves = [noise(1), noise(77_777)];
        let error = layer_error(&Image::filled(128, 128, [1.0; 3]), &halves).unwrap();
        assert!(error.nrmse < 0.03 && error.noisy_nrmse > 0.05 && error.noise > 0.05, "{error:?}");
        let error = layer_error(&Image::filled(128, 128, [1.5; 3]), &halves).unwrap();
        assert!((error.nrmse - 0.5).abs() < 0.01 && (error.bias - 0.5).abs() < 0.01, "{error:?}");
    }

    #[test]
    fn a_black_reference_asks_for_zero() {
        let black = || Image::filled(4, 4, [0.0; 3]);
        let error = layer_error(&black(), &[black(), black()]).unwrap();
        assert_eq!((error.nrmse, error.bias), (0.0, 0.0));
        let error = layer_error(&Image::filled(4, 4, [0.1; 3]), &[black(), black()]).unwrap();
        assert!(error.nrmse.is_infinite());
    }
}
