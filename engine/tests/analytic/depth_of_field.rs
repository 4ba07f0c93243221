//! Depth of field of a thin lens: drawn frames against the path tracer and against the formula of the circle of confusion.

#![allow(clippy::unwrap_used)]

use crate::support::{Stage, gpu};
use glam::{Affine3A, Vec3};
use lightwell::assets::{Material, Shape};
use lightwell::gpu::{Gpu, ImageF32};
use lightwell::measure::Image;
use lightwell::render::reference::{PathTracer, TraceSettings, measure_throughput};
use lightwell::render::{GiMethod, Layer, RenderSettings, Renderer};
use lightwell::scene::{LightShape, ViewProjection};
use lightwell::world::{DepthOfField, Lens};

fn sum(image: &ImageF32) -> f64 {
    image.rgba.iter().map(|pixel| f64::from(pixel[0])).sum()
}

/// Radius of the lens \[m\].
const RADIUS: f32 = 0.2;

/// That lens for a view of 90°, focused at some distance: f = 240 mm/(2·tan 45°) = 120 mm, and f/(2N) is its radius.
fn lens(focus: f32) -> DepthOfField {
    DepthOfField { focus, f_number: 0.3, sensor_height: 240.0 }
}

/// Lit boards 2 m away before a wall with patches of up to that radiance; two boards stand nearer if `has_near`.
fn boards(edge: u32, focus: f32, brightest: f32, has_near: bool) -> Stage {
    let mut stage = Stage::new(Vec3::ZERO, Vec3::NEG_Z, edge);
    let mut board = |at: Vec3, size: [f32; 2], radiance: Vec3| {
        let material = Material { emissive: radiance, ..Material::diffuse("board", Vec3::ZERO) };
        stage.add_material(Shape::Box { size: [size[0], size[1], 0.01] }, material, Affine3A::from_translation(at));
    };
    board(Vec3::new(0.0, 0.0, -8.0), [18.0, 18.0], Vec3::new(0.1, 0.15, 0.3));
    for i in 0..25 {
        let [x, y] = [i % 5, i / 5].map(|n| 2.6 * (n as f32 - 2.0));
        board(Vec3::new(x, y, -7.9), [0.9, 0.9], Vec3::new(1.0, 0.6, 0.25) * brightest * (1 + i % 3) as f32 / 3.0);
    }
    for i in 0..4 {
        let at = Vec3::new(-0.6 + 0.5 * i as f32, 0.3 - 0.4 * (i % 2) as f32, -2.0);
        board(at, [0.3, 0.5], Vec3::new(0.2, 0.9, 0.3) * (1.0 + i as f32 * 0.3));
    }
    if has_near {
        board(Vec3::new(-0.45, -0.55, -1.0), [0.5, 0.5], Vec3::new(0.9, 0.2, 0.15));
        board(Vec3::new(0.7, 0.45, -0.9), [0.12, 1.0], Vec3::new(0.7, 0.7, 0.2));
    }
    stage.view.camera.lens.depth_of_field = Some(lens(focus));
    stage
}

fn traced(gpu: &Gpu, stage: &Stage, samples: u32) -> Image {
    let mut tracer = PathTracer::new(gpu);
    let settings = TraceSettings { bounces: Some(0), seed: 3 };
    tracer.begin(gpu, &stage.scene, &stage.view, &settings).unwrap();
    tracer.advance(gpu, samples).unwrap();
    tracer.estimate(gpu).unwrap().total()
}

/// The mean of 16 drawn images with shifted pixels.
fn drawn(gpu: &Gpu, stage: &mut Stage) -> ImageF32 {
    let mut renderer = Renderer::new(gpu);
    let settings = RenderSettings { gi: GiMethod::NONE, images: 16, ..Default::default() };
    let mut mean: Option<ImageF32> = None;
    for i in 0..16 {
        stage.view.jitter = [(i % 4) as f32 / 4.0 - 0.375, (i / 4) as f32 / 4.0 - 0.375];
        let image = stage.render_with(gpu, &mut renderer, &settings).0;
        let sum = mean.get_or_insert_with(|| ImageF32 { rgba: vec![[0.0; 4]; image.rgba.len()], ..image.clone() });
        for (sum, pixel) in sum.rgba.iter_mut().zip(&image.rgba) {
            (0..4).for_each(|channel| sum[channel] += pixel[channel] / 16.0);
        }
    }
    stage.view.jitter = [0.0; 2];
    mean.unwrap()
}

/// The drawn image comes close to the traced one, whatever is in focus; without the lens it is far from it. The worst are
/// bright patches that the edge of a blurred board in front hides, since the drawn image does not know them.
#[test]
fn drawn_depth_of_field_is_near_the_path_tracer() {
    let gpu = gpu();
    for (what, brightest, has_near, bounds) in [
        ("bright patches behind", 6.0, false, [0.12, 0.12, 0.16]),
        ("boards before and behind", 0.9, true, [0.07, 0.07, 0.1]),
        ("bright patches hidden by edges", 6.0, true, [0.3, 0.25, 0.35]),
    ] {
        for (focus, bound) in [2.0, 1.1, 7.0].into_iter().zip(bounds) {
            let mut stage = boards(128, focus, brightest, has_near);
            let truth = traced(&gpu, &stage, 512);
            let (blurred, bias) = crate::support::error(&drawn(&gpu, &mut stage), &truth);
            stage.view.camera.lens = Lens::default();
            let (sharp, _) = crate::support::error(&drawn(&gpu, &mut stage), &truth);
            let found =
                format!("{what}, focus at {focus} m: nrmse {blurred:.4}, bias {bias:+.4}; without a lens {sharp:.4}");
            println!("{found}");
            assert!(blurred < bound && blurred < 0.8 * sharp && bias.abs() < 0.01, "{found}");
        }
    }
}

/// A small bright board out of focus becomes a disc of the radius that the thin lens has: r·|1/s − 1/d|/(2·tan(fov/2)) heights.
#[test]
fn circles_of_confusion_have_the_radius_of_the_formula() {
    let gpu = gpu();
    for (focus, distance) in [(2.0, 8.0), (2.0, 1.2), (1.5, 40.0)] {
        let mut stage = Stage::new(Vec3::ZERO, Vec3::NEG_Z, 256);
        let material = Material { emissive: Vec3::splat(100.0), ..Material::diffuse("point", Vec3::ZERO) };
        let size = 0.02 * distance;
        let place = Affine3A::from_translation(Vec3::NEG_Z * distance);
        stage.add_material(Shape::Box { size: [size, size, 1e-4] }, material, place);
        stage.view.camera.lens.depth_of_field = Some(lens(focus));
        let radius = RADIUS * (1.0 / focus - 1.0 / distance).abs() / 2.0 * 256.0;
        let drawn = stage.render(&gpu, GiMethod::NONE, Layer::Total);
        let (total, square) = drawn.rgba.iter().enumerate().fold((0.0, 0.0), |(total, square), (i, pixel)| {
            let [x, y] = [i % 256, i / 256].map(|n| n as f64 - 127.5);
            (total + f64::from(pixel[0]), square + f64::from(pixel[0]) * (x * x + y * y))
        });
        // The mean square distance from the centre of a disc is half its radius squared; that of the square adds to it.
        let own = (0.02 * 128.0_f64).powi(2) / 6.0;
        let found = (2.0 * (square / total - own)).sqrt();
        println!("{distance} m: {found:.2} pixels, expected {radius:.2}");
        assert!((found / f64::from(radius) - 1.0).abs() < 0.1, "{distance} m: {found}, expected {radius}");
        // All the light is still there.
        stage.view.camera.lens = Lens::default();
        let sharp = sum(&stage.render(&gpu, GiMethod::NONE, Layer::Total));
        println!("{distance} m: {:.3} of the light", total / sharp);
    }
}

/// What is in focus keeps its bits where nothing blurred is near it, and an orthographic camera focuses nothing.
#[test]
fn what_is_in_focus_stays_sharp() {
    let gpu = gpu();
    let mut stage = boards(96, 2.0, 6.0, true);
    stage.scene.primitives.retain(|primitive| (primitive.world_from_object.translation.z + 2.0).abs() < 0.1);
    let blurred = stage.render(&gpu, GiMethod::NONE, Layer::Total);
    let lens = std::mem::take(&mut stage.view.camera.lens);
    let sharp = stage.render(&gpu, GiMethod::NONE, Layer::Total);
    let largest = blurred.rgba.iter().zip(&sharp.rgba).map(|(a, b)| (a[1] - b[1]).abs()).fold(0.0, f32::max);
    assert!(largest < 0.02, "{largest}");
    stage.view.camera.lens = lens;
    stage.view.camera.projection = ViewProjection::Orthographic { height: 3.0 };
    let settings = RenderSettings { gi: GiMethod::NONE, ..Default::default() };
    let (_, report) = stage.render_with(&gpu, &mut Renderer::new(&gpu), &settings);
    assert!(!report.ran("depth of field") && report.ran("compose"));
}

/// Lenses at the ends of what files allow make images of finite numbers, of the same light.
#[test]
fn extreme_lenses_make_finite_images() {
    let gpu = gpu();
    for (focus, f_number, sensor_height) in
        [(1e-3, 0.1, 1e4), (1e9, 0.1, 1e4), (1e-3, 1e4, 0.1), (1e9, 1e4, 0.1), (5.0, 2.8, 24.0)]
    {
        let mut stage = boards(32, 2.0, 6.0, true);
        stage.view.camera.lens.depth_of_field = Some(DepthOfField { focus, f_number, sensor_height });
        let drawn = stage.render(&gpu, GiMethod::NONE, Layer::Total);
        assert!(sum(&drawn) > 0.0, "{focus} {f_number} {sensor_height}");
        assert_eq!(traced(&gpu, &stage, 4).first_non_finite(), None);
    }
}

/// The tracer on the host has the same lens, path by path.
#[test]
fn both_path_tracers_have_the_same_lens() {
    let gpu = gpu();
    let mut stage = Stage::new(Vec3::ZERO, Vec3::NEG_Z, 24);
    for (x, distance) in [(-0.5, 1.0), (0.0, 2.0), (1.5, 5.0)] {
        let place = Affine3A::from_translation(Vec3::new(x, 0.0, -distance));
        stage.add(Shape::Box { size: [0.8, 0.8, 0.1] }, Vec3::new(0.7, 0.5, 0.2), place);
    }
    stage.light(LightShape::Directional, Vec3::splat(3.0), Vec3::ZERO, Vec3::NEG_Z);
    stage.view.camera.lens.depth_of_field = Some(lens(2.0));
    let settings = TraceSettings { bounces: Some(1), seed: 5 };
    let measured = measure_throughput(&gpu, &stage.scene, &stage.view, &settings, 8, 1).unwrap().unwrap();
    let (device, host) = (measured.device_image.total(), measured.host_image.total());
    let far =
        device.pixels().iter().zip(host.pixels()).filter(|(a, b)| (a[0] - b[0]).abs() > 1e-3 * (a[0] + b[0])).count();
    assert!(device.mean() > 0.0 && far <= 6, "{far} pixels differ");
}

/// A drawn frame with a lens that is kept has the bits of a fresh one, and its keys hold all that its passes bind.
#[test]
fn depth_of_field_is_reused_where_nothing_changes() {
    let gpu = gpu();
    let settings = RenderSettings { gi: GiMethod::NONE, display: false, ..Default::default() };
    let mut stage = boards(48, 2.0, 6.0, true);
    let (mut kept, mut audited) = (Renderer::new(&gpu), Renderer::new(&gpu));
    audited.set_audit(true);
    for focus in [2.0, 1.0, 5.0] {
        stage.view.camera.lens.depth_of_field = Some(lens(focus));
        let first = stage.render_with(&gpu, &mut kept, &settings).0;
        let fresh = stage.render_with(&gpu, &mut audited, &settings).0;
        assert!(first.rgba == fresh.rgba, "focus at {focus} m");
        let (_, report) = stage.render_with(&gpu, &mut kept, &settings);
        assert!(!report.passes.iter().any(|pass| report.ran(&pass.name)), "{:?}", report.passes);
    }
}
