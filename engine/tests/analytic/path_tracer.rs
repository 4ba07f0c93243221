//! The path tracer against formulas, and against the same paths traced on the host.

use crate::support::{Stage, gpu};
use glam::{Affine3A, Quat, Vec3};
use lightwell::assets::{Material, Shape};
use lightwell::gpu::Gpu;
use lightwell::measure::Image;
use lightwell::render::Layer;
use lightwell::render::reference::{Estimate, PathTracer, TraceSettings, content_key, measure_throughput};
use lightwell::scene::{LightShape, ViewProjection};
use std::f32::consts::PI;

fn trace(gpu: &Gpu, stage: &Stage, bounces: Option<u32>, samples: u32) -> Estimate {
    let mut tracer = PathTracer::new(gpu);
    let settings = TraceSettings { bounces, seed: 1 };
    tracer.begin(gpu, &stage.scene, &stage.view, &settings).unwrap_or_else(|error| panic!("{error}"));
    tracer.advance(gpu, samples).unwrap_or_else(|error| panic!("{error}"));
    let estimate = tracer.estimate(gpu).unwrap_or_else(|error| panic!("{error}"));
    for image in estimate.direct.iter().chain(&estimate.indirect) {
        assert_eq!(image.first_non_finite(), None, "a pixel is not finite");
    }
    estimate
}

fn assert_near(what: &str, found: f64, expected: f64, tolerance: f64) {
    let error = (found - expected).abs() / expected.abs().max(1e-30);
    assert!(error < tolerance, "{what}: {found}, expected {expected} (relative error {error:.2e})");
}

/// The inside of a unit sphere, seen from near its centre.
fn inside_sphere(albedo: f32, edge: u32) -> Stage {
    let mut stage = Stage::new(Vec3::new(0.0, 0.0, 0.3), Vec3::ZERO, edge);
    let mut material = Material::diffuse("inside", Vec3::splat(albedo));
    material.double_sided = true;
    let sphere = Shape::Sphere { radius: 1.0, segments: 128, rings: 64 };
    stage.add_material(sphere, material, Affine3A::IDENTITY);
    stage
}

/// A sphere of albedo ½ around a light of intensity π: every point gets E = π, reflects L = ½ at once, and the sum
/// over all bounces is ½·(1 + ½ + ¼ …) = 1 (as in pbrt's tests of its integrators).
#[test]
fn furnace_inside_a_sphere() {
    let gpu = gpu();
    let mut stage = inside_sphere(0.5, 16);
    stage.light(LightShape::Point, Vec3::splat(PI), Vec3::ZERO, Vec3::Y);
    for (bounces, expected) in [(Some(0), 0.5), (Some(1), 0.75), (Some(2), 0.875), (None, 1.0)] {
        let found = trace(&gpu, &stage, bounces, 64).total().mean();
        // The facets of the sphere lie up to 0.1 % closer than its radius.
        assert_near(&format!("{bounces:?} bounces"), found, expected, 3e-3);
    }
}

/// Emission fills a closed room: L = Le/(1 − ρ) everywhere, whatever its shape.
#[test]
fn furnace_of_emitting_walls() {
    let gpu = gpu();
    let mut stage = Stage::new(Vec3::new(0.1, 0.2, 0.3), Vec3::ZERO, 16);
    stage.add_room(Vec3::splat(-1.0), Vec3::new(2.0, 3.0, 2.5), Vec3::splat(0.6));
    for primitive in &mut stage.scene.primitives {
        let material = Material { emissive: Vec3::new(0.4, 0.2, 0.1), ..(*primitive.material).clone() };
        primitive.material = std::sync::Arc::new(material);
    }
    let found = trace(&gpu, &stage, None, 64).total();
    let mean = found.pixels().iter().fold([0.0; 3], |sum: [f64; 3], pixel| {
        std::array::from_fn(|channel| sum[channel] + f64::from(pixel[channel]) / found.pixels().len() as f64)
    });
    for (channel, expected) in [1.0, 0.5, 0.25].into_iter().enumerate() {
        assert_near("emitting room", mean[channel], expected, 5e-3);
    }
}

/// Under a sky of radiance 1 a white convex object without specular light looks exactly as bright as the sky, and a
/// white metal reflects what a single scattering by GGX microfacets leaves.
#[test]
fn furnace_under_the_sky() {
    let gpu = gpu();
    let mut stage = Stage::new(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, 33);
    stage.add(Shape::Sphere { radius: 1.0, segments: 64, rings: 32 }, Vec3::ONE, Affine3A::IDENTITY);
    stage.scene.sky = Vec3::ONE;
    let white = trace(&gpu, &stage, None, 16).total();
    for value in white.values() {
        assert!((value - 1.0).abs() < 1e-4, "a pixel is {value}");
    }
    for roughness in [0.1, 0.3, 0.5, 0.8, 1.0] {
        let metal = Material { metallic: 1.0, roughness, base_color: glam::Vec4::ONE, ..Material::new("metal") };
        stage.scene.primitives[0].material = std::sync::Arc::new(metal);
        stage.scene.revisions.materials += 1;
        let middle = trace(&gpu, &stage, None, 1024).total().pixel(16, 16)[0];
        assert_near(
            &format!("roughness {roughness}"),
            f64::from(middle),
            reflected_at_normal_incidence(roughness),
            0.01,
        );
    }
}

/// ∫ D·V·(n·l) dω over the hemisphere for light that leaves along the normal, by the midpoint rule.
fn reflected_at_normal_incidence(roughness: f32) -> f64 {
    let a2 = f64::from(roughness).powi(4);
    let steps = 100_000;
    let step = std::f64::consts::FRAC_PI_2 / f64::from(steps);
    let part = |i: i32| {
        let theta = (f64::from(i) + 0.5) * step;
        let (n_l, n_h) = (theta.cos(), (0.5 * theta).cos());
        let d = a2 / (std::f64::consts::PI * (n_h * n_h * (a2 - 1.0) + 1.0).powi(2));
        let v = 0.5 / (n_l + (n_l * n_l * (1.0 - a2) + a2).sqrt());
        d * v * n_l * std::f64::consts::TAU * theta.sin() * step
    };
    (0..steps).map(part).sum()
}

/// The irradiance under a square lamp is π·L times the form factor.
#[test]
fn an_emissive_square_lights_the_floor_by_its_form_factor() {
    let gpu = gpu();
    let mut stage = Stage::new(Vec3::new(0.0, 2.0, 0.001), Vec3::ZERO, 8);
    stage.view.camera.projection = ViewProjection::Perspective { vertical_fov: 0.01 };
    stage.add(Shape::Plane { size: [4.0, 4.0], subdivisions: [1, 1] }, Vec3::splat(0.5), Affine3A::IDENTITY);
    let lamp = Material { emissive: Vec3::splat(10.0), ..Material::diffuse("lamp", Vec3::ZERO) };
    let down = Quat::from_rotation_x(PI);
    let at = Affine3A::from_rotation_translation(down, Vec3::Y * 3.0);
    stage.add_material(Shape::Plane { size: [2.0, 2.0], subdivisions: [3, 3] }, lamp, at);
    // Form factor of a parallel rectangle over one of its corners (Howell, A catalog of radiation heat transfer
    // configuration factors, B-4), four times: a = b = 1 at distance 3.
    let x = 1.0 / 3.0_f64;
    let corner = (x / (1.0 + x * x).sqrt() * (x / (1.0 + x * x).sqrt()).atan()) / std::f64::consts::PI;
    let expected = 0.5 / std::f64::consts::PI * (std::f64::consts::PI * 10.0 * 4.0 * corner);
    let estimate = trace(&gpu, &stage, Some(1), 256);
    assert_near("lit by the lamp", estimate.indirect().mean(), expected, 5e-3);
    assert_eq!(estimate.direct().mean(), 0.0, "what surfaces emit on one another is indirect light");
}

/// What the mirror-like floor shows is found by both ways of sampling a lamp, without counting it twice.
#[test]
fn glossy_reflections_of_a_lamp_count_once() {
    let gpu = gpu();
    for roughness in [0.05, 0.3, 0.8] {
        let mut stage = Stage::new(Vec3::new(0.0, 2.0, 2.0), Vec3::ZERO, 24);
        let floor = Material { metallic: 1.0, roughness, ..Material::new("floor") };
        stage.add_material(Shape::Plane { size: [9.0, 9.0], subdivisions: [1, 1] }, floor, Affine3A::IDENTITY);
        let lamp = Material { emissive: Vec3::splat(3.0), ..Material::diffuse("lamp", Vec3::ZERO) };
        let facing = Quat::from_rotation_x(0.6 * PI);
        let at = Affine3A::from_rotation_translation(facing, Vec3::new(0.0, 1.5, -2.0));
        stage.add_material(Shape::Plane { size: [2.0, 2.0], subdivisions: [1, 1] }, lamp, at);
        let both = trace(&gpu, &stage, Some(1), 512).indirect().mean();
        // The same lamp made so dark to the sampler of lights that only rays which go on find it: as the sky.
        stage.scene.primitives[1].casts_shadow = false;
        let without = trace(&gpu, &stage, Some(1), 16).indirect().mean();
        assert_eq!(without, 0.0, "what casts no shadow is seen by the camera alone");
        assert!(both > 0.0);
        let reference = reflected_by_quadrature(&stage, roughness);
        assert_near(&format!("roughness {roughness}"), both, reference, 0.02);
    }
}

/// Mean over the image of the lamp's light that the floor reflects once: the rendering equation summed over points of
/// the lamp, for rays through a grid of points in each pixel.
fn reflected_by_quadrature(stage: &Stage, roughness: f32) -> f64 {
    let lamp = stage.scene.primitives[1].world_from_object;
    let outward = lamp.transform_vector3(Vec3::Y);
    let alpha = f64::from(roughness * roughness).max(1e-3);
    let edge = stage.view.size[0];
    let (fine, cells) = (4, 160);
    let area = f64::from(4.0 / (cells * cells) as f32);
    let points: Vec<Vec3> = (0..cells * cells)
        .map(|i| Vec3::new((i % cells) as f32 + 0.5, 0.0, (i / cells) as f32 + 0.5) * (2.0 / cells as f32))
        .map(|p| lamp.transform_point3(p - Vec3::new(1.0, 0.0, 1.0)))
        .collect();
    let eye = stage.view.eye();
    let tangent = stage.view.camera.half_height();
    let axes = stage.view.camera.world_from_view.matrix3;
    let mut sum = 0.0;
    for index in 0..edge * edge * fine * fine {
        let (x, y) = (index % (edge * fine), index / (edge * fine));
        let ndc = |i: u32| (i as f32 + 0.5) / (edge * fine) as f32 * 2.0 - 1.0;
        let ray = Vec3::from(axes * glam::Vec3A::new(ndc(x) * tangent, -ndc(y) * tangent, -1.0)).normalize();
        if ray.y >= 0.0 {
            continue;
        }
        let at = eye + ray * (-eye.y / ray.y);
        if at.x.abs() > 4.5 || at.z.abs() > 4.5 || hides(stage, eye, at) {
            continue;
        }
        let v = -ray;
        for &point in &points {
            let offset = point - at;
            let (distance, l) = (offset.length(), offset.normalize());
            let (n_l, lamp_l) = (f64::from(l.y), f64::from(-outward.dot(l)));
            if n_l <= 0.0 || lamp_l <= 0.0 {
                continue;
            }
            let h = (v + l).normalize();
            let (n_v, n_h) = (f64::from(v.y), f64::from(h.y));
            let a2 = alpha * alpha;
            let d = a2 / (std::f64::consts::PI * (n_h * n_h * (a2 - 1.0) + 1.0).powi(2));
            let visibility =
                0.5 / (n_l * (n_v * n_v * (1.0 - a2) + a2).sqrt() + n_v * (n_l * n_l * (1.0 - a2) + a2).sqrt());
            sum += 3.0 * d * visibility * n_l * lamp_l / f64::from(distance * distance) * area;
        }
    }
    sum / f64::from(edge * edge * fine * fine)
}

/// Whether the lamp stands between the eye and a point (it does so from its back as well as from its front).
fn hides(stage: &Stage, eye: Vec3, at: Vec3) -> bool {
    let inverse = stage.scene.primitives[1].world_from_object.inverse();
    let (a, b) = (inverse.transform_point3(eye), inverse.transform_point3(at));
    let t = a.y / (a.y - b.y);
    let p = a + t * (b - a);
    // Seen from behind the camera looks through it.
    (0.0..1.0).contains(&t) && p.x.abs() < 1.0 && p.z.abs() < 1.0 && a.y > 0.0
}

fn box_room() -> Stage {
    let mut stage = Stage::new(Vec3::new(0.0, 1.0, 2.4), Vec3::new(0.0, 0.8, 0.0), 48);
    stage.add_room(Vec3::new(-1.5, 0.0, -1.5), Vec3::new(3.0, 2.5, 4.0), Vec3::new(0.7, 0.6, 0.5));
    let turned = Quat::from_rotation_y(0.4);
    let place = Affine3A::from_scale_rotation_translation(Vec3::new(0.8, 1.2, 0.8), turned, Vec3::new(-0.4, 0.6, -0.3));
    stage.add(Shape::Box { size: [1.0; 3] }, Vec3::new(0.2, 0.7, 0.3), place);
    let mirrored =
        Affine3A::from_scale_rotation_translation(Vec3::new(-0.5, 0.5, 0.5), turned, Vec3::new(0.7, 0.5, 0.4));
    stage.add(Shape::Sphere { radius: 1.0, segments: 24, rings: 12 }, Vec3::new(0.8, 0.3, 0.2), mirrored);
    stage.light(LightShape::Point, Vec3::new(3.0, 2.5, 2.0), Vec3::new(0.6, 2.2, 0.5), Vec3::NEG_Y);
    let spot = LightShape::Spot { inner: 0.4, outer: 0.7 };
    stage.light(spot, Vec3::splat(4.0), Vec3::new(-1.0, 2.0, 1.0), Vec3::new(0.3, -1.0, -0.6));
    stage
}

/// Every random number, intersection and decision is the same on both sides, so that the images agree to rounding but
/// for the odd path that rounding sends elsewhere.
#[test]
fn device_and_host_trace_the_same_paths() {
    let gpu = gpu();
    let stage = box_room();
    for bounces in [Some(0), Some(2), None] {
        let settings = TraceSettings { bounces, seed: 7 };
        let measured = measure_throughput(&gpu, &stage.scene, &stage.view, &settings, 8, 1)
            .unwrap_or_else(|error| panic!("{error}"))
            .expect("diffuse surfaces without textures");
        let (device, host) = (measured.device_image.total(), measured.host_image.total());
        let differs =
            |(a, b): (&[f32; 3], &[f32; 3])| a.iter().zip(b).any(|(a, b)| (a - b).abs() > 1e-3 * a.abs().max(0.1));
        let count = device.pixels().iter().zip(host.pixels()).filter(|pair| differs(*pair)).count();
        assert!(count * 100 < device.pixels().len(), "{bounces:?} bounces: {count} pixels differ");
        assert_near("mean", device.mean(), host.mean(), 2e-3);
    }
}

/// On a plain of 200 km a room is smaller than the unit that boxes are rounded to: they are kept as they are.
#[test]
fn device_and_host_trace_the_same_paths_on_a_wide_plain() {
    let gpu = gpu();
    let mut stage = box_room();
    let plain = Shape::Plane { size: [2e5; 2], subdivisions: [1; 2] };
    stage.add(plain, Vec3::splat(0.5), Affine3A::from_translation(Vec3::new(0.0, -3.0, 0.0)));
    let settings = TraceSettings { bounces: Some(2), seed: 7 };
    let measured = measure_throughput(&gpu, &stage.scene, &stage.view, &settings, 8, 1)
        .unwrap_or_else(|error| panic!("{error}"))
        .expect("diffuse surfaces without textures");
    assert_near("mean", measured.device_image.total().mean(), measured.host_image.total().mean(), 2e-3);
}

#[test]
fn pieces_and_repetition_leave_every_bit_as_it_is() {
    let gpu = gpu();
    let stage = box_room();
    let settings = TraceSettings { bounces: Some(3), seed: 5 };
    let whole = trace_in(&gpu, &stage, &settings, &[12]);
    assert!(whole == trace_in(&gpu, &stage, &settings, &[12]), "the second time is not as the first");
    assert!(whole == trace_in(&gpu, &stage, &settings, &[1, 4, 7]), "in pieces it is not as in one go");
    let other = TraceSettings { seed: 6, ..settings };
    assert!(whole != trace_in(&gpu, &stage, &other, &[12]), "the seed changes nothing");
}

fn trace_in(gpu: &Gpu, stage: &Stage, settings: &TraceSettings, pieces: &[u32]) -> Estimate {
    let mut tracer = PathTracer::new(gpu);
    tracer.begin(gpu, &stage.scene, &stage.view, settings).unwrap_or_else(|error| panic!("{error}"));
    pieces.iter().for_each(|&samples| tracer.advance(gpu, samples).unwrap_or_else(|error| panic!("{error}")));
    tracer.estimate(gpu).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn a_kept_trace_goes_on_where_it_stopped() {
    let gpu = gpu();
    let stage = box_room();
    let settings = TraceSettings { bounces: Some(1), seed: 5 };
    let key = content_key(&stage.scene, &stage.view, &settings);
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("half.trace");
    let begin = |stage: &Stage| {
        let mut tracer = PathTracer::new(&gpu);
        tracer.begin(&gpu, &stage.scene, &stage.view, &settings).unwrap_or_else(|error| panic!("{error}"));
        tracer
    };
    let mut first = begin(&stage);
    assert_eq!(first.resume(&gpu, &file, key).expect("no file is no error"), 0);
    first.advance(&gpu, 5).expect("traced");
    first.save(&gpu, &file, key).expect("saved");
    let mut second = begin(&stage);
    assert_eq!(second.resume(&gpu, &file, key).expect("resumed"), 5);
    second.advance(&gpu, 7).expect("traced");
    let (resumed, whole) = (second.estimate(&gpu).expect("an image"), trace_in(&gpu, &stage, &settings, &[12]));
    assert!(resumed == whole, "the resumed image has other bits");
    // Another scene, a cut file and a foreign file are told apart.
    let other = begin(&stage).resume(&gpu, &file, key ^ 1).expect_err("another image");
    assert!(other.to_string().contains("another scene"), "{other}");
    let bytes = std::fs::read(&file).expect("the file");
    for broken in [&bytes[..bytes.len() - 4], &bytes[..10], b"something else"] {
        std::fs::write(&file, broken).expect("written");
        let error = begin(&stage).resume(&gpu, &file, key).expect_err("broken");
        assert!(error.to_string().contains("half.trace"), "{error}");
    }
}

#[test]
fn the_key_changes_with_what_the_image_depends_on() {
    let settings = TraceSettings::default();
    let key = |stage: &Stage| content_key(&stage.scene, &stage.view, &settings);
    let base = key(&box_room());
    assert_eq!(base, key(&box_room()), "the same scene made twice");
    let changes: [fn(&mut Stage); 7] = [
        |stage| stage.scene.lights[0].intensity.x += 1e-6,
        |stage| stage.scene.lights[1].indirect = false,
        |stage| stage.scene.primitives[6].world_from_object.translation.x += 1e-6,
        |stage| stage.scene.sky = Vec3::splat(1e-3),
        |stage| stage.view.size = [48, 49],
        |stage| stage.view.camera.projection = ViewProjection::Perspective { vertical_fov: 1.570_797_3 },
        |stage| {
            let primitive = &mut stage.scene.primitives[7];
            primitive.material = std::sync::Arc::new(Material { roughness: 0.9, ..(*primitive.material).clone() });
        },
    ];
    for (index, change) in changes.into_iter().enumerate() {
        let mut stage = box_room();
        change(&mut stage);
        assert_ne!(base, key(&stage), "change {index}");
    }
    let one = TraceSettings { bounces: Some(1), ..settings };
    assert_ne!(base, content_key(&box_room().scene, &box_room().view, &one));
}

/// One of many lights is sampled at each vertex; the mean is that of all of them.
#[test]
fn many_lights_add_up() {
    let gpu = gpu();
    let mut stage = box_room();
    stage.view.size = [24, 24];
    let mut sum = 0.0;
    let lights = std::mem::take(&mut stage.scene.lights);
    for light in &lights {
        stage.scene.lights = vec![light.clone()];
        stage.scene.revisions.lights += 1;
        sum += trace(&gpu, &stage, Some(1), 64).total().mean();
    }
    stage.scene.lights = lights;
    stage.scene.revisions.lights += 1;
    let together = trace(&gpu, &stage, Some(1), 128);
    assert_near("both lights", together.total().mean(), sum, 0.01);
    // A light that is marked so adds to direct light alone.
    let before = together.direct().mean();
    stage.scene.lights.iter_mut().for_each(|light| light.indirect = false);
    stage.scene.revisions.lights += 1;
    let direct_only = trace(&gpu, &stage, Some(1), 128);
    assert_near("direct light", direct_only.direct().mean(), before, 1e-6);
    assert_eq!(direct_only.indirect().mean(), 0.0);
}

#[test]
fn scale_and_brightness_change_nothing_but_the_scale() {
    let gpu = gpu();
    let reference = trace(&gpu, &box_room(), Some(2), 4);
    let mut bright = box_room();
    bright.scene.lights.iter_mut().for_each(|light| light.intensity *= 1024.0);
    let scaled = |image: &Image, by: f32| {
        let mut image = image.clone();
        image.pixels_mut().iter_mut().flatten().for_each(|value| *value *= by);
        image
    };
    let found = trace(&gpu, &bright, Some(2), 4);
    assert!(found.total() == scaled(&reference.total(), 1024.0), "a power of two does not scale exactly");
    // Lengths × s: 1/s² of the light, for paths that rounding does not send elsewhere.
    for s in [1.0 / 1024.0, 1024.0] {
        let mut stage = box_room();
        for primitive in &mut stage.scene.primitives {
            primitive.world_from_object = Affine3A::from_scale(Vec3::splat(s)) * primitive.world_from_object;
        }
        stage.scene.lights.iter_mut().for_each(|light| light.position *= s);
        let camera = &mut stage.view.camera;
        camera.world_from_view.translation *= s;
        camera.near *= s;
        let found = trace(&gpu, &stage, Some(2), 4).total().mean() * f64::from(s * s);
        assert_near(&format!("scale {s}"), found, reference.total().mean(), 1e-3);
    }
}

#[test]
fn degenerate_scenes_give_valid_images() {
    let gpu = gpu();
    let empty = Stage::new(Vec3::Z, Vec3::ZERO, 8);
    assert!(trace(&gpu, &empty, None, 2).total() == Image::filled(8, 8, [0.0; 3]), "an empty scene is not black");
    let mut stage = box_room();
    stage.view.size = [16, 16];
    for scale in [Vec3::ZERO, Vec3::new(1.0, 0.0, 1.0), Vec3::splat(1e-20), Vec3::splat(1e15), Vec3::NAN] {
        stage.add(Shape::Box { size: [1.0; 3] }, Vec3::ONE, Affine3A::from_scale(scale));
    }
    stage.light(LightShape::Point, Vec3::splat(1e30), Vec3::new(0.0, 1.0, 0.0), Vec3::Y);
    stage.light(LightShape::Point, Vec3::splat(1e30), Vec3::new(0.0, 0.0, 0.0), Vec3::Y);
    stage.light(LightShape::Directional, Vec3::splat(1e-30), Vec3::ZERO, Vec3::Y);
    trace(&gpu, &stage, None, 4);
}

#[test]
fn noise_falls_as_samples_grow() {
    let gpu = gpu();
    let stage = box_room();
    let noise = |samples| trace(&gpu, &stage, Some(1), samples).noise(Layer::Indirect).expect("finite images");
    let (few, many) = (noise(8), noise(128));
    assert!(many < 0.35 * few, "8 samples {few}, 128 samples {many}");
}
