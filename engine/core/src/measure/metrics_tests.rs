#![allow(clippy::unwrap_used)]
use super::*;
use proptest::prelude::*;

fn image(values: &[[f32; 3]]) -> Image {
    Image::from_pixels(values.len() as u32, 1, values.to_vec()).unwrap()
}

#[test]
fn analytic_values() {
    // Channel errors 1, 0, 0, 0, 2, 0; reference of mean 1.
    let reference = image(&[[1.0; 3], [1.0; 3]]);
    let result = compare(&image(&[[2.0, 1.0, 1.0], [1.0, -1.0, 1.0]]), &reference).unwrap();
    assert!((result.rmse - (5.0f64 / 6.0).sqrt()).abs() < 1e-12);
    assert_eq!(result.nrmse, result.rmse);
    assert!((result.bias - (5.0 / 6.0 - 1.0)).abs() < 1e-12);
    assert_eq!(result.p95, 2.0);
    assert_eq!(result.exactly_zero, None);
}

#[test]
fn percentile_is_the_nearest_rank() {
    let errors: Vec<[f32; 3]> = (1..=100).map(|i| [1.0 + i as f32 / 100.0; 3]).collect();
    let result = compare(&image(&errors), &image(&[[1.0; 3]; 100])).unwrap();
    assert!((result.p95 - 0.95).abs() < 1e-6, "{}", result.p95);
}

#[test]
fn equal_images_have_no_error() {
    let a = image(&[[0.2, 0.4, 0.8], [3.0, 0.0, 100.0]]);
    let result = compare(&a, &a).unwrap();
    assert_eq!((result.rmse, result.nrmse, result.bias, result.p95), (0.0, 0.0, 0.0, 0.0));
    assert!(result.flip < 1e-6);
}

#[test]
fn dark_reference_wants_exact_darkness() {
    let dark = image(&[[0.0; 3]; 2]);
    let same = compare(&dark, &dark).unwrap();
    assert_eq!((same.exactly_zero, same.nrmse, same.bias), (Some(true), 0.0, 0.0));
    let other = compare(&image(&[[0.0; 3], [0.0, 1e-30, 0.0]]), &dark).unwrap();
    assert_eq!((other.exactly_zero, other.nrmse), (Some(false), f64::INFINITY));
}

#[test]
fn what_cannot_be_compared_says_why() {
    let good = Image::filled(2, 3, [1.0; 3]);
    let size = compare(&Image::filled(3, 2, [1.0; 3]), &good).unwrap_err();
    assert!(size.to_string().contains("3x2") && size.to_string().contains("2x3"), "{size}");
    let mut bad = good.clone();
    bad.pixels_mut()[3][1] = f32::NAN;
    assert_eq!(compare(&bad, &good), Err(MeasureError::NonFinite { which: "image", at: [1, 1] }));
    assert_eq!(compare(&good, &bad), Err(MeasureError::NonFinite { which: "reference", at: [1, 1] }));
    let negative = Image::filled(2, 3, [-1.0; 3]);
    assert_eq!(compare(&good, &negative), Err(MeasureError::NegativeMean { mean: -1.0 }));
    let empty = Image::filled(0, 0, [0.0; 3]);
    assert_eq!(compare(&empty, &empty), Err(MeasureError::Empty));
}

#[test]
fn halves_remove_the_noise_of_the_reference() {
    // Truth 1, image 1.5, halves with noise of ±0.5 that is uncorrelated over the four pixels.
    let first = image(&[[1.5; 3], [1.5; 3], [0.5; 3], [0.5; 3]]);
    let second = image(&[[1.5; 3], [0.5; 3], [1.5; 3], [0.5; 3]]);
    let result = two_halves(&image(&[[1.5; 3]; 4]), &first, &second).unwrap();
    assert!((result.squared_error - 0.25).abs() < 1e-12);
    assert!((result.nrmse - 0.5).abs() < 1e-12);
    assert!((result.noise - 0.125f64.sqrt()).abs() < 1e-12, "{}", result.noise);
}

fn pictures() -> impl Strategy<Value = (Image, Image)> {
    (1u32..6, 1u32..6).prop_flat_map(|(width, height)| {
        let pixels = || prop::collection::vec(prop::array::uniform3(0.01f32..10.0), (width * height) as usize);
        (pixels(), pixels()).prop_map(move |(a, r)| {
            let picture = |pixels| Image::from_pixels(width, height, pixels).unwrap();
            (picture(a), picture(r))
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn rmse_bounds_the_error_of_the_mean((a, r) in pictures()) {
        let result = compare(&a, &r).unwrap();
        prop_assert!(result.rmse >= (result.mean_image - result.mean_reference).abs() - 1e-12);
        prop_assert!((0.0..=1.0).contains(&result.flip));
    }

    #[test]
    fn relative_errors_do_not_see_a_common_scale((a, r) in pictures(), power in -8i32..8) {
        let scale = 2f32.powi(power);
        let one = compare(&a, &r).unwrap();
        let other = compare(&a.map(|v| v * scale), &r.map(|v| v * scale)).unwrap();
        prop_assert!((one.nrmse - other.nrmse).abs() <= 1e-12 * one.nrmse.max(1.0));
        prop_assert!((one.bias - other.bias).abs() <= 1e-12);
        prop_assert!((one.p95 - other.p95).abs() <= 1e-12 * one.p95.max(1.0));
        // Exposure follows the reference, so FLIP sees the scale at most by rounding to 8 bits.
        prop_assert!((one.flip - other.flip).abs() < 0.01);
    }

    #[test]
    fn equal_halves_give_the_plain_error((a, r) in pictures()) {
        let plain = compare(&a, &r).unwrap();
        let halves = two_halves(&a, &r, &r).unwrap();
        prop_assert!((halves.nrmse - plain.nrmse).abs() < 1e-9);
        prop_assert_eq!(halves.noise, 0.0);
    }
}
