//! Virtual lights against formulas, against each other and against the path tracer.

use crate::support::{Stage, gpu, rgb};
use glam::{Affine3A, Quat, Vec3};
use lightwell::assets::{Material, Shape};
use lightwell::bvh::Ray;
use lightwell::gpu::{Gpu, ImageF32};
use lightwell::render::reference::{PathTracer, TraceSettings};
use lightwell::render::vpl::{Caster, IntersectionCounts, intersect_square, intersect_unit_box, virtual_lights};
use lightwell::render::{GiMethod, Layer, RenderSettings, Renderer};
use lightwell::scene::SceneBvh;
use lightwell::scene::{LightShape, ViewProjection};
use lightwell::world::{
    Accumulation, Bounces, InstantRadiosity, ParticleCasts, ParticleSequence, VirtualPlacement, VirtualVisibility,
};
use std::f32::consts::PI;

fn indirect() -> RenderSettings {
    RenderSettings { gi: GiMethod::VPL, only: Layer::Indirect, display: false, ..Default::default() }
}

fn draw(gpu: &Gpu, stage: &mut Stage, settings: InstantRadiosity) -> (ImageF32, Renderer) {
    stage.scene.vpl = Some(settings);
    let mut renderer = Renderer::new(gpu);
    let image = stage.render_with(gpu, &mut renderer, &indirect()).0;
    (image, renderer)
}

fn mean(image: &ImageF32) -> f32 {
    image.rgba.iter().map(|pixel| (pixel[0] + pixel[1] + pixel[2]) / 3.0).sum::<f32>() / image.rgba.len() as f32
}

/// A room with a box in it and a point light.
fn room(albedo: f32, edge: u32) -> Stage {
    let mut stage = Stage::new(Vec3::new(0.0, 0.2, 1.3), Vec3::new(0.1, -0.1, 0.0), edge);
    stage.add_room(Vec3::splat(-1.5), Vec3::splat(3.0), Vec3::splat(albedo));
    let turned = Affine3A::from_rotation_translation(Quat::from_rotation_y(0.4), Vec3::new(0.3, -0.9, -0.4));
    stage.add(Shape::Box { size: Vec3::new(0.8, 1.1, 0.8).to_array() }, Vec3::splat(albedo), turned);
    stage.light(LightShape::Point, Vec3::splat(3.0), Vec3::new(-0.5, 0.8, 0.3), Vec3::Y);
    stage
}

/// A narrow beam leaves one light on the floor; on the wall L = (ρ/π)·(Φ/π)·cosθ·cosθ_i/d².
#[test]
fn one_light_by_the_formula() {
    let gpu = gpu();
    let mut stage = Stage::new(Vec3::new(-1.0, 0.8, 0.0), Vec3::new(1.0, 0.8, 0.0), 17);
    let plane = || Shape::Plane { size: [6.0, 6.0], subdivisions: [1, 1] };
    stage.add(plane(), Vec3::splat(0.5), Affine3A::IDENTITY);
    let wall = Affine3A::from_rotation_translation(Quat::from_rotation_arc(Vec3::Y, Vec3::NEG_X), Vec3::X);
    stage.add(plane(), Vec3::splat(0.8), wall);
    let (inner, outer) = (0.0199_f32, 0.02_f32);
    stage.light(LightShape::Spot { inner, outer }, Vec3::splat(500.0), Vec3::new(0.0, 2.0, 0.0), Vec3::NEG_Y);
    let (image, renderer) = draw(
        &gpu,
        &mut stage,
        InstantRadiosity { particles: 1, candidates: 1, bounces: Bounces::Count(1), ..Default::default() },
    );
    let particles = virtual_lights(renderer.methods()).expect("they were asked for").particles();
    assert_eq!(particles.lights.len(), 1);
    let light = Vec3::from(particles.lights[0].place);
    assert!(light.length() < 0.05, "{light}");
    let solid_angle = 2.0 * PI * (1.0 - outer.cos());
    let (mut seen, middle) = (0, 0.8 / PI);
    for (x, y) in [(8, 8), (5, 6), (12, 4), (8, 11)] {
        let ray = stage.ray(x, y);
        let at = Vec3::new(-1.0, 0.8, 0.0) + ray * (2.0 / ray.x);
        if at.y <= 0.05 {
            continue;
        }
        let (offset, found) = (light - at, rgb(&image, x, y).x);
        let (d2, direction) = (offset.length_squared(), offset.normalize());
        let flux = 500.0 * solid_angle * 0.5;
        let expected = middle * flux / PI * (-direction.x) * (-direction.y) / d2;
        assert!((found - expected).abs() < 0.02 * expected, "pixel {x}, {y}: {found}, expected {expected}");
        seen += 1;
    }
    assert!(seen >= 3);
}

/// Inside a sphere cosθ·cosθ_i/d² is 1/(4R²) everywhere: whatever the particles do, the sum must be ½ (a light of π at
/// the centre, albedo ½: E = π, direct ½, all else ½).
#[test]
fn furnace_of_many_particles() {
    let gpu = gpu();
    let mut stage = Stage::new(Vec3::new(0.0, 0.0, 0.3), Vec3::ZERO, 16);
    let mut material = Material::diffuse("inside", Vec3::splat(0.5));
    material.double_sided = true;
    stage.add_material(Shape::Sphere { radius: 1.0, segments: 128, rings: 64 }, material, Affine3A::IDENTITY);
    stage.light(LightShape::Point, Vec3::splat(PI), Vec3::ZERO, Vec3::Y);
    for sequence in [ParticleSequence::LowDiscrepancy, ParticleSequence::Random] {
        let settings = InstantRadiosity {
            particles: 2048,
            near_bound: 0.0,
            visibility: VirtualVisibility::None,
            sequence,
            ..Default::default()
        };
        let found = mean(&draw(&gpu, &mut stage, settings).0);
        assert!((found - 0.5).abs() < 4e-3, "{sequence:?}: {found}");
    }
}

#[test]
fn ten_particles_leave_eighteen_lights() {
    let gpu = gpu();
    let mut stage = room(0.5, 8);
    let settings = InstantRadiosity { particles: 10, candidates: 1, ..Default::default() };
    let (_, renderer) = draw(&gpu, &mut stage, settings);
    let particles = virtual_lights(renderer.methods()).expect("they were asked for").particles();
    assert!((particles.reflectance - 0.5).abs() < 1e-6, "{}", particles.reflectance);
    assert_eq!((particles.lights.len(), particles.casts.rays), (18, 18));
}

/// A few small boxes far from each other fill little of the rectangle before them: particles start in front of them.
#[test]
fn particles_of_the_sun_do_not_pass_the_scene() {
    let gpu = gpu();
    let mut stage = Stage::new(Vec3::new(0.0, 1.0, 6.0), Vec3::ZERO, 8);
    for at in [[-4.0, 0.0, 0.0], [4.0, 0.0, 1.0], [0.0, 3.0, -4.0], [1.0, -2.0, 3.0]] {
        stage.add(Shape::Box { size: [0.6; 3] }, Vec3::splat(0.5), Affine3A::from_translation(at.into()));
    }
    let direction = Vec3::new(0.4, -0.7, -0.5).normalize();
    stage.light(LightShape::Directional, Vec3::splat(2.0), Vec3::ZERO, direction);
    let settings =
        InstantRadiosity { particles: 1000, candidates: 1, bounces: Bounces::Count(1), ..Default::default() };
    let (_, renderer) = draw(&gpu, &mut stage, settings);
    let particles = virtual_lights(renderer.methods()).expect("they were asked for").particles();
    assert!(particles.lights.len() > 600, "{} of 1000 hit", particles.lights.len());
    // A box shows the sun Σ|d_i|·a². Φ = ρ·E·A, and I = Φ/π.
    let flux: f32 = particles.lights.iter().map(|light| light.intensity[0] * PI).sum();
    let expected = 0.5 * 2.0 * 4.0 * 0.36 * direction.abs().element_sum();
    assert!((flux / expected - 1.0).abs() < 0.03, "{flux}, expected {expected}");
}

/// A software driver ends the loops of a thread after 65,535 turns: all lights in one dispatch would be cut off.
#[test]
fn many_lights_are_no_darker_than_few() {
    let gpu = gpu();
    let mut stage = room(0.6, 8);
    let of = |stage: &mut Stage, particles| {
        let settings = InstantRadiosity { particles, bounces: Bounces::Count(1), ..Default::default() };
        mean(&draw(&gpu, stage, settings).0)
    };
    let [few, many] = [512, 16_384].map(|particles| of(&mut stage, particles));
    assert!((many / few - 1.0).abs() < 0.05, "{few} by 512 particles, {many} by 16,384");
}

/// Two rooms with a lamp each, the brighter one where the camera does not see it: its lights bring nothing.
#[test]
fn lights_are_chosen_that_the_camera_sees() {
    const SEEDS: u32 = 48;
    let gpu = gpu();
    let mut stage = room(0.6, 16);
    stage.add_room(Vec3::new(2.0, -1.5, -1.5), Vec3::splat(3.0), Vec3::splat(0.6));
    stage.light(LightShape::Point, Vec3::splat(30.0), Vec3::new(3.5, 0.5, 0.0), Vec3::Y);
    let shot = |particles| InstantRadiosity { particles, candidates: 1, near_bound: 0.5, ..Default::default() };
    let truth = draw(&gpu, &mut stage, InstantRadiosity { seed: 99, ..shot(32_768) }).0;
    let scale = mean(&truth);
    // Error, bias, and the share of lights that lie in the room of the camera.
    let mut of = |settings: InstantRadiosity| {
        let (mut squares, mut bias, mut own, mut all) = (0.0, 0.0, 0, 0);
        for seed in 0..SEEDS {
            let (image, renderer) = draw(&gpu, &mut stage, InstantRadiosity { seed, ..settings.clone() });
            let particles = virtual_lights(renderer.methods()).expect("they were asked for").particles();
            own += particles.lights.iter().filter(|light| light.place[0] < 1.6).count();
            all += particles.lights.len();
            for (pixel, truth) in image.rgba.iter().zip(&truth.rgba) {
                let difference = f64::from((pixel[0] - truth[0]) / scale);
                squares += difference * difference / (f64::from(SEEDS) * 256.0);
                bias += difference / (f64::from(SEEDS) * 256.0);
            }
        }
        (f64::sqrt(squares), bias, own as f64 / all as f64)
    };
    let all = of(shot(128));
    let chosen = of(InstantRadiosity { candidates: 16, ..shot(128) });
    let unbound = of(InstantRadiosity { candidates: 16, near_bound: 0.0, ..shot(128) });
    eprintln!("error, bias and lights in view: {all:?}, chosen {chosen:?}, without a bound {unbound:?}");
    assert!(all.2 < 0.2 && chosen.2 > 0.6, "{} and {} of the lights are in the room", all.2, chosen.2);
    assert!(chosen.0 < 0.8 * all.0 && chosen.1.abs() < 0.6 * all.1.abs(), "{all:?}, chosen {chosen:?}");
    // The bound takes light away, the choice does not.
    assert!(unbound.1.abs() < 0.04, "{unbound:?}");
}

#[test]
fn both_ways_to_add_up_give_the_same_image() {
    let gpu = gpu();
    let mut stage = room(0.6, 48);
    for visibility in [VirtualVisibility::None, VirtualVisibility::ShadowRays] {
        let settings = InstantRadiosity { particles: 24, visibility, ..Default::default() };
        let batched = draw(&gpu, &mut stage, settings.clone()).0;
        let by_the_letter = InstantRadiosity { accumulation: Accumulation::ByTheLetter, ..settings };
        let letter = draw(&gpu, &mut stage, by_the_letter).0;
        let scale = mean(&batched);
        assert!(scale > 0.0);
        let worst = batched.rgba.iter().zip(&letter.rgba).map(|(a, b)| (a[0] - b[0]).abs() / scale).fold(0.0, f32::max);
        assert!(worst < 1e-4, "{visibility:?}: pixels differ by {worst} of the mean");
    }
}

#[test]
fn nothing_is_shot_twice() {
    let gpu = gpu();
    let mut stage = room(0.6, 16);
    stage.scene.vpl = Some(InstantRadiosity { particles: 16, candidates: 4, ..Default::default() });
    let mut renderer = Renderer::new(&gpu);
    let (first, report) = stage.render_with(&gpu, &mut renderer, &indirect());
    assert!(report.ran("particles"));
    let (_, report) = stage.render_with(&gpu, &mut renderer, &indirect());
    assert_eq!(report.ran_count(), 0, "{report}");
    // Another view needs no particle either, and others of the lights.
    stage.view.camera.world_from_view.translation.x += 0.1;
    let (_, report) = stage.render_with(&gpu, &mut renderer, &indirect());
    assert!(!report.ran("particles") && report.ran("choice") && report.ran("vpl shade"), "{report}");
    stage.view.camera.world_from_view.translation.x -= 0.1;
    stage.scene.lights[0].position.x += 0.2;
    stage.scene.lights[0].revision += 1;
    stage.scene.revisions.lights += 1;
    let (moved, report) = stage.render_with(&gpu, &mut renderer, &indirect());
    assert!(report.ran("particles") && moved.rgba != first.rgba, "{report}");
    // Back again: the same bits.
    stage.scene.lights[0].position.x = -0.5;
    stage.scene.lights[0].revision += 1;
    stage.scene.revisions.lights += 1;
    let (again, _) = stage.render_with(&gpu, &mut renderer, &indirect());
    assert!(again.rgba == first.rgba, "an edit that was undone left something behind");
}

#[test]
fn more_lights_than_memory_holds_are_refused_before_any_is_shot() {
    let gpu = gpu();
    let mut stage = room(0.6, 16);
    let mut refused = |particles: u32, candidates: u32| {
        stage.scene.vpl = Some(InstantRadiosity { particles, candidates, ..Default::default() });
        let refused = Renderer::new(&gpu).render(&gpu, &stage.scene, &stage.view, &indirect());
        let error = refused.expect_err("more than any buffer holds");
        std::error::Error::source(&error).expect("a reason").to_string()
    };
    let many = refused(u32::MAX, 1);
    assert!(many.contains("set `vpl.particles` to ") && !many.contains("candidates"), "{many}");
    let chosen = refused(1 << 26, 64);
    assert!(chosen.contains("or `vpl.candidates` below 64"), "{chosen}");
}

#[test]
fn squares_and_boxes_are_met_where_they_are() {
    let ray = |o: [f32; 3], d: [f32; 3]| Ray::new(o.into(), d.into());
    assert_eq!(intersect_square(&ray([0.2, -0.3, 2.0], [0.0, 0.0, -1.0])), Some(2.0));
    assert_eq!(intersect_square(&ray([0.6, 0.0, 2.0], [0.0, 0.0, -1.0])), None);
    assert_eq!(intersect_square(&ray([0.0, 0.0, 2.0], [0.0, 0.0, 1.0])), None);
    assert_eq!(intersect_unit_box(&ray([0.0, 0.0, 2.0], [0.0, 0.0, -1.0])), Some(1.5));
    // From inside: the exit, not the report's 0.
    assert_eq!(intersect_unit_box(&ray([0.0, 0.0, 0.0], [1.0, 0.0, 0.0])), Some(0.5));
    assert_eq!(intersect_unit_box(&ray([0.0, 2.0, 0.0], [1.0, 0.0, 0.0])), None);
}

#[test]
fn the_hierarchy_meets_what_brute_force_meets() {
    let mut stage = room(0.5, 8);
    let ball = Affine3A::from_translation(Vec3::new(-0.6, 0.2, -0.5));
    stage.add(Shape::Sphere { radius: 0.4, segments: 24, rings: 12 }, Vec3::ONE, ball);
    let bvh = SceneBvh::new(&stage.scene);
    let casters = [ParticleCasts::Hierarchy, ParticleCasts::BruteForce].map(|c| Caster::new(&stage.scene, &bvh, c));
    let mut counts = [IntersectionCounts::default(); 2];
    for i in 0..500_u32 {
        let part = |prime: f32| (i as f32 * prime).fract() * 2.0 - 1.0;
        let direction = Vec3::new(part(0.618_034), part(0.754_878), part(0.569_841)).normalize();
        let ray = Ray::new(Vec3::new(-0.3, 0.9, 0.4), direction);
        let [a, b] = [0, 1].map(|k| casters[k].cast(&ray, &mut counts[k]).expect("a closed room"));
        assert!((a.t - b.t).abs() < 1e-4, "ray {i}: {a:?} {b:?}");
        assert_eq!(bvh.triangles[a.triangle as usize].primitive, bvh.triangles[b.triangle as usize].primitive);
    }
    assert_eq!(counts[1].objects, 500 * stage.scene.primitives.len() as u64);
    assert!(counts[0].triangles * 10 < counts[1].triangles, "{counts:?}");
}

/// A turned and stretched ball: its box is met from outside, its triangles from within.
#[test]
fn boxes_stand_for_objects() {
    let mut stage = Stage::new(Vec3::ZERO, Vec3::NEG_Z, 8);
    let turn = Quat::from_rotation_z(0.3);
    let at = Vec3::new(1.0, 2.0, 3.0);
    let place = Affine3A::from_scale_rotation_translation(Vec3::new(2.0, 1.0, 1.0), turn, at);
    stage.add(Shape::Sphere { radius: 0.5, segments: 64, rings: 32 }, Vec3::splat(0.5), place);
    let bvh = SceneBvh::new(&stage.scene);
    let caster = Caster::new(&stage.scene, &bvh, ParticleCasts::Bounds);
    let mut counts = IntersectionCounts::default();
    // Towards the face whose normal is the turned x axis: a metre from the middle, and away from where the ball is.
    let axis = turn * Vec3::X;
    let from = at + 3.0 * axis + turn * Vec3::new(0.0, 0.45, 0.45);
    let hit = caster.cast(&Ray::new(from, -axis), &mut counts).expect("the box");
    let normal = hit.box_normal.expect("no triangle was tested");
    assert!((hit.t - 2.0).abs() < 0.01 && (normal - axis).length() < 1e-4, "{hit:?}, normal {normal}");
    assert_eq!((counts.rays, counts.objects, counts.triangles), (1, 1, 0));
    // A particle that leaves a face does not meet its own box.
    assert!(caster.cast(&Ray::new(from - 1.9999 * axis, axis), &mut counts).is_none());
    assert_eq!(counts.triangles, 0);
    let within = caster.cast(&Ray::new(at, axis), &mut counts).expect("the ball");
    assert!((within.t - 1.0).abs() < 0.01 && within.box_normal.is_none(), "{within:?}");
    assert_eq!(counts.triangles, stage.scene.primitives[0].mesh.triangle_count() as u64);
}

/// Squares and boxes are their own bounds, and light that falls on a ball's box is about that which falls on the ball.
#[test]
fn boxes_stand_for_objects_in_images() {
    let gpu = gpu();
    let of = |stage: &mut Stage, casts| {
        let settings = InstantRadiosity { particles: 256, casts, ..Default::default() };
        let (image, renderer) = draw(&gpu, stage, settings);
        let tests = virtual_lights(renderer.methods()).expect("they were asked for").casts();
        (image, tests)
    };
    let mut stage = room(0.6, 16);
    let [brute, bounds] = [ParticleCasts::BruteForce, ParticleCasts::Bounds].map(|casts| of(&mut stage, casts));
    assert!(brute.0.rgba == bounds.0.rgba && brute.1 == bounds.1, "{:?} {:?}", brute.1, bounds.1);
    let ball = Shape::Sphere { radius: 0.4, segments: 48, rings: 24 };
    stage.add(ball, Vec3::splat(0.6), Affine3A::from_translation(Vec3::new(-0.6, -0.8, -0.5)));
    let [tree, bounds] = [ParticleCasts::Hierarchy, ParticleCasts::Bounds].map(|casts| of(&mut stage, casts));
    let ratio = mean(&bounds.0) / mean(&tree.0);
    assert!((ratio - 1.0).abs() < 0.1 && bounds.0.rgba != tree.0.rgba, "{ratio} of the light");
    // The lamp is outside of the ball's box, and so are all hits.
    assert_eq!(bounds.1.triangles, 0, "{:?}", bounds.1);
}

/// A lit floor seen from a ceiling two metres above: no corner, no bound in reach. The error against the path tracer
/// falls with the root of the number of particles, faster with even numbers, and the mean is that of the tracer.
#[test]
fn the_sum_converges_to_the_path_tracer() {
    let gpu = gpu();
    let mut stage = Stage::new(Vec3::new(0.0, 0.5, 0.0), Vec3::new(0.0, 2.0, 0.001), 8);
    // Small pixels: the tracer takes their mean, the frame their centres.
    stage.view.camera.projection = ViewProjection::Perspective { vertical_fov: 0.3 };
    let plane = |edge: f32| Shape::Plane { size: [edge, edge], subdivisions: [1, 1] };
    stage.add(plane(3.0), Vec3::splat(0.8), Affine3A::IDENTITY);
    let down = Quat::from_rotation_arc(Vec3::Y, Vec3::NEG_Y);
    stage.add(plane(4.0), Vec3::splat(0.5), Affine3A::from_rotation_translation(down, 2.0 * Vec3::Y));
    let shape = LightShape::Spot { inner: 0.5, outer: 0.8 };
    stage.light(shape, Vec3::splat(5.0), Vec3::new(0.2, 1.6, 0.1), Vec3::NEG_Y);
    let mut tracer = PathTracer::new(&gpu);
    let settings = TraceSettings { bounces: Some(1), seed: 3 };
    tracer.begin(&gpu, &stage.scene, &stage.view, &settings).expect("a small scene");
    tracer.advance(&gpu, 16_384).expect("a device");
    let truth = tracer.estimate(&gpu).expect("samples").indirect();
    let mut error = |sequence, particles| {
        let (mut squares, mut bias) = (0.0_f64, 0.0_f64);
        for seed in 0..8 {
            let bounces = Bounces::Count(1);
            let settings = InstantRadiosity { particles, candidates: 1, seed, sequence, bounces, ..Default::default() };
            let image = draw(&gpu, &mut stage, settings).0;
            for (pixel, truth) in image.rgba.iter().zip(truth.pixels()) {
                let difference = f64::from(pixel[0] - truth[0]) / f64::from(truth[0]);
                squares += difference * difference / (8.0 * 64.0);
                bias += difference / (8.0 * 64.0);
            }
        }
        (squares.sqrt(), bias)
    };
    let (few, _) = error(ParticleSequence::Random, 32);
    let (many, bias) = error(ParticleSequence::Random, 512);
    let slope = (many / few).ln() / 16.0_f64.ln();
    assert!((-0.75..-0.3).contains(&slope), "random: {few} to {many}, slope {slope}");
    assert!(bias.abs() < 0.03, "bias {bias}");
    let (few_even, _) = error(ParticleSequence::LowDiscrepancy, 32);
    let (even, bias) = error(ParticleSequence::LowDiscrepancy, 512);
    eprintln!("random {few:.4} to {many:.4}, slope {slope:.2}; even {few_even:.4} to {even:.4}, bias {bias:.4}");
    assert!(even < 0.5 * many && bias.abs() < 0.01, "even {even}, random {many}, bias {bias}");
    assert!((even / few_even).ln() / 16.0_f64.ln() < slope.max(-0.5) - 0.05, "even {few_even} to {even}");
}

/// Lights from the map light the scene as those of the first hits do.
#[test]
fn maps_and_particles_agree_on_the_first_bounce() {
    let gpu = gpu();
    let mut stage = room(0.6, 24);
    let settings = InstantRadiosity { particles: 384, bounces: Bounces::Count(1), ..Default::default() };
    let shot = mean(&draw(&gpu, &mut stage, settings.clone()).0);
    let placed = mean(&draw(&gpu, &mut stage, InstantRadiosity { placement: VirtualPlacement::Rsm, ..settings }).0);
    assert!((placed / shot - 1.0).abs() < 0.05, "maps {placed}, particles {shot}");
}

fn traced(gpu: &Gpu, stage: &Stage, bounces: Option<u32>) -> f32 {
    let mut tracer = PathTracer::new(gpu);
    tracer.begin(gpu, &stage.scene, &stage.view, &TraceSettings { bounces, seed: 3 }).expect("a small scene");
    tracer.advance(gpu, 512).expect("a device");
    let image = tracer.estimate(gpu).expect("samples").indirect();
    let sum: f32 = image.pixels().iter().map(|pixel| pixel.iter().sum::<f32>() / 3.0).sum();
    sum / image.pixels().len() as f32
}

/// The corner between a floor that a lamp lights and a wall: what the bound of few lights takes away is much there.
fn corner() -> Stage {
    let mut stage = Stage::new(Vec3::new(1.2, 0.5, 0.0), Vec3::new(0.0, 0.12, 0.0), 32);
    stage.view.camera.projection = ViewProjection::Perspective { vertical_fov: 0.5 };
    let plane = || Shape::Plane { size: [4.0, 4.0], subdivisions: [1, 1] };
    stage.add(plane(), Vec3::splat(0.7), Affine3A::from_translation(Vec3::new(2.0, 0.0, 0.0)));
    let wall = Quat::from_rotation_arc(Vec3::Y, Vec3::X);
    stage.add(plane(), Vec3::splat(0.7), Affine3A::from_rotation_translation(wall, Vec3::new(0.0, 2.0, 0.0)));
    stage.light(LightShape::Point, Vec3::splat(3.0), Vec3::new(0.9, 1.1, 0.2), Vec3::NEG_Y);
    stage
}

#[test]
fn near_rays_find_what_the_bound_takes_away() {
    let gpu = gpu();
    // Light of a virtual light on the surface that a ray finds is bounded again: the second bounce loses a little.
    for (count, most) in [(1, 0.02), (2, 0.045)] {
        let mut stage = corner();
        let bounces = Bounces::Count(count);
        let truth = traced(&gpu, &stage, Some(count));
        let mut bias = |near_rays| {
            let of_seed = |seed| {
                let settings =
                    InstantRadiosity { particles: 256, near_rays, bounces, seed, ..InstantRadiosity::default() };
                mean(&draw(&gpu, &mut stage, settings).0)
            };
            (0..8).map(of_seed).sum::<f32>() / 8.0 / truth - 1.0
        };
        let (without, with) = (bias(0), bias(InstantRadiosity::default().near_rays));
        eprintln!("{bounces:?}: bias {without} without rays, {with} with them");
        assert!(without < -0.06, "{bounces:?}: the bound shows no more: {without}");
        assert!(with.abs() < most, "{bounces:?}: {with}, without rays {without}");
    }
}

/// As `furnace_of_many_particles`, with the bound and with shadows.
#[test]
fn furnace_with_a_bound_and_near_rays() {
    let gpu = gpu();
    let mut stage = Stage::new(Vec3::new(0.0, 0.0, 0.3), Vec3::ZERO, 16);
    let mut material = Material::diffuse("inside", Vec3::splat(0.5));
    material.double_sided = true;
    stage.add_material(Shape::Sphere { radius: 1.0, segments: 128, rings: 64 }, material, Affine3A::IDENTITY);
    stage.light(LightShape::Point, Vec3::splat(PI), Vec3::ZERO, Vec3::Y);
    let mut of = |near_rays, particles| {
        mean(&draw(&gpu, &mut stage, InstantRadiosity { particles, near_rays, ..Default::default() }).0)
    };
    let (without, with) = (of(0, 64), of(16, 64));
    assert!(without < 0.49 && (with - 0.5).abs() < 0.02, "{with}, without rays {without}");
}

#[test]
fn near_rays_are_skipped_with_a_reason() {
    let gpu = gpu();
    let mut stage = corner();
    let few = InstantRadiosity { particles: 16, ..Default::default() };
    for (settings, why) in [
        (InstantRadiosity { near_rays: 0, ..few.clone() }, "near_rays"),
        (InstantRadiosity { near_bound: 0.0, ..few.clone() }, "near_bound"),
        (InstantRadiosity { visibility: VirtualVisibility::None, ..few.clone() }, "shadows"),
        (InstantRadiosity { placement: VirtualPlacement::Rsm, ..few.clone() }, "maps"),
    ] {
        stage.scene.vpl = Some(settings);
        let (_, report) = stage.render_with(&gpu, &mut Renderer::new(&gpu), &indirect());
        let pass = report.pass("near light").expect("a line in the report");
        assert!(pass.why.contains(why) && !report.ran("near light"), "{report}");
    }
    stage.scene.vpl = Some(few);
    let (_, report) = stage.render_with(&gpu, &mut Renderer::new(&gpu), &indirect());
    assert!(report.ran("near light") && report.ran("near filter, vertical"), "{report}");
}
