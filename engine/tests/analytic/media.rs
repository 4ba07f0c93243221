//! Participating media: how light falls on its way, what is scattered once, and rooms full of them, against integrals and the
//! path tracer.

use crate::support::{Stage, error, gpu, rgb};
use glam::{Affine3A, Quat, Vec3};
use lightwell::assets::{Material, Shape};
use lightwell::gpu::{Gpu, ImageF32};
use lightwell::measure::Image;
use lightwell::render::reference::{Estimate, PathTracer, TraceSettings};
use lightwell::render::{GiMethod, Layer, RenderSettings, Renderer};
use lightwell::scene::{LightShape, MediumShape, SceneMedium};
use lightwell::world::{Clpv, GatherRays, Quality};
use std::f32::consts::PI;

fn trace(gpu: &Gpu, stage: &Stage, bounces: Option<u32>, samples: u32) -> Estimate {
    let mut tracer = PathTracer::new(gpu);
    let settings = TraceSettings { bounces, seed: 1 };
    tracer.begin(gpu, &stage.scene, &stage.view, &settings).unwrap_or_else(|error| panic!("{error}"));
    tracer.advance(gpu, samples).unwrap_or_else(|error| panic!("{error}"));
    tracer.estimate(gpu).unwrap_or_else(|error| panic!("{error}"))
}

/// The density of a medium at a point, over its extinction.
fn density(medium: &SceneMedium, point: Vec3) -> f32 {
    let local = medium.local_from_world.transform_point3(point);
    let is_in = match medium.shape {
        MediumShape::Everywhere => true,
        MediumShape::Box => local.abs().max_element() <= 1.0,
        MediumShape::Sphere => local.length() <= 1.0,
    };
    let height = medium.up.dot(point - medium.base).max(0.0);
    if is_in { (-medium.falloff * height).exp() } else { 0.0 }
}

/// Optical depth between two points, by a sum over many steps.
fn depth_between(media: &[SceneMedium], a: Vec3, b: Vec3) -> f32 {
    const STEPS: usize = 8000;
    let at = |i: usize| a.lerp(b, (i as f32 + 0.5) / STEPS as f32);
    let of = |medium: &SceneMedium| medium.extinction * (0..STEPS).map(|i| density(medium, at(i))).sum::<f32>();
    media.iter().map(of).sum::<f32>() * a.distance(b) / STEPS as f32
}

/// A wall of radiance 1 at z = −4, seen from z = 2.
fn glowing_wall() -> Stage {
    let mut stage = Stage::new(Vec3::new(0.0, 0.3, 2.0), Vec3::new(0.0, 0.3, 0.0), 24);
    let material = Material { emissive: Vec3::ONE, ..Material::diffuse("wall", Vec3::ZERO) };
    let turn = Quat::from_rotation_arc(Vec3::Y, Vec3::Z);
    let plane = Shape::Plane { size: [40.0, 40.0], subdivisions: [1, 1] };
    stage.add_material(plane, material, Affine3A::from_rotation_translation(turn, Vec3::new(0.0, 0.0, -4.0)));
    stage
}

/// Media of each kind: even and thinning, turned, and one in another.
fn absorbers() -> Vec<(&'static str, Vec<SceneMedium>)> {
    let turned = Affine3A::from_scale_rotation_translation(
        Vec3::new(1.2, 0.7, 1.5),
        Quat::from_euler(glam::EulerRot::XYZ, 0.4, 0.7, -0.3),
        Vec3::new(0.3, 0.2, -1.0),
    );
    let one = |shape, place, extinction, falloff, up: Vec3| {
        let mut stage = glowing_wall();
        let medium = stage.medium(shape, place, extinction);
        (medium.albedo, medium.falloff, medium.up) = (Vec3::ZERO, falloff, up.normalize());
        stage.scene.media.remove(0)
    };
    let everywhere =
        |falloff, up| one(MediumShape::Everywhere, Affine3A::from_translation(Vec3::NEG_Y), 0.3, falloff, up);
    vec![
        ("even, everywhere", vec![everywhere(0.0, Vec3::Y)]),
        ("thinning upwards", vec![everywhere(0.8, Vec3::Y)]),
        ("thinning towards the wall", vec![everywhere(1.5, Vec3::new(0.2, 0.1, -1.0))]),
        ("thinning towards the eye", vec![everywhere(1.5, Vec3::new(-0.2, 0.1, 1.0))]),
        ("a turned box", vec![one(MediumShape::Box, turned, 0.6, 0.0, Vec3::Y)]),
        ("a turned box that thins", vec![one(MediumShape::Box, turned, 0.9, 2.0, Vec3::new(1.0, 1.0, 0.0))]),
        ("an ellipsoid", vec![one(MediumShape::Sphere, turned, 0.7, 0.0, Vec3::Y)]),
        ("one in another", vec![everywhere(0.5, Vec3::Y), one(MediumShape::Sphere, turned, 0.7, 1.0, Vec3::X)]),
    ]
}

/// What absorbs only lets exp(−∫ σ) pass (Beer, Lambert): in frames to rounding, in traced images to their noise.
#[test]
fn light_falls_with_the_optical_depth() {
    let gpu = gpu();
    for (what, media) in absorbers() {
        let mut stage = glowing_wall();
        stage.scene.media = media;
        stage.scene.revisions.media += 1;
        let drawn = stage.render(&gpu, GiMethod::NONE, Layer::Total);
        let traced = trace(&gpu, &stage, None, 256).total();
        let (mut worst, mut difference, mut total) = (0.0_f32, 0.0_f64, 0.0_f64);
        for y in 0..24 {
            for x in 0..24 {
                let ray = stage.ray(x, y);
                let eye = stage.view.eye();
                let wall = eye + ray * (-6.0 / ray.z);
                let expected = (-depth_between(&stage.scene.media, eye, wall)).exp();
                worst = worst.max((rgb(&drawn, x, y) - expected).abs().max_element());
                difference += f64::from(traced.pixels()[(x + 24 * y) as usize][0] - expected);
                total += f64::from(expected);
            }
        }
        assert!(worst < 2e-3, "{what}: frames are off by {worst}");
        let bias = difference / total;
        assert!(bias.abs() < 4e-3, "{what}: traced images are off by {bias:.2e}");
    }
}

/// Radiance that is scattered once towards the eye along a ray, by a sum over many steps, without shadows.
fn scattered_once(stage: &Stage, ray: Vec3, reach: f32) -> f32 {
    const STEPS: usize = 1500;
    let (eye, light) = (stage.view.eye(), &stage.scene.lights[0]);
    let media = &stage.scene.media;
    let step = reach / STEPS as f32;
    let mut depth = 0.0_f32;
    let mut sum = 0.0;
    for i in 0..STEPS {
        let at = eye + ray * (step * (i as f32 + 0.5));
        let (to_light, irradiance, source) = match light.shape {
            LightShape::Directional => (-light.direction, light.intensity.x, at - light.direction * 100.0),
            _ => {
                let offset = light.position - at;
                (offset.normalize(), light.intensity.x / offset.length_squared(), light.position)
            }
        };
        // Towards the light everything is as dense as here, or else the sum over that would be as long.
        let arriving = irradiance * (-depth_between_even(media, at, source)).exp();
        for medium in media {
            let scattering = medium.extinction * density(medium, at) * medium.albedo.x;
            let g = medium.anisotropy;
            let cosine = to_light.dot(ray);
            let phase = (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * cosine).powf(1.5));
            sum += step * scattering * phase * arriving * (-depth).exp();
            depth += step * medium.extinction * density(medium, at);
        }
    }
    sum
}

/// Optical depth between two points, of even media of which each holds all of the way that lies in its box.
fn depth_between_even(media: &[SceneMedium], a: Vec3, b: Vec3) -> f32 {
    let of = |medium: &SceneMedium| {
        let [p, q] = [a, b].map(|point| medium.local_from_world.transform_point3(point));
        let d = q - p;
        let (mut low, mut high) = (0.0_f32, 1.0_f32);
        for axis in 0..3 {
            if d[axis].abs() > 1e-9 {
                let (near, far) = ((-1.0 - p[axis]) / d[axis], (1.0 - p[axis]) / d[axis]);
                (low, high) = (low.max(near.min(far)), high.min(near.max(far)));
            }
        }
        medium.extinction * a.distance(b) * (high - low).max(0.0)
    };
    media.iter().map(of).sum()
}

/// In a box of haze under one light there is what is scattered once, to the resolution of the grid.
#[test]
fn light_is_scattered_once() {
    let gpu = gpu();
    for (what, shape, anisotropy) in [
        ("a sun, to all sides", LightShape::Directional, 0.0),
        ("a sun, onwards", LightShape::Directional, 0.7),
        ("a point light beside the view", LightShape::Point, 0.0),
        ("a point light, backwards", LightShape::Point, -0.3),
    ] {
        let mut stage = Stage::new(Vec3::new(0.0, 0.0, 4.0), Vec3::ZERO, 96);
        let medium = stage.medium(MediumShape::Box, Affine3A::from_scale(Vec3::new(2.0, 1.0, 1.5)), 0.5);
        medium.anisotropy = anisotropy;
        medium.albedo = Vec3::splat(0.8);
        let light = stage.light(shape, Vec3::splat(3.0), Vec3::new(0.4, 1.7, 0.3), Vec3::new(0.3, -1.0, -0.2));
        light.casts_shadow = false;
        let drawn = stage.render(&gpu, GiMethod::NONE, Layer::Direct);
        let traced = trace(&gpu, &stage, Some(0), 64);
        let mut expected = Vec::new();
        for y in 0..96 {
            for x in 0..96 {
                expected.push([scattered_once(&stage, stage.ray(x, y), 8.0); 3]);
            }
        }
        let expected = Image::from_pixels(96, 96, expected).expect("all pixels");
        let (nrmse, bias) = error(&drawn, &expected);
        println!("{what}: frame nrmse {nrmse:.4}, bias {bias:+.4}");
        assert!(nrmse < 0.05 && bias.abs() < 0.01, "{what}: nrmse {nrmse}, bias {bias}");
        let mean = |image: &Image| image.pixels().iter().map(|pixel| f64::from(pixel[0])).sum::<f64>();
        let bias = mean(&traced.total()) / mean(&expected) - 1.0;
        println!("{what}: traced bias {bias:+.4}");
        assert!(bias.abs() < 0.01, "{what}: traced images are off by {bias}");
    }
}

/// A closed room whose walls emit ½ and reflect half has radiance 1 everywhere, also through a medium that absorbs nothing:
/// light is as even in it as without.
#[test]
fn furnace_with_haze() {
    let gpu = gpu();
    let mut stage = Stage::new(Vec3::new(0.1, 0.2, 0.3), Vec3::ZERO, 24);
    stage.add_room(Vec3::splat(-1.0), Vec3::new(2.0, 3.0, 2.5), Vec3::splat(0.5));
    for primitive in &mut stage.scene.primitives {
        let material = Material { emissive: Vec3::splat(0.5), ..(*primitive.material).clone() };
        primitive.material = std::sync::Arc::new(material);
    }
    stage.medium(MediumShape::Everywhere, Affine3A::IDENTITY, 0.4).anisotropy = 0.6;
    stage.medium(MediumShape::Sphere, Affine3A::from_scale(Vec3::splat(0.8)), 0.9);
    let traced = trace(&gpu, &stage, None, 64).total().mean();
    assert!((traced - 1.0).abs() < 5e-3, "traced images have a mean of {traced}");
    stage.clpv(Vec3::ZERO, Clpv { quality: Quality::Medium, ..Clpv::default() });
    let drawn = stage.render(&gpu, GiMethod::CLPV, Layer::Total);
    let mean = drawn.rgba.iter().map(|pixel| f64::from(pixel[0])).sum::<f64>() / drawn.rgba.len() as f64;
    println!("frames have a mean of {mean:.4}");
    assert!((mean - 1.0).abs() < 0.02, "frames have a mean of {mean}");
}

/// A room with a lamp, a wall that throws a shadow, and haze in all of it.
fn smoky_room(extinction: f32, albedo: f32) -> Stage {
    let mut stage = Stage::new(Vec3::new(0.0, 1.4, 2.7), Vec3::new(0.0, 1.1, 0.0), 64);
    stage.add_room(Vec3::new(-3.0, 0.0, -3.0), Vec3::new(6.0, 2.8, 6.0), Vec3::new(0.7, 0.6, 0.5));
    let block = Shape::Box { size: [0.8, 0.9, 0.8] };
    stage.add(block, Vec3::new(0.3, 0.5, 0.7), Affine3A::from_translation(Vec3::new(-0.6, 0.45, -0.8)));
    stage.light(
        LightShape::Spot { inner: 0.3, outer: 0.45 },
        Vec3::splat(20.0),
        Vec3::new(-1.6, 2.5, -0.5),
        Vec3::new(0.7, -1.0, -0.1),
    );
    stage.medium(MediumShape::Everywhere, Affine3A::IDENTITY, extinction).albedo = Vec3::splat(albedo);
    stage.clpv(Vec3::new(0.0, 1.4, 0.0), Clpv { quality: Quality::Medium, ..Clpv::default() });
    stage
}

/// The mean of several frames with other shifts.
fn drawn(gpu: &Gpu, stage: &Stage, only: Layer, images: u32) -> ImageF32 {
    let mut stage_now = Stage::new(Vec3::ZERO, Vec3::X, 8);
    stage_now.scene = stage.scene.clone();
    stage_now.view = stage.view.clone();
    let settings = RenderSettings { gi: GiMethod::CLPV, only, images, ..Default::default() };
    let mut renderer = Renderer::new(gpu);
    let mut sum: Option<ImageF32> = None;
    for i in 0..images {
        // Hammersley's points: as many rows and columns of the pixel as images.
        let reversed = (i.reverse_bits().checked_shr(32 - images.ilog2()).unwrap_or(0)) as f32;
        stage_now.view.jitter = [(i as f32 + 0.5) / images as f32 - 0.5, (reversed + 0.5) / images as f32 - 0.5];
        let (image, _) = stage_now.render_with(gpu, &mut renderer, &settings);
        match &mut sum {
            None => sum = Some(image),
            Some(sum) => {
                for (a, b) in sum.rgba.iter_mut().zip(&image.rgba) {
                    (0..4).for_each(|channel| a[channel] += b[channel]);
                }
            }
        }
    }
    let mut mean = sum.expect("at least one image");
    mean.rgba.iter_mut().flatten().for_each(|value| *value /= images as f32);
    mean
}

/// Error of the means of blocks of 4 by 4 pixels: edges and noise of pixels are no matter of haze.
fn error_of_blocks(found: &ImageF32, truth: &Image) -> (f64, f64) {
    let found = Image::from_rgba(found.width, found.height, &found.rgba).and_then(|image| image.reduced([16, 16]));
    let (found, truth) = (found.expect("whole blocks"), truth.reduced([16, 16]).expect("whole blocks"));
    let (mut square, mut difference, mut total) = (0.0, 0.0, 0.0);
    for (a, b) in found.values().zip(truth.values()).map(|(a, b)| (f64::from(a), f64::from(b))) {
        square += (a - b).powi(2);
        difference += a - b;
        total += b;
    }
    ((square * found.values().len() as f64).sqrt() / total, difference / total)
}

/// Rooms with thin haze are as the path tracer has them: of all light, of the lamps' alone, and of further bounces.
#[test]
fn smoky_rooms_are_as_traced() {
    let gpu = gpu();
    let mut failures = 0;
    for (extinction, albedo) in [(0.08, 0.95), (0.2, 0.8), (0.15, 0.0)] {
        let stage = smoky_room(extinction, albedo);
        let traced = trace(&gpu, &stage, None, 512);
        let half = |[even, odd]: &[Image; 2]| {
            let pixels = even.pixels().iter().zip(odd.pixels());
            let mean = pixels.map(|(a, b)| std::array::from_fn(|i| 0.5 * (a[i] + b[i]))).collect();
            Image::from_pixels(64, 64, mean).expect("all pixels")
        };
        for (layer, truth, worst) in [
            (Layer::Direct, half(&traced.direct), 0.30),
            (Layer::Indirect, half(&traced.indirect), 0.12),
            (Layer::Total, traced.total(), 0.10),
        ] {
            let found = drawn(&gpu, &stage, layer, 16);
            let (nrmse, bias) = error_of_blocks(&found, &truth);
            println!("extinction {extinction}, albedo {albedo}, {layer:?}: nrmse {nrmse:.4}, bias {bias:+.4}");
            failures += u32::from(!(nrmse < worst && bias.abs() < 0.06));
        }
    }
    assert_eq!(failures, 0, "figures above are over their bounds");
}

/// The volumes alone, looked up without rays, lose what a medium absorbs too.
#[test]
fn volumes_alone_lose_what_is_absorbed() {
    let gpu = gpu();
    let mut stage = smoky_room(0.3, 0.0);
    let settings = Clpv { quality: Quality::Medium, gather_rays: GatherRays::Count(0), ..Clpv::default() };
    stage.clpv(Vec3::new(0.0, 1.4, 0.0), settings);
    let [even, odd] = trace(&gpu, &stage, None, 256).indirect;
    let truth = 0.5 * (even.mean() + odd.mean());
    let found = drawn(&gpu, &stage, Layer::Indirect, 1);
    let values = found.rgba.iter().flat_map(|pixel| &pixel[..3]).map(|value| f64::from(*value));
    let bias = values.sum::<f64>() / (3.0 * found.rgba.len() as f64) / truth - 1.0;
    println!("volumes alone: bias {bias:+.3}");
    assert!(bias.abs() < 0.15, "the mean is off by {bias}");
}

/// A box of haze with the sun from the side, past a fence of bars beside the view.
fn shafts() -> Stage {
    let mut stage = Stage::new(Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO, 64);
    for i in 0..12 {
        let bar = Shape::Box { size: [0.02, 0.3, 4.2] };
        stage.add(bar, Vec3::ZERO, Affine3A::from_translation(Vec3::new(7.3, 0.6 * i as f32, 0.0)));
    }
    // Black, so that nothing but haze is seen.
    let wall = Shape::Box { size: [40.0, 40.0, 0.1] };
    stage.add(wall, Vec3::ZERO, Affine3A::from_translation(Vec3::new(0.0, 0.0, -6.0)));
    stage.light(LightShape::Directional, Vec3::splat(3.0), Vec3::ZERO, Vec3::new(-1.0, -0.4, 0.0)).shadow_size = 2048;
    stage.medium(MediumShape::Box, Affine3A::from_scale(Vec3::splat(2.0)), 0.1);
    stage
}

/// The shafts of one image are those of the mean of many, whose grid is shifted.
#[test]
fn borders_of_shafts_are_smooth() {
    let gpu = gpu();
    let stage = shafts();
    let [one, many] = [1, 16].map(|images| drawn(&gpu, &stage, Layer::Direct, images));
    let many = Image::from_rgba(many.width, many.height, &many.rgba).expect("an image");
    let (off, bias) = error_of_blocks(&one, &many);
    println!("off {off}, bias {bias}");
    assert!(off < 0.033 && bias.abs() < 0.01, "off {off}, bias {bias}");
}
