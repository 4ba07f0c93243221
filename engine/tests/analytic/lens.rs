//! The lens: what the camera makes of light, against formulas.

#![allow(clippy::unwrap_used)]

use crate::support::{Stage, gpu};
use glam::{Affine3A, Mat3, Vec3};
use lightwell::assets::{CubeTable, Material, Shape};
use lightwell::gpu::{Gpu, ImageF32, read_texture, read_texture_f32};
use lightwell::measure::srgb_decode;
use lightwell::render::{DisplaySettings, GiMethod, RenderSettings, Renderer};
use lightwell::world::{Bloom, Exposure, LUMENS_A_WATT, Lens, ToneMap};
use std::sync::Arc;

/// Nothing but a sky of that radiance.
fn sky(radiance: Vec3, lens: Lens) -> Stage {
    let mut stage = Stage::new(Vec3::ZERO, Vec3::NEG_Z, 8);
    stage.scene.sky = radiance;
    stage.view.camera.lens = lens;
    stage
}

/// What the display shows of it, decoded to linear light.
fn shown(gpu: &Gpu, stage: &Stage, settings: &RenderSettings) -> Vec3 {
    let mut renderer = Renderer::new(gpu);
    let settings = RenderSettings { gi: GiMethod::NONE, ..settings.clone() };
    stage.render_with(gpu, &mut renderer, &settings);
    let bytes = read_texture(gpu, renderer.display().unwrap(), 0, 0).unwrap();
    Vec3::from([0, 1, 2].map(|channel| srgb_decode(f32::from(bytes[channel]) / 255.0)))
}

fn by(gpu: &Gpu, radiance: Vec3, tone_map: ToneMap) -> Vec3 {
    shown(gpu, &sky(radiance, Lens { tone_map, ..Default::default() }), &RenderSettings::default())
}

/// A step of the display's 256, at the brightest.
const STEP: f32 = 0.0095;

fn luminance(color: Vec3) -> f32 {
    color.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

#[test]
fn tone_maps_follow_their_formulas() {
    let gpu = gpu();
    for color in [Vec3::splat(0.18), Vec3::new(0.6, 0.2, 0.05), Vec3::new(2.0, 0.5, 1.0), Vec3::new(0.0, 0.01, 30.0)] {
        let expected = color * (1.0 + luminance(color) / 16.0) / (1.0 + luminance(color));
        let reinhard = by(&gpu, color, ToneMap::Reinhard);
        assert!(reinhard.abs_diff_eq(expected.min(Vec3::ONE), STEP), "{color}: {reinhard}, not {expected}");
        let linear = by(&gpu, color, ToneMap::Linear);
        assert!(linear.abs_diff_eq(color.min(Vec3::ONE), STEP), "{color}: {linear}");
        // Hill's fit, with its matrices by rows.
        let input =
            Mat3::from_cols_array(&[0.59719, 0.35458, 0.04823, 0.076, 0.90834, 0.01566, 0.0284, 0.13383, 0.83777]);
        let output = Mat3::from_cols_array(&[
            1.60475, -0.53108, -0.07367, -0.10208, 1.10813, -0.00605, -0.00327, -0.07276, 1.07602,
        ]);
        let x = input.transpose() * color;
        let fit = (x * (x + 0.0245786) - 0.000090537) / (x * (0.983729 * x + 0.432951) + 0.238081);
        let expected = (output.transpose() * fit).clamp(Vec3::ZERO, Vec3::ONE);
        let aces = by(&gpu, color, ToneMap::Aces);
        assert!(aces.abs_diff_eq(expected, STEP), "{color}: {aces}, not {expected}");
    }
    // What is 4 times as bright as white becomes white.
    assert!(by(&gpu, Vec3::splat(4.0), ToneMap::Reinhard).min_element() > 0.99);
}

/// Grey stays grey, more light is never darker, and black is black. AgX: middle grey comes out at about its own level, and
/// 2⁴ times white is white.
#[test]
fn tone_maps_of_grey_are_grey_and_rise() {
    let gpu = gpu();
    for tone_map in ToneMap::ALL {
        let levels = [0.0, 1e-4, 0.01, 0.05, 0.18, 0.5, 1.0, 3.0, 16.0, 1e5, 1e30];
        let values = levels.map(|level| by(&gpu, Vec3::splat(level), tone_map));
        for (level, value) in levels.iter().zip(values) {
            assert!(value.max_element() - value.min_element() < STEP, "{tone_map:?} of {level}: {value}");
        }
        assert!(values[0] == Vec3::ZERO, "{tone_map:?}");
        assert!(values.windows(2).all(|pair| pair[0].y <= pair[1].y), "{tone_map:?}: {values:?}");
        assert!(values[10].y > 0.97, "{tone_map:?}: {values:?}");
        assert!((0.08..0.30).contains(&values[4].y), "{tone_map:?}: {values:?}");
    }
}

/// Film fades what is very bright to white; Reinhard's keeps the hue until a channel is cut off.
#[test]
fn bright_colours_fade_to_white_in_agx() {
    let gpu = gpu();
    let saturation = |color: Vec3| 1.0 - color.min_element() / color.max_element();
    let red = Vec3::new(1.0, 0.05, 0.05);
    for tone_map in [ToneMap::AgX, ToneMap::Neutral] {
        let (dim, bright) = (by(&gpu, 0.2 * red, tone_map), by(&gpu, 60.0 * red, tone_map));
        assert!(saturation(bright) < 0.5 * saturation(dim), "{tone_map:?}: {dim}, {bright}");
    }
    assert!(saturation(by(&gpu, red, ToneMap::Reinhard)) > 0.9);
}

/// White is what saturates the sensor: 1.2·2^EV₁₀₀ cd/m².
#[test]
fn a_photographic_exposure_shows_its_luminance_as_white() {
    let gpu = gpu();
    let exposure = Exposure::Photographic { f_number: 8.0, shutter: 1.0 / 125.0, iso: 100.0 };
    let white = 1.2 * exposure.ev100().unwrap().exp2() / LUMENS_A_WATT;
    let lens = Lens { exposure, tone_map: ToneMap::Linear, ..Default::default() };
    for share in [0.2, 0.5, 0.9] {
        let found = shown(&gpu, &sky(Vec3::splat(share * white), lens.clone()), &RenderSettings::default());
        assert!(found.abs_diff_eq(Vec3::splat(share), STEP), "{share}: {found}");
        // The scene's exposure and the window's come on top, in stops.
        let show = DisplaySettings { exposure: -1.0, ..Default::default() };
        let settings = RenderSettings { exposure: 0.5, show, ..Default::default() };
        let found = shown(&gpu, &sky(Vec3::splat(share * white), lens.clone()), &settings);
        assert!(found.abs_diff_eq(Vec3::splat(share / 2_f32.sqrt()), STEP), "{share}: {found}");
    }
}

#[test]
fn a_camera_may_expose_by_the_image() {
    let gpu = gpu();
    let lens = Lens { exposure: Exposure::Automatic, tone_map: ToneMap::Linear, ..Default::default() };
    for radiance in [1e-3, 1.0, 1e4] {
        let settings = RenderSettings { exposure: 3.0, ..Default::default() };
        let found = shown(&gpu, &sky(Vec3::splat(radiance), lens.clone()), &settings);
        assert!(found.abs_diff_eq(Vec3::splat(0.18), STEP), "{radiance}: {found}");
    }
}

/// The window's tone map goes before the camera's.
#[test]
fn a_window_may_choose_another_tone_map() {
    let gpu = gpu();
    let stage = sky(Vec3::splat(0.9), Lens { tone_map: ToneMap::AgX, ..Default::default() });
    let show = DisplaySettings { tone_map: Some(ToneMap::Linear), ..Default::default() };
    let found = shown(&gpu, &stage, &RenderSettings { show, ..Default::default() });
    assert!(found.abs_diff_eq(Vec3::splat(0.9), STEP), "{found}");
}

/// Black but for bright squares of that radiance, 128 pixels an edge.
fn spots(spots: &[(Vec3, f32)], bloom: Option<Bloom>) -> Stage {
    let mut stage = Stage::new(Vec3::Z, Vec3::ZERO, 128);
    for (place, radiance) in spots {
        let material = Material { emissive: Vec3::splat(*radiance), ..Material::diffuse("spot", Vec3::ZERO) };
        stage.add_material(Shape::Box { size: [0.06, 0.06, 0.01] }, material, Affine3A::from_translation(*place));
    }
    stage.view.camera.lens.bloom = bloom;
    stage
}

/// The radiance with bloom.
fn bloomed(gpu: &Gpu, stage: &Stage) -> ImageF32 {
    let mut renderer = Renderer::new(gpu);
    stage.render_with(gpu, &mut renderer, &RenderSettings { gi: GiMethod::NONE, ..Default::default() });
    read_texture_f32(gpu, renderer.target("radiance with bloom").unwrap()).unwrap()
}

fn sum(image: &ImageF32) -> f64 {
    image.rgba.iter().map(|pixel| f64::from(pixel[0])).sum()
}

#[test]
fn bloom_keeps_the_energy_of_a_spot() {
    let gpu = gpu();
    for radiance in [0.1, 1e6] {
        let stage = spots(&[(Vec3::ZERO, radiance)], None);
        let before = sum(&stage.render(&gpu, GiMethod::NONE, lightwell::render::Layer::Total));
        assert!(before > 0.0);
        for bloom in [Bloom::default(), Bloom { scatter: 1.0, radius: 0.1 }, Bloom { scatter: 0.5, radius: 0.25 }] {
            let after = bloomed(&gpu, &spots(&[(Vec3::ZERO, radiance)], Some(bloom)));
            let change = sum(&after) / before - 1.0;
            println!("{bloom:?} of {radiance}: {change:+.6}");
            assert!(change.abs() < 1e-3, "{bloom:?}: {change}");
            // Light arrives where there was none, and everywhere less the farther away it is.
            let row: Vec<f32> = (64..124).map(|x| after.rgba[64 * 128 + x][0]).collect();
            assert!(row[12] > 0.0 && row.windows(2).all(|pair| pair[1] <= pair[0] * 1.0001), "{row:?}");
        }
    }
}

#[test]
fn bloom_is_linear() {
    let gpu = gpu();
    let bloom = Some(Bloom { scatter: 0.4, ..Bloom::default() });
    let [a, b] = [(Vec3::new(-0.3, 0.2, 0.0), 3.0), (Vec3::new(0.4, -0.1, 0.0), 500.0)];
    let both = bloomed(&gpu, &spots(&[a, b], bloom));
    let twice = bloomed(&gpu, &spots(&[(a.0, 2.0 * a.1)], bloom));
    let [a, b] = [a, b].map(|spot| bloomed(&gpu, &spots(&[spot], bloom)));
    for (((a, b), both), twice) in a.rgba.iter().zip(&b.rgba).zip(&both.rgba).zip(&twice.rgba) {
        assert!((a[0] + b[0] - both[0]).abs() <= 1e-5 * both[0] + 1e-9, "{a:?} {b:?} {both:?}");
        assert!((2.0 * a[0] - twice[0]).abs() <= 1e-5 * twice[0], "{a:?} {twice:?}");
    }
}

/// An even image stays as it is, bit for bit nearly, up to its borders; and without scatter every image does.
#[test]
fn bloom_of_an_even_image_is_the_image() {
    let gpu = gpu();
    let lens = Lens { bloom: Some(Bloom { scatter: 0.7, radius: 1.0 }), ..Default::default() };
    let even = bloomed(&gpu, &sky(Vec3::splat(0.8), lens));
    assert!(even.rgba.iter().all(|pixel| (pixel[0] - 0.8).abs() < 1e-6));
    let spot = [(Vec3::new(0.1, 0.0, 0.0), 7.0)];
    let same = bloomed(&gpu, &spots(&spot, Some(Bloom { scatter: 0.0, ..Bloom::default() })));
    let plain = spots(&spot, None).render(&gpu, GiMethod::NONE, lightwell::render::Layer::Total);
    assert!(same.rgba.iter().zip(&plain.rgba).all(|(a, b)| a[..3] == b[..3]));
}

/// Nothing that is off runs a pass, nothing that rests runs one again, and what is measured stays.
#[test]
fn the_lens_runs_passes_only_where_it_is_asked_for() {
    let gpu = gpu();
    let settings = RenderSettings { gi: GiMethod::NONE, ..Default::default() };
    let spot = [(Vec3::ZERO, 7.0)];
    let (off, report) = spots(&spot, None).render_with(&gpu, &mut Renderer::new(&gpu), &settings);
    assert!(!report.passes.iter().any(|pass| pass.name.starts_with("bloom")), "{:?}", report.passes);
    let stage = spots(&spot, Some(Bloom::default()));
    let mut renderer = Renderer::new(&gpu);
    renderer.set_audit(true);
    stage.render_with(&gpu, &mut renderer, &settings);
    renderer.set_audit(false);
    let (on, report) = stage.render_with(&gpu, &mut renderer, &settings);
    assert!(!report.passes.iter().any(|pass| report.ran(&pass.name)), "{:?}", report.passes);
    assert!(on.rgba == off.rgba, "bloom is for the display alone");
}

// ---- Vignette and film ----

/// The display's bytes of an even image of 64 pixels an edge.
fn even(gpu: &Gpu, lens: Lens, moment: u64) -> Vec<u8> {
    let mut stage = sky(Vec3::splat(0.2140), Lens { tone_map: ToneMap::Linear, ..lens });
    stage.view.size = [64, 64];
    let mut renderer = Renderer::new(gpu);
    stage.render_with(gpu, &mut renderer, &RenderSettings { gi: GiMethod::NONE, moment, ..Default::default() });
    read_texture(gpu, renderer.display().unwrap(), 0, 0).unwrap()
}

#[test]
fn the_corners_lose_what_the_vignette_says() {
    let gpu = gpu();
    for loss in [0.2, 0.5, 0.9] {
        let bytes = even(&gpu, Lens { vignette: loss, ..Default::default() }, 0);
        let at = |x: usize, y: usize| srgb_decode(f32::from(bytes[4 * (x + 64 * y)]) / 255.0);
        let law = |x: f32, y: f32| {
            let square = ((x - 31.5).powi(2) + (y - 31.5).powi(2)) / (2.0 * 32.0_f32.powi(2));
            0.214 / (1.0 + ((1.0 - loss).sqrt().recip() - 1.0) * square).powi(2)
        };
        for (x, y) in [(0, 0), (31, 31), (63, 0), (10, 50), (32, 0)] {
            let (found, expected) = (at(x, y), law(x as f32, y as f32));
            assert!((found - expected).abs() < 0.004, "{loss} at {x}, {y}: {found}, expected {expected}");
        }
    }
}

#[test]
fn grain_has_its_deviation_and_keeps_the_mean() {
    let gpu = gpu();
    // 0.214 is the middle of the display's range.
    let bytes = even(&gpu, Lens { grain: 0.05, ..Default::default() }, 1);
    let values: Vec<f64> = bytes.chunks(4).map(|pixel| f64::from(pixel[0]) / 255.0).collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let deviation = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt();
    assert!((mean - 0.5).abs() < 0.004 && (deviation - 0.05).abs() < 0.003, "{mean} {deviation}");
    let again = even(&gpu, Lens { grain: 0.05, ..Default::default() }, 1);
    let later = even(&gpu, Lens { grain: 0.05, ..Default::default() }, 2);
    assert!(bytes == again && bytes != later, "grain is that of the moment");
    let without = even(&gpu, Lens::default(), 1);
    assert!(without.iter().all(|byte| *byte == without[0] || *byte == 255));
}

/// Sharpening makes edges steeper and nothing brighter or darker than it was around them; an even image stays.
#[test]
fn sharpening_has_no_halo() {
    let gpu = gpu();
    assert!(even(&gpu, Lens { sharpening: 1.0, ..Default::default() }, 0) == even(&gpu, Lens::default(), 0));
    let bytes = |sharpening| {
        let mut stage = spots(&[(Vec3::new(0.1, 0.1, 0.0), 0.4), (Vec3::new(-0.2, 0.0, 0.0), 0.1)], None);
        stage.scene.sky = Vec3::splat(0.02);
        stage.view.camera.lens = Lens { sharpening, bloom: Some(Bloom::default()), ..Default::default() };
        let mut renderer = Renderer::new(&gpu);
        stage.render_with(&gpu, &mut renderer, &RenderSettings { gi: GiMethod::NONE, ..Default::default() });
        read_texture(&gpu, renderer.display().unwrap(), 0, 0).unwrap()
    };
    let (plain, sharp) = (bytes(0.0), bytes(1.0));
    let at = |bytes: &[u8], x: usize, y: usize| i32::from(bytes[4 * (x + 128 * y)]);
    let mut steeper = 0;
    for (x, y) in (1..127).flat_map(|y| (1..127).map(move |x| (x, y))) {
        let around = [(x, y), (x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)].map(|(i, j)| at(&plain, i, j));
        let (low, high) = (*around.iter().min().unwrap(), *around.iter().max().unwrap());
        assert!((low - 1..=high + 1).contains(&at(&sharp, x, y)), "{x}, {y}");
        steeper += usize::from(at(&sharp, x, y) != at(&plain, x, y));
    }
    assert!(steeper > 20, "{steeper} pixels changed");
}

// ---- Grading ----

/// A table that leaves colours as they are changes no pixel, one that swaps channels swaps them, and a domain is stretched.
#[test]
fn colour_tables_are_looked_up() {
    let gpu = gpu();
    let color = Vec3::new(0.1, 0.4, 0.8);
    let by = |table: Option<CubeTable>| {
        let mut stage = sky(color, Lens { tone_map: ToneMap::Linear, ..Default::default() });
        stage.view.camera.grading = table.map(Arc::new);
        shown(&gpu, &stage, &RenderSettings::default())
    };
    let plain = by(None);
    assert!(plain.abs_diff_eq(color, STEP));
    for size in [2, 7, 33] {
        assert!(by(Some(CubeTable::identity(size))).abs_diff_eq(plain, STEP), "{size}");
        let mut swapped = CubeTable::identity(size);
        swapped.entries.iter_mut().for_each(|entry| *entry = Vec3::new(entry.z, entry.y, entry.x));
        assert!(by(Some(swapped)).abs_diff_eq(Vec3::new(plain.z, plain.y, plain.x), STEP), "{size}");
    }
    let black = CubeTable { domain: [Vec3::ONE, Vec3::splat(2.0)], ..CubeTable::identity(4) };
    assert_eq!(by(Some(black)), Vec3::ZERO, "all is below the domain");
}
