#![allow(clippy::unwrap_used)]
use super::*;

fn flat(value: f32) -> Image {
    Image::filled(16, 16, [value; 3])
}

fn pictures(dir: &tempfile::TempDir) -> Pictures {
    Pictures::new(dir.path(), "test".into())
}

fn golden(actual: &Image, file: &Path, bless: bool, dir: &tempfile::TempDir) -> GoldenVerdict {
    check_golden(actual, file, &Golden::default(), bless, &pictures(dir)).unwrap()
}

#[test]
fn a_missing_golden_fails_and_says_how_to_make_it() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("goldens/a.png");
    let GoldenVerdict::Wrong(what) = golden(&flat(0.5), &file, false, &dir) else { panic!("a verdict from nothing") };
    assert!(what.contains("no golden image") && what.contains("a.png") && what.contains("--bless"), "{what}");
    assert!(what.contains("test.actual.png") && dir.path().join("test.actual.png").is_file(), "{what}");
    assert!(!file.exists(), "nobody asked to write it");
}

#[test]
fn blessing_writes_what_is_new_and_only_that() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("goldens/a.png");
    assert!(matches!(golden(&flat(0.5), &file, true, &dir), GoldenVerdict::Blessed));
    assert!(matches!(golden(&flat(0.5), &file, false, &dir), GoldenVerdict::Same));
    assert!(matches!(golden(&flat(0.5), &file, true, &dir), GoldenVerdict::Same));
    assert!(matches!(golden(&flat(0.2), &file, true, &dir), GoldenVerdict::Blessed));
    assert!(matches!(golden(&flat(0.2), &file, false, &dir), GoldenVerdict::Same));
}

#[test]
fn a_wrong_golden_fails_with_pictures_that_a_later_run_removes() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("a.png");
    golden(&flat(0.2), &file, true, &dir);
    let names = ["test.actual.png", "test.expected.png", "test.difference.png"];
    let GoldenVerdict::Wrong(what) = golden(&flat(0.6), &file, false, &dir) else { panic!("black is not white") };
    assert!(what.contains("mean FLIP") && names.iter().all(|name| what.contains(name)), "{what}");
    let shown = |name: &str| read_image(&dir.path().join(name)).unwrap().pixel(3, 3)[0];
    assert!((shown(names[0]) - 0.6).abs() < 0.01 && (shown(names[1]) - 0.2).abs() < 0.01);
    assert!(shown(names[2]) > 0.9, "too bright is red");
    golden(&flat(0.2), &file, false, &dir);
    assert!(names.iter().all(|name| !dir.path().join(name).exists()));
}

#[test]
fn a_golden_of_another_size_or_broken_fails() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("a.png");
    golden(&Image::filled(8, 16, [0.5; 3]), &file, true, &dir);
    let verdict = golden(&flat(0.5), &file, false, &dir);
    assert!(matches!(&verdict, GoldenVerdict::Wrong(what) if what.contains("8x16")), "{verdict:?}");
    std::fs::write(&file, "no picture").unwrap();
    let verdict = golden(&flat(0.5), &file, false, &dir);
    assert!(matches!(&verdict, GoldenVerdict::Wrong(what) if what.contains("a.png")), "{verdict:?}");
}

#[test]
fn nan_anywhere_fails() {
    let dir = tempfile::tempdir().unwrap();
    assert_eq!(non_finite(&flat(1.0), "total light", &pictures(&dir)).unwrap(), None);
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut image = flat(1.0);
        image.pixels_mut()[37][2] = bad;
        let what = non_finite(&image, "total light", &pictures(&dir)).unwrap().unwrap();
        assert!(what.contains("1 pixels, first at column 5 of row 2"), "{what}");
        assert!(what.contains("test.actual.exr") && dir.path().join("test.actual.exr").is_file(), "{what}");
    }
    let nan = || Expected { image: flat(f32::NAN), halves: None };
    let bounds = ErrorBounds { nrmse: Some(1e9), ..ErrorBounds::default() };
    let what = check_errors(&flat(1.0), &nan(), &bounds, &pictures(&dir)).unwrap().unwrap();
    assert!(what.contains("the reference holds NaN"), "{what}");
}

#[test]
fn errors_are_held_against_their_bounds() {
    let dir = tempfile::tempdir().unwrap();
    let expected = || Expected { image: Image::filled(32, 32, [1.0; 3]), halves: None };
    let check =
        |value: f32, bounds: ErrorBounds| check_errors(&flat(value), &expected(), &bounds, &pictures(&dir)).unwrap();
    let nrmse = ErrorBounds { nrmse: Some(0.2), ..ErrorBounds::default() };
    let bias = ErrorBounds { bias: Some(0.05), ..ErrorBounds::default() };
    assert_eq!(check(1.1, nrmse.clone()), None);
    assert!(check(1.3, nrmse).is_some_and(|what| what.contains("nrmse 0.3000, at most 0.2")));
    for name in ["actual.exr", "expected.exr", "difference.png", "figure.png"] {
        assert!(dir.path().join(format!("test.{name}")).is_file(), "{name}");
    }
    assert!(check(0.9, bias).is_some_and(|what| what.contains("bias -0.1000")), "too dark counts as much");
    let other = Expected { image: Image::filled(24, 24, [1.0; 3]), halves: None };
    let what = check_errors(&flat(1.0), &other, &ErrorBounds::default(), &pictures(&dir)).unwrap();
    assert!(what.is_some_and(|what| what.contains("24x24")));
}

#[test]
fn noise_of_the_reference_is_no_error() {
    let dir = tempfile::tempdir().unwrap();
    let bounds = ErrorBounds { nrmse: Some(0.01), ..ErrorBounds::default() };
    // Independent noise of both halves: an error of 0.5 each, and no correlation over the image.
    let noisy = |phase: usize| {
        let pixels = (0..256).map(|i| [1.0 + 0.5 * f32::from(i16::from((i >> phase) & 1 == 0) * 2 - 1); 3]).collect();
        Image::from_pixels(16, 16, pixels).unwrap()
    };
    let (a, b) = (noisy(0), noisy(1));
    let pixels = a.pixels().iter().zip(b.pixels()).map(|(a, b)| [0, 1, 2].map(|c| 0.5 * (a[c] + b[c]))).collect();
    let image = Image::from_pixels(16, 16, pixels).unwrap();
    let with = Expected { image: image.clone(), halves: Some([a, b]) };
    assert_eq!(check_errors(&flat(1.0), &with, &bounds, &pictures(&dir)).unwrap(), None);
    let what = check_errors(&flat(1.1), &with, &bounds, &pictures(&dir)).unwrap().unwrap();
    assert!(what.contains("nrmse 0.1000") && what.contains("noise of the reference 0.35"), "{what}");
    let without = Expected { image, halves: None };
    assert!(check_errors(&flat(1.0), &without, &bounds, &pictures(&dir)).unwrap().is_some());
}

#[test]
fn a_single_bit_between_two_runs_is_seen() {
    let dir = tempfile::tempdir().unwrap();
    let first = flat(1.0);
    let mut second = first.clone();
    assert_eq!(check_equal(&first, &second, &pictures(&dir)).unwrap(), None);
    second.pixels_mut()[18][0] = f32::from_bits(1.0f32.to_bits() + 1);
    let what = check_equal(&first, &second, &pictures(&dir)).unwrap().unwrap();
    assert!(what.contains("1 pixels, first at column 2 of row 1") && what.contains("test.expected.exr"), "{what}");
}

/// The tests that ship, with their golden images.
fn shipped() -> Vec<(crate::scene_test::TestCase, crate::scene_test::SceneTest)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/scenes");
    let cases = crate::scene_test::discover(&[folder]).unwrap();
    cases.into_iter().map(|case| (case.clone(), crate::scene_test::SceneTest::read(&case.path).unwrap())).collect()
}

fn black(image: &Image) -> Image {
    let [width, height] = image.size();
    Image::filled(width, height, [0.0; 3])
}

/// All columns moved to the right, the first ones repeated.
fn shifted(image: &Image, by: usize) -> Image {
    let width = image.size()[0] as usize;
    let mut shifted = image.clone();
    for row in shifted.pixels_mut().chunks_mut(width) {
        let first = row[0];
        row.rotate_right(by);
        row[..by].fill(first);
    }
    shifted
}

fn scaled(image: &Image, factor: f32) -> Image {
    let mut scaled = image.clone();
    scaled.pixels_mut().as_flattened_mut().iter_mut().for_each(|value| *value *= factor);
    scaled
}

/// A screen shows no more than white.
fn shown(image: &Image) -> Image {
    let mut shown = image.clone();
    shown.pixels_mut().as_flattened_mut().iter_mut().for_each(|value| *value = value.min(1.0));
    shown
}

/// What each golden image is there for: a black image, one a few pixels aside and one of 1.1 times the light are found.
#[test]
fn every_golden_tells_black_shifted_and_brighter_pictures() {
    let dir = tempfile::tempdir().unwrap();
    let mut missed = Vec::new();
    let mut count = 0;
    for (case, test) in shipped() {
        let Some(bounds) = &test.expect.golden else { continue };
        for time in test.golden_times() {
            let file = case.golden(time);
            let golden = read_image(&file).unwrap();
            count += 1;
            let mut check = |what: &str, image: &Image, is_same: bool| {
                let verdict = check_golden(image, &file, bounds, false, &pictures(&dir)).unwrap();
                if matches!(verdict, GoldenVerdict::Same) != is_same {
                    missed.push(format!("{} at {time} s, {what}: {verdict:?}", case.name));
                }
            };
            check("itself", &golden, true);
            check("black", &black(&golden), false);
            check("shifted", &shifted(&golden, 3), false);
            check("brighter", &shown(&scaled(&golden, 1.1)), false);
        }
    }
    assert!(count > 10 && missed.is_empty(), "{count} golden images: {missed:#?}");
}

/// Each bound on the error against a reference is so tight that 1.1 times the light, or none, is beyond it.
#[test]
fn every_error_bound_tells_black_and_brighter_pictures() {
    let dir = tempfile::tempdir().unwrap();
    // Half of it dark: an image with a nrmse as large as its mean, which bounds on the error allow.
    let mut truth = flat(1.0);
    truth.pixels_mut()[..100].fill([0.2; 3]);
    let mut missed = Vec::new();
    for (case, test) in shipped() {
        // The diffusion is off by more than that; golden images hold it.
        let has_golden_elsewhere = case.name.starts_with("truth_diffusion");
        for bound in &test.expect.errors {
            let expected = || Expected { image: truth.clone(), halves: None };
            let mut tells = |what: &str, image: &Image, is_right: bool| {
                let wrong = check_errors(image, &expected(), &bound.max, &pictures(&dir)).unwrap();
                if wrong.is_none() != is_right {
                    missed.push(format!("{}, {what}: {:?}", case.name, bound.max));
                }
            };
            tells("itself", &truth, true);
            tells("black", &black(&truth), false);
            tells("brighter", &scaled(&truth, 1.1), has_golden_elsewhere);
        }
    }
    assert!(missed.is_empty(), "{missed:#?}");
}

#[test]
fn small_things_that_are_wrong_fail_a_golden() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("a.png");
    let big = Image::filled(128, 128, [0.2; 3]);
    golden(&big, &file, true, &dir);
    let mut spot = big.clone();
    spot.pixels_mut()[128 * 60..128 * 62].fill([0.35; 3]);
    let GoldenVerdict::Wrong(what) = golden(&spot, &file, false, &dir) else { panic!("two rows of 128 are other") };
    assert!(what.contains("99 % of the pixels"), "{what}");
    let verdict = check_golden(&spot, &file, &Golden { flip_p99: 1.0, ..Golden::default() }, false, &pictures(&dir));
    assert!(matches!(verdict.unwrap(), GoldenVerdict::Same), "the mean alone hides it");
}

#[test]
fn other_adapters_may_be_twice_as_far_from_a_golden() {
    let golden = Golden { flip: 0.02, flip_p99: 0.1, at: Some(vec![1.0]) };
    assert_eq!(golden.on(wgpu::DeviceType::Cpu), golden);
    let expected = Golden { flip: 0.04, flip_p99: 0.2, at: Some(vec![1.0]) };
    assert_eq!(golden.on(wgpu::DeviceType::DiscreteGpu), expected);
}
