//! Lights with a surface: their irradiance against integrals, their shadows and highlights against the path tracer, in all methods.

use crate::support::{Stage, error, gpu, rgb};
use glam::{Affine3A, Vec2, Vec3};
use lightwell::assets::{Material, Shape};
use lightwell::gpu::{Gpu, ImageF32, read_texture_f32};
use lightwell::graph::PassState;
use lightwell::measure::Image;
use lightwell::render::reference::{PathTracer, TraceSettings};
use lightwell::render::{GiMethod, Layer, RenderSettings, Renderer};
use lightwell::scene::{LightShape, SceneLight, SceneView};
use lightwell::world::{Clpv, Quality};
use std::f32::consts::PI;

const ALBEDO: f32 = 0.8;

fn shapes() -> [LightShape; 5] {
    [
        LightShape::Sun { half_angle: 0.1 },
        LightShape::Sphere { radius: 0.4 },
        LightShape::Disc { radius: 0.5 },
        LightShape::Rectangle { half_size: Vec2::new(0.7, 0.3) },
        LightShape::Tube { half_length: 0.8, radius: 0.05 },
    ]
}

/// The same kind of light, so small that it has no surface to speak of.
fn tiny(shape: LightShape) -> LightShape {
    match shape {
        LightShape::Sun { .. } => LightShape::Sun { half_angle: 1e-5 },
        LightShape::Sphere { .. } => LightShape::Sphere { radius: 1e-6 },
        LightShape::Disc { .. } => LightShape::Disc { radius: 1e-6 },
        LightShape::Rectangle { .. } => LightShape::Rectangle { half_size: Vec2::splat(1e-6) },
        _ => LightShape::Tube { half_length: 1e-6, radius: 1e-6 },
    }
}

/// A floor at y = 0 below a light that shines down.
fn floor(shape: LightShape, height: f32) -> Stage {
    let mut stage = Stage::new(Vec3::new(0.0, 3.0, 2.0), Vec3::ZERO, 48);
    let plane = Shape::Plane { size: [20.0, 20.0], subdivisions: [1, 1] };
    stage.add(plane, Vec3::splat(ALBEDO), Affine3A::IDENTITY);
    let light = stage.light(shape, Vec3::splat(3.0), Vec3::new(0.3, height, -0.2), Vec3::new(0.2, -1.0, 0.1));
    light.axis = light.direction.any_orthonormal_vector();
    stage
}

/// Irradiance of an upward surface without shadows, by a sum over the light's surface: ∫ L·cosθ·cosθ′/d² dA, where L is the
/// intensity over the profile that the light shows along its axis.
fn irradiance(light: &SceneLight, point: Vec3) -> f32 {
    const STEPS: usize = 96;
    let across = light.direction.cross(light.axis);
    let steps = || (0..STEPS).map(|i| (i as f32 + 0.5) / STEPS as f32);
    let intensity = light.intensity.x;
    let from = |place: Vec3, normal: Vec3| {
        let offset = place - point;
        let toward = offset.normalize();
        (-normal.dot(toward)).max(0.0) * toward.y.max(0.0) / offset.length_squared()
    };
    let mean = |at: &dyn Fn(f32, f32) -> f32| {
        steps().flat_map(|u| steps().map(move |v| (u, v))).map(|(u, v)| at(u, v)).sum::<f32>() / (STEPS * STEPS) as f32
    };
    let circle = |angle: f32| light.axis * angle.cos() + across * angle.sin();
    match light.shape {
        // Even light from a cone that lies above the horizon brings E·cosθ.
        LightShape::Sun { .. } => intensity * -light.direction.y,
        LightShape::Sphere { radius } => {
            let sample = |u: f32, v: f32| {
                let (z, angle) = (2.0 * u - 1.0, 2.0 * PI * v);
                let around = Vec2::from_angle(angle) * (1.0 - z * z).sqrt();
                let normal = Vec3::new(around.x, z, around.y);
                from(light.position + radius * normal, normal)
            };
            // The surface is four times the profile.
            4.0 * intensity * mean(&sample)
        }
        LightShape::Disc { radius } => {
            let sample =
                |u: f32, v: f32| from(light.position + radius * u.sqrt() * circle(2.0 * PI * v), light.direction);
            intensity * mean(&sample)
        }
        LightShape::Rectangle { half_size } => {
            let sample = |u: f32, v: f32| {
                let at = (2.0 * Vec2::new(u, v) - 1.0) * half_size;
                from(light.position + at.x * light.axis + at.y * across, light.direction)
            };
            intensity * mean(&sample)
        }
        LightShape::Tube { half_length, radius } => {
            let sample = |u: f32, v: f32| {
                let angle = 2.0 * PI * v;
                let normal = light.direction * angle.cos() + across * angle.sin();
                from(light.position + (2.0 * u - 1.0) * half_length * light.axis + radius * normal, normal)
            };
            // The surface is π times the profile.
            PI * intensity * mean(&sample)
        }
        shape => panic!("{shape:?} has no surface"),
    }
}

/// Largest difference of the floor's radiance from the integral, over the largest radiance, of points at least so far from
/// the middle of the light.
fn deviation(gpu: &Gpu, stage: &Stage, nearest: f32) -> f32 {
    let image = stage.render(gpu, GiMethod::NONE, Layer::Direct);
    let (eye, light) = (stage.view.eye(), &stage.scene.lights[0]);
    let (mut worst, mut brightest) = (0.0_f32, 0.0_f32);
    for y in (0..image.height).step_by(3) {
        for x in (0..image.width).step_by(3) {
            let ray = stage.ray(x, y);
            let point = eye - ray * (eye.y / ray.y);
            if ray.y > -0.05 || point.abs().max_element() > 9.9 || point.distance(light.position) < nearest {
                continue;
            }
            let expected = ALBEDO / PI * irradiance(light, point);
            worst = worst.max((rgb(&image, x, y) - expected).abs().max_element());
            brightest = brightest.max(expected);
        }
    }
    worst / brightest
}

#[test]
fn a_floor_receives_the_integral_over_the_light() {
    let gpu = gpu();
    for shape in shapes() {
        let found = deviation(&gpu, &floor(shape, 1.2), 0.0);
        assert!(found < 5e-3, "{shape:?}: {found:.2e} of the brightest point");
    }
}

#[test]
fn a_light_close_to_a_surface_is_cut_at_the_horizon() {
    let gpu = gpu();
    // Half of the sphere and of the tube lies below the floor, and the flat lights lean into it.
    for shape in shapes().into_iter().skip(1) {
        let mut stage = floor(shape, 0.15);
        stage.scene.lights[0].casts_shadow = false;
        // The sum over the light's surface says little where that is near.
        let found = deviation(&gpu, &stage, 0.8);
        assert!(found < 0.03, "{shape:?}: {found:.2e} of the brightest point");
    }
}

#[test]
fn a_light_that_shrinks_becomes_a_point() {
    let gpu = gpu();
    for shape in shapes().map(tiny) {
        let found = deviation(&gpu, &floor(shape, 1.2), 0.0);
        assert!(found < 4e-3, "{shape:?}: {found:.2e} of the brightest point");
    }
}

#[test]
fn flat_lights_have_a_dark_back() {
    let gpu = gpu();
    for shape in [LightShape::Disc { radius: 0.5 }, LightShape::Rectangle { half_size: Vec2::splat(0.4) }] {
        let mut stage = floor(shape, 1.2);
        stage.scene.lights[0].direction = Vec3::Y;
        stage.scene.lights[0].axis = Vec3::X;
        let image = stage.render(&gpu, GiMethod::NONE, Layer::Direct);
        assert!(image.rgba.iter().all(|pixel| pixel[..3] == [0.0; 3]), "{shape:?} shines back");
    }
}

/// A box, a metal ball and a glossy floor under a light.
fn still_life(shape: LightShape, edge: u32) -> Stage {
    let mut stage = Stage::new(Vec3::new(0.2, 1.7, 3.6), Vec3::new(0.0, 0.4, 0.0), edge);
    let glossy = Material { roughness: 0.35, base_color: Vec3::splat(0.6).extend(1.0), ..Material::new("glossy") };
    let metal =
        Material { metallic: 1.0, roughness: 0.3, base_color: Vec3::splat(0.9).extend(1.0), ..Material::new("metal") };
    stage.add_material(Shape::Plane { size: [8.0; 2], subdivisions: [1, 1] }, glossy, Affine3A::IDENTITY);
    let at = |x: f32, y: f32, z: f32| Affine3A::from_translation(Vec3::new(x, y, z));
    stage.add(Shape::Box { size: [0.5, 0.9, 0.5] }, Vec3::new(0.7, 0.3, 0.2), at(-0.6, 0.45, 0.0));
    let ball = Shape::Sphere { radius: 0.4, segments: 64, rings: 32 };
    stage.add_material(ball, metal, at(0.6, 0.4, 0.1));
    let intensity = if matches!(shape, LightShape::Sun { .. }) { 2.0 } else { 6.0 };
    let light = stage.light(shape, Vec3::splat(intensity), Vec3::new(0.1, 2.2, 0.4), Vec3::new(-0.1, -1.0, -0.15));
    light.axis = light.direction.any_orthonormal_vector();
    stage
}

fn traced(gpu: &Gpu, stage: &Stage, samples: u32) -> [Image; 2] {
    let mut tracer = PathTracer::new(gpu);
    tracer.begin(gpu, &stage.scene, &stage.view, &TraceSettings { bounces: None, seed: 3 }).expect("a scene for rays");
    tracer.advance(gpu, samples).expect("samples");
    let estimate = tracer.estimate(gpu).expect("an image");
    [estimate.direct(), estimate.indirect()]
}

/// Mean of 16 images over the area of the pixels, as the path tracer has it.
fn averaged(gpu: &Gpu, stage: &Stage, gi: GiMethod, only: Layer) -> ImageF32 {
    let mut sum: Option<ImageF32> = None;
    for index in 0..16_u8 {
        let place = |index: u8| (f32::from(index) + 0.5) / 4.0 - 0.5;
        let view = SceneView { jitter: [place(index % 4), place(index / 4)], ..stage.view.clone() };
        let mut renderer = Renderer::new(gpu);
        let settings = RenderSettings { gi, only, ..Default::default() };
        renderer.render(gpu, &stage.scene, &view, &settings).expect("a frame");
        let image = read_texture_f32(gpu, renderer.radiance().expect("an image")).expect("readable");
        match &mut sum {
            Some(sum) => {
                sum.rgba.iter_mut().zip(&image.rgba).for_each(|(a, b)| (0..3).for_each(|c| a[c] += b[c] / 16.0));
            }
            None => {
                let rgba = image.rgba.iter().map(|pixel| pixel.map(|value| value / 16.0)).collect();
                sum = Some(ImageF32 { rgba, ..image });
            }
        }
    }
    sum.expect("images")
}

#[test]
fn shadows_and_highlights_are_those_of_the_path_tracer() {
    let gpu = gpu();
    for shape in shapes() {
        let stage = still_life(shape, 64);
        let [direct, _] = traced(&gpu, &stage, 4096);
        let (nrmse, bias) = error(&averaged(&gpu, &stage, GiMethod::NONE, Layer::Direct), &direct);
        println!("{shape:?}: nrmse {nrmse:.3}, bias {bias:+.4}");
        assert!(nrmse < 0.1 && bias.abs() < 0.01, "{shape:?}: nrmse {nrmse:.3}, bias {bias:+.4}");
    }
}

#[test]
fn one_image_has_soft_shadows_without_much_noise() {
    let gpu = gpu();
    let mut stage = still_life(LightShape::Rectangle { half_size: Vec2::new(0.7, 0.5) }, 96);
    // Where no edges are: the shadow of the box on the floor.
    stage.view.camera.world_from_view =
        Stage::new(Vec3::new(-1.4, 1.4, 0.8), Vec3::new(-1.3, 0.0, 0.3), 96).view.camera.world_from_view;
    let one = stage.render(&gpu, GiMethod::NONE, Layer::Direct);
    let [direct, _] = traced(&gpu, &stage, 512);
    let (nrmse, bias) = error(&one, &direct);
    println!("one image: nrmse {nrmse:.3}, bias {bias:+.4}");
    assert!(nrmse < 0.06 && bias.abs() < 0.01, "nrmse {nrmse:.3}, bias {bias:+.4}");
}

#[test]
fn methods_of_indirect_light_know_the_surface() {
    let gpu = gpu();
    for shape in shapes().into_iter().skip(1) {
        let mut stage = Stage::new(Vec3::new(0.0, 1.0, 1.9), Vec3::new(0.0, 0.9, 0.0), 48);
        stage.add_room(Vec3::new(-2.0, 0.0, -2.0), Vec3::new(4.0, 2.4, 4.0), Vec3::new(0.7, 0.6, 0.5));
        let over = Affine3A::from_translation(Vec3::new(0.3, 1.0, -0.4));
        stage.add(Shape::Box { size: [0.9, 0.1, 0.9] }, Vec3::splat(0.7), over);
        let light = stage.light(shape, Vec3::splat(4.0), Vec3::new(0.0, 1.9, -0.3), Vec3::new(0.1, -1.0, 0.0));
        light.axis = light.direction.any_orthonormal_vector();
        stage.clpv(Vec3::new(0.0, 1.2, 0.0), Clpv { quality: Quality::Medium, ..Default::default() });
        let [_, indirect] = traced(&gpu, &stage, 512);
        for (gi, most, least) in [(GiMethod::CLPV, 0.08, 0.02), (GiMethod::VPL, 0.12, 0.05)] {
            let (nrmse, bias) = error(&averaged(&gpu, &stage, gi, Layer::Indirect), &indirect);
            println!("{shape:?}, {}: nrmse {nrmse:.3}, bias {bias:+.4}", gi.name());
            assert!(nrmse < most && bias.abs() < least, "{shape:?}, {}: nrmse {nrmse:.3}, bias {bias:+.4}", gi.name());
        }
    }
}

#[test]
fn sizes_and_places_of_all_scales_are_finite() {
    let gpu = gpu();
    let largest = [
        LightShape::Sun { half_angle: PI / 4.0 },
        LightShape::Sphere { radius: 1e6 },
        LightShape::Disc { radius: 1e6 },
        LightShape::Rectangle { half_size: Vec2::new(1e6, 1e-6) },
        LightShape::Tube { half_length: 1e6, radius: 1e-6 },
    ];
    for shape in shapes().into_iter().chain(shapes().map(tiny)).chain(largest) {
        for (height, intensity) in [(1.0, 1e-30), (1.0, 1e30), (0.0, 1.0), (1e-6, 1e6), (1e7, 1.0)] {
            let mut stage = still_life(shape, 16);
            stage.scene.lights[0].position.y = height;
            stage.scene.lights[0].intensity = Vec3::splat(intensity);
            // Asserts that all pixels are finite.
            for gi in [GiMethod::NONE, GiMethod::VPL] {
                stage.render(&gpu, gi, Layer::Total);
            }
            traced(&gpu, &stage, 2).iter().for_each(|image| assert_eq!(image.first_non_finite(), None, "{shape:?}"));
        }
    }
}

#[test]
fn shadow_rays_are_cast_where_there_are_shadows_alone() {
    let gpu = gpu();
    let passes = |stage: &Stage, renderer: &mut Renderer| {
        let settings = RenderSettings { gi: GiMethod::NONE, only: Layer::Direct, ..Default::default() };
        let (_, report) = stage.render_with(&gpu, renderer, &settings);
        let ran = |pass: &&lightwell::graph::PassReport| {
            pass.name.starts_with("direct shadow rays") && matches!(pass.state, PassState::Ran)
        };
        report.passes.iter().filter(ran).count()
    };
    let mut stage = still_life(LightShape::Sphere { radius: 0.2 }, 16);
    let mut renderer = Renderer::new(&gpu);
    assert_eq!(passes(&stage, &mut renderer), 1);
    assert_eq!(passes(&stage, &mut renderer), 0, "nothing changed");
    stage.scene.lights[0].casts_shadow = false;
    assert_eq!(passes(&stage, &mut Renderer::new(&gpu)), 0, "the light casts no shadow");
    stage.scene.lights[0].casts_shadow = true;
    stage.scene.lights[0].shape = LightShape::Point;
    assert_eq!(passes(&stage, &mut Renderer::new(&gpu)), 0, "the light has no surface");
}
