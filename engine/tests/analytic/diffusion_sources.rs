//! What is injected into the diffusion's volumes: all flux that surfaces reflect or emit, whatever the light is, and however
//! many texels stand for all of them.

use crate::support::{Stage, gpu};
use glam::{Affine3A, Vec3};
use lightwell::assets::{Material, Shape};
use lightwell::gpu::{Gpu, ImageF32, read_buffer};
use lightwell::graph::FrameReport;
use lightwell::render::{GiMethod, Layer, RenderSettings, Renderer};
use lightwell::scene::LightShape;
use lightwell::world::{CellSize, Clpv, Transport};
use std::f32::consts::PI;

const CELL: f32 = 0.15;
const ALBEDO: Vec3 = Vec3::new(0.3, 0.5, 0.7);

/// A closed room of 2 m within the volume.
fn room(settings: Clpv) -> Stage {
    let mut stage = Stage::new(Vec3::new(0.0, 0.2, 0.9), Vec3::new(0.0, -0.2, -1.0), 24);
    stage.add_room(Vec3::splat(-1.0), Vec3::splat(2.0), ALBEDO);
    stage.clpv(Vec3::ZERO, settings);
    stage
}

fn settings() -> Clpv {
    Clpv {
        transport: Transport::Diffusion,
        cells: [16; 3],
        cell_size: CellSize::Meters(CELL),
        steps: 16,
        ..Default::default()
    }
}

struct Drawn {
    image: ImageF32,
    report: FrameReport,
    /// Injected into the finest cascade \[W\].
    flux: Vec3,
}

fn draw_with(gpu: &Gpu, stage: &Stage, settings: &RenderSettings) -> Drawn {
    let mut renderer = Renderer::new(gpu);
    let (image, report) = stage.render_with(gpu, &mut renderer, settings);
    let cells: Vec<[f32; 12]> =
        read_buffer(gpu, renderer.buffer("inject, cascade 0").expect("a volume")).expect("readable");
    // Î₀₀·h² = Φ·Y₀₀ of each lobe.
    let sum = cells.iter().fold(Vec3::ZERO, |sum, c| sum + Vec3::new(c[0], c[4], c[8]));
    Drawn { image, report, flux: sum * (CELL * CELL / 0.282_094_8) }
}

fn draw(gpu: &Gpu, stage: &Stage) -> Drawn {
    let settings = RenderSettings { gi: GiMethod::CLPV, only: Layer::Indirect, ..Default::default() };
    draw_with(gpu, stage, &settings)
}

fn mean(image: &ImageF32) -> f32 {
    image.rgba.iter().map(|p| p[0] + p[1] + p[2]).sum::<f32>() / image.rgba.len() as f32
}

fn assert_near(found: Vec3, expected: Vec3, tolerance: f32, what: &str) {
    let off = (found / expected - 1.0).abs().max_element();
    assert!(off < tolerance, "{what}: {found} in place of {expected}");
}

/// A light in the middle of a room shines on its walls with all its flux, whatever its shape.
#[test]
fn lights_of_every_shape_feed_the_volumes_with_all_their_flux() {
    let gpu = gpu();
    let intensity = Vec3::new(2.0, 1.0, 0.5);
    let half_size = glam::Vec2::new(0.2, 0.1);
    let lights = [
        (LightShape::Point, 4.0 * PI),
        (LightShape::Sphere { radius: 0.1 }, 4.0 * PI),
        (LightShape::Disc { radius: 0.2 }, PI),
        (LightShape::Rectangle { half_size }, PI),
        (LightShape::Tube { half_length: 0.2, radius: 0.02 }, PI * PI),
    ];
    for (shape, flux) in lights {
        let mut stage = room(settings());
        stage.light(shape, intensity, Vec3::ZERO, Vec3::NEG_Y);
        let drawn = draw(&gpu, &stage);
        assert_near(drawn.flux, ALBEDO * intensity * flux, 0.01, &format!("{shape:?}"));
        assert!(mean(&drawn.image) > 0.02, "{shape:?}: a room as dark as {}", mean(&drawn.image));
    }
}

#[test]
fn surfaces_that_emit_feed_the_volumes_with_all_their_flux() {
    let gpu = gpu();
    let mut stage = room(settings());
    let mut glow = Material::diffuse("glow", Vec3::splat(0.5));
    glow.emissive = Vec3::new(4.0, 2.0, 1.0);
    stage.add_material(Shape::Box { size: [0.4, 0.2, 0.3] }, glow, Affine3A::from_translation(Vec3::NEG_Y * 0.2));
    let area = 2.0 * (0.4 * 0.2 + 0.2 * 0.3 + 0.3 * 0.4);
    let drawn = draw(&gpu, &stage);
    assert_near(drawn.flux, Vec3::new(4.0, 2.0, 1.0) * (PI * area), 0.01, "a box that glows");
    assert!(mean(&drawn.image) > 0.02, "a room as dark as {}", mean(&drawn.image));
}

/// A room with a white light, a narrow bright one and a weak one.
fn lit_room(rsm_samples: u32) -> Stage {
    let mut stage = room(Clpv { rsm_samples, ..settings() });
    stage.light(LightShape::Point, Vec3::splat(1.0), Vec3::new(0.3, 0.4, -0.2), Vec3::NEG_Y);
    let spot = LightShape::Spot { inner: 0.02, outer: 0.05 };
    stage.light(spot, Vec3::new(200.0, 20.0, 5.0), Vec3::new(-0.3, 0.2, 0.1), Vec3::NEG_X);
    stage.light(LightShape::Point, Vec3::splat(1e-3), Vec3::new(-0.5, -0.4, 0.2), Vec3::NEG_Y);
    stage
}

/// Root of the mean square difference over the mean.
fn error(found: &ImageF32, wanted: &ImageF32) -> f32 {
    let pairs = found.rgba.iter().zip(&wanted.rgba);
    let square = pairs.map(|(a, b)| (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f32>()).sum::<f32>();
    (square / (3.0 * found.rgba.len() as f32)).sqrt() / (mean(wanted) / 3.0)
}

#[test]
fn texels_drawn_by_flux_stand_for_all_of_them() {
    let gpu = gpu();
    let all = draw(&gpu, &lit_room(0));
    let injections = |drawn: &Drawn| drawn.report.pass("inject, cascade 0").expect("a pass").counts.injections;
    assert_eq!(injections(&all), 13 * 64 * 64);
    let mut before = f32::INFINITY;
    for (samples, bound) in [(64, 0.8), (1024, 0.2), (16_384, 0.05)] {
        let drawn = draw(&gpu, &lit_room(samples));
        assert_eq!(injections(&drawn), u64::from(samples));
        // Each sample has an equal part of the flux of all channels together.
        let [found, wanted] = [&drawn, &all].map(|drawn| drawn.flux.element_sum());
        assert!((found / wanted - 1.0).abs() < 2e-3, "{samples} samples: {found} W in place of {wanted} W");
        let off = error(&drawn.image, &all.image);
        println!("{samples} samples: {off}");
        assert!(off < bound && off < before, "{samples} samples: {off}");
        before = off;
    }
}

/// The mean over random numbers goes towards the image of all texels: no part of the light is missing.
#[test]
fn the_mean_over_draws_is_that_of_all_texels() {
    let gpu = gpu();
    let all = draw(&gpu, &lit_room(0));
    let mut stage = lit_room(24);
    const DRAWS: usize = 32;
    let (mut sum, mut single) = (Vec3::ZERO, Vec::new());
    let mut image = ImageF32 { rgba: vec![[0.0; 4]; all.image.rgba.len()], ..all.image.clone() };
    for i in 0..DRAWS {
        // The jitter of the image seeds the draw; it moves the image by less than a millionth of a pixel.
        stage.view.jitter = [i as f32 * 1e-7, 0.0];
        let drawn = draw(&gpu, &stage);
        sum += drawn.flux / DRAWS as f32;
        single.push(error(&drawn.image, &all.image));
        for (mean, pixel) in image.rgba.iter_mut().zip(&drawn.image.rgba) {
            (0..4).for_each(|c| mean[c] += pixel[c] / DRAWS as f32);
        }
    }
    assert_near(sum, all.flux, 0.05, "flux by channel");
    let (off, one) = (error(&image, &all.image), single.iter().sum::<f32>() / DRAWS as f32);
    println!("{off} of the mean, {one} of one");
    assert!(off < 0.35 * one, "{off} of the mean of {DRAWS}, {one} of one");
}

#[test]
fn black_surfaces_have_no_texel_to_draw() {
    let gpu = gpu();
    let mut stage = lit_room(256);
    stage.scene.primitives.clear();
    stage.add_room(Vec3::splat(-1.0), Vec3::splat(2.0), Vec3::ZERO);
    let drawn = draw(&gpu, &stage);
    assert_eq!((drawn.flux, mean(&drawn.image)), (Vec3::ZERO, 0.0));
}

/// Light so strong or weak that its square leaves the range of floats is drawn too.
#[test]
fn samples_of_any_brightness_are_finite() {
    let gpu = gpu();
    for factor in [1e-12, 1e12] {
        let mut stage = lit_room(256);
        stage.scene.lights.iter_mut().for_each(|light| light.intensity *= factor);
        let drawn = draw(&gpu, &stage);
        assert!(mean(&drawn.image) > 0.0, "{factor}");
    }
}
