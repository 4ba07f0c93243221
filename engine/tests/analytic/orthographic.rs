//! Orthographic cameras: images against known extents, against the path tracer, and each method of light against it.

use crate::support::{Stage, gpu};
use glam::{Affine3A, Quat, Vec3, Vec4};
use lightwell::assets::{AlphaMode, Material, Shape, SkyMap};
use lightwell::gpu::{Gpu, ImageF32};
use lightwell::measure::{Image, compare};
use lightwell::render::reference::{PathTracer, TraceSettings};
use lightwell::render::{GiMethod, Layer, RenderSettings, Renderer};
use lightwell::scene::{LightShape, ViewProjection};
use lightwell::world::{Clpv, LightCulling, LightVisibility, Quality, StochasticLightCulling, Transport};
use std::f32::consts::PI;
use std::sync::Arc;

fn parallel(mut stage: Stage, height: f32, near: f32, far: Option<f32>) -> Stage {
    let camera = &mut stage.view.camera;
    (camera.projection, camera.near, camera.far) = (ViewProjection::Orthographic { height }, near, far);
    stage
}

fn at(place: Vec3) -> Affine3A {
    Affine3A::from_translation(place)
}

/// Pixels that show anything.
fn covered(image: &ImageF32) -> usize {
    image.rgba.iter().filter(|pixel| pixel[0] > 0.0).count()
}

/// A box fills as many pixels as its front has area, and a sphere those of its disc, however far away they are.
#[test]
fn the_footprint_is_that_of_the_object_at_any_distance() {
    let gpu = gpu();
    for distance in [1.5, 4.0, 80.0] {
        // 32 pixels a metre.
        let mut stage = parallel(Stage::new(Vec3::ZERO, Vec3::NEG_Z, 128), 4.0, 0.0, Some(100.0));
        stage.add(Shape::Box { size: [1.0, 0.5, 1.0] }, Vec3::ONE, at(Vec3::new(0.5, 1.0, -distance)));
        let image = stage.render(&gpu, GiMethod::NONE, Layer::Albedo);
        let shown = |x, y| crate::support::rgb(&image, x, y).x > 0.0;
        assert_eq!(covered(&image), 32 * 16, "at {distance} m");
        assert!(shown(64, 24) && shown(95, 39) && !shown(63, 24) && !shown(96, 39) && !shown(64, 23), "{distance} m");
        stage.scene.primitives.clear();
        let ball = Shape::Sphere { radius: 1.2, segments: 256, rings: 128 };
        stage.add(ball, Vec3::ONE, at(Vec3::NEG_Z * distance));
        let disc = PI * (1.2_f32 * 32.0).powi(2);
        let count = covered(&stage.render(&gpu, GiMethod::NONE, Layer::Albedo)) as f32;
        assert!((count / disc - 1.0).abs() < 0.01, "{count} pixels at {distance} m, expected {disc}");
    }
}

/// What lies before the near plane, behind the far plane or beside the image is culled.
#[test]
fn what_is_not_seen_is_not_drawn() {
    let gpu = gpu();
    let cube = Shape::Box { size: [0.5; 3] };
    for (place, is_seen) in [
        (Vec3::new(0.0, 0.0, -2.0), true),
        (Vec3::new(1.9, 1.9, -9.0), true),
        (Vec3::new(0.0, 0.0, 1.0), false),
        (Vec3::new(0.0, 0.0, -11.0), false),
        (Vec3::new(2.3, 0.0, -5.0), false),
    ] {
        let mut stage = parallel(Stage::new(Vec3::ZERO, Vec3::NEG_Z, 32), 4.0, 1.0, Some(10.0));
        stage.add(cube.clone(), Vec3::ONE, at(place));
        let settings = RenderSettings { only: Layer::Albedo, ..Default::default() };
        let (image, report) = stage.render_with(&gpu, &mut Renderer::new(&gpu), &settings);
        assert_eq!(covered(&image) > 0, is_seen, "at {place}");
        let draws: u64 = report.passes.iter().filter(|pass| pass.name == "gbuffer").map(|pass| pass.counts.draws).sum();
        assert_eq!(draws > 0, is_seen, "at {place}: {report}");
    }
}

/// A room with a ball and a crate, seen from one wall.
fn room() -> Stage {
    let mut stage = Stage::new(Vec3::new(0.2, 0.4, 1.9), Vec3::new(-0.1, -0.3, 0.0), 48);
    stage.add_room(Vec3::splat(-2.0), Vec3::splat(4.0), Vec3::new(0.7, 0.6, 0.5));
    stage.add(Shape::Sphere { radius: 0.6, segments: 48, rings: 24 }, Vec3::new(0.7, 0.2, 0.2), at(Vec3::X * 0.6));
    let turned = Affine3A::from_rotation_translation(Quat::from_rotation_y(0.5), Vec3::new(-0.7, -1.4, -0.3));
    stage.add(Shape::Box { size: [1.0, 1.2, 1.0] }, Vec3::new(0.2, 0.4, 0.7), turned);
    stage.light(LightShape::Point, Vec3::splat(9.0), Vec3::new(-0.5, 1.2, 0.8), Vec3::Y).rsm_size = 64;
    parallel(stage, 2.6, 0.0, Some(8.0))
}

fn traced(gpu: &Gpu, stage: &Stage, bounces: Option<u32>, samples: u32) -> [Image; 2] {
    let mut tracer = PathTracer::new(gpu);
    let settings = TraceSettings { bounces, seed: 1 };
    tracer.begin(gpu, &stage.scene, &stage.view, &settings).unwrap_or_else(|error| panic!("{error}"));
    tracer.advance(gpu, samples).unwrap_or_else(|error| panic!("{error}"));
    let estimate = tracer.estimate(gpu).unwrap_or_else(|error| panic!("{error}"));
    [estimate.direct(), estimate.indirect()]
}

fn drawn(gpu: &Gpu, stage: &Stage, gi: GiMethod, layer: Layer) -> Image {
    let image = stage.render(gpu, gi, layer);
    Image::from_rgba(image.width, image.height, &image.rgba).expect("an image")
}

/// The mean of jittered frames: the pixels' areas, as the path tracer sees them.
fn smoothed(gpu: &Gpu, stage: &mut Stage, layer: Layer) -> Image {
    let mut sum: Vec<[f32; 3]> = Vec::new();
    let [width, height] = stage.view.size;
    let (steps, mut renderer) = (4, Renderer::new(gpu));
    for i in 0..steps * steps {
        stage.view.jitter = [i % steps, i / steps].map(|k| (k as f32 + 0.5) / steps as f32 - 0.5);
        let settings = RenderSettings { gi: GiMethod::NONE, only: layer, ..Default::default() };
        let (image, _) = stage.render_with(gpu, &mut renderer, &settings);
        sum.resize(image.rgba.len(), [0.0; 3]);
        for (sum, [r, g, b, _]) in sum.iter_mut().zip(&image.rgba) {
            *sum = [sum[0] + r, sum[1] + g, sum[2] + b];
        }
    }
    let count = (steps * steps) as f32;
    Image::from_pixels(width, height, sum.iter().map(|p| p.map(|c| c / count)).collect()).expect("an image")
}

/// Direct light, with a glossy floor whose highlight depends on the direction of view.
#[test]
fn direct_light_is_that_of_the_path_tracer() {
    let gpu = gpu();
    let mut stage = room();
    for primitive in &mut stage.scene.primitives {
        let glossy = Material { specular: 1.0, metallic: 0.5, roughness: 0.45, ..(*primitive.material).clone() };
        primitive.material = Arc::new(glossy);
    }
    let [direct, _] = traced(&gpu, &stage, Some(0), 256);
    let image = smoothed(&gpu, &mut stage, Layer::Direct);
    let found = compare(&image, &direct).expect("equal sizes");
    println!("direct light: nrmse {:.4}, bias {:.4}", found.nrmse, found.bias);
    assert!(found.nrmse < 0.06 && found.bias.abs() < 0.01, "{found:?}");
}

/// Every method of indirect light, as far off as it is in perspectives of such rooms.
#[test]
fn indirect_light_is_that_of_the_path_tracer() {
    let gpu = gpu();
    let mut stage = room();
    let slc = StochasticLightCulling {
        rsm_size: 64,
        visibility: LightVisibility::ShadowRays,
        interleave: 2,
        ..Default::default()
    };
    stage.scene.slc = Some(slc);
    stage.scene.vpl = Some(lightwell::world::InstantRadiosity {
        particles: 1024,
        bounces: lightwell::world::Bounces::Count(1),
        ..Default::default()
    });
    stage.clpv(Vec3::ZERO, Clpv { quality: Quality::Low, ..Default::default() });
    let [_, once] = traced(&gpu, &stage, Some(1), 256);
    let [_, all] = traced(&gpu, &stage, None, 256);
    for (name, gi, reference, bias, nrmse) in [
        ("vpl", GiMethod::VPL, &once, 0.06, 0.15),
        ("slc", GiMethod::SLC, &once, 0.06, 0.2),
        ("clpv", GiMethod::CLPV, &all, 0.12, 0.25),
    ] {
        let image = drawn(&gpu, &stage, gi, Layer::Indirect);
        let found = compare(&image, reference).expect("equal sizes");
        println!("{name}: nrmse {:.4}, bias {:.4}", found.nrmse, found.bias);
        assert!(found.bias.abs() < bias && found.nrmse < nrmse, "{name}: {found:?}");
    }
}

/// Tiles and depth slices are boxes and no pyramids: none may lose a light.
#[test]
fn every_way_of_culling_gives_the_same_bits() {
    let gpu = gpu();
    let of = |culling, far| {
        let mut stage = parallel(room(), 2.6, 0.0, far);
        stage.view.size = [64, 40];
        for primitive in &mut stage.scene.primitives {
            let glossy = Material { specular: 1.0, metallic: 0.5, roughness: 0.3, ..(*primitive.material).clone() };
            primitive.material = Arc::new(glossy);
        }
        let settings = StochasticLightCulling { culling, rsm_size: 64, interleave: 2, ..Default::default() };
        stage.scene.slc = Some(settings);
        drawn(&gpu, &stage, GiMethod::SLC, Layer::Indirect)
    };
    for far in [None, Some(8.0)] {
        let all = of(LightCulling::None, far);
        assert!(all.mean() > 1e-3);
        // Without culling the lights' terms are not random: only what chance takes away differs.
        let [tiled, clustered] = [LightCulling::Tiled, LightCulling::Clustered].map(|culling| of(culling, far));
        assert!(tiled.pixels() == clustered.pixels(), "tiles and clusters differ, far plane {far:?}");
        assert!((tiled.mean() / all.mean() - 1.0).abs() < 0.05, "{} and {}", tiled.mean(), all.mean());
    }
}

/// One direction of the sky fills the image, and surfaces reflect the sky as the path tracer has it.
#[test]
fn the_sky_is_seen_in_one_direction() {
    let gpu = gpu();
    let mut stage = parallel(Stage::new(Vec3::ZERO, Vec3::new(1.0, 0.5, -2.0), 24), 4.0, 0.0, None);
    let map = SkyMap::gradient(Vec3::new(0.1, 0.3, 0.9), Vec3::ONE, Vec3::new(0.2, 0.1, 0.05));
    stage.scene.sky = map.mean();
    stage.scene.sky_map = Some(Arc::new(map));
    let sky = drawn(&gpu, &stage, GiMethod::NONE, Layer::Total);
    assert!(sky.pixels().iter().all(|pixel| pixel == &sky.pixel(0, 0)), "the sky differs from pixel to pixel");
    let [direct, _] = traced(&gpu, &stage, Some(0), 4);
    for (found, expected) in sky.pixel(5, 7).into_iter().zip(direct.pixel(5, 7)) {
        assert!((found - expected).abs() < 2e-3 * expected, "{found}, traced {expected}");
    }
}

/// Blended surfaces are sorted and lit as seen along parallel lines, and the thesis's transport with blockers from the
/// camera runs.
#[test]
fn glass_and_camera_blockers() {
    let gpu = gpu();
    let mut stage = room();
    let glass = Material {
        base_color: Vec4::new(0.2, 0.9, 0.4, 0.4),
        alpha_mode: AlphaMode::Blend,
        double_sided: true,
        ..Material::diffuse("glass", Vec3::ONE)
    };
    for z in [0.9, 1.1] {
        let pane = Affine3A::from_rotation_translation(Quat::from_rotation_x(0.5 * PI), Vec3::Z * z);
        stage.add_material(Shape::Plane { size: [1.5; 2], subdivisions: [1; 2] }, glass.clone(), pane);
    }
    let [direct, _] = traced(&gpu, &stage, Some(0), 256);
    let image = smoothed(&gpu, &mut stage, Layer::Direct);
    let found = compare(&image, &direct).expect("equal sizes");
    println!("glass: nrmse {:.4}, bias {:.4}", found.nrmse, found.bias);
    assert!(found.nrmse < 0.12 && found.bias.abs() < 0.03, "{found:?}");
    stage.view.jitter = [0.0; 2];
    let lit = |stage: &mut Stage, camera_blockers| {
        let settings = Clpv { transport: Transport::Diffusion, camera_blockers, steps: 12, ..Default::default() };
        stage.clpv(Vec3::ZERO, settings);
        drawn(&gpu, stage, GiMethod::CLPV, Layer::Indirect).mean()
    };
    let (without, with) = (lit(&mut stage, false), lit(&mut stage, true));
    println!("indirect light {without:.4} without and {with:.4} with blockers from the camera");
    assert!(with != without && (with / without - 1.0).abs() < 0.3, "{without} and {with}");
}
