//! Light of further bounces: radiosity of patches along links, against formulas and the path tracer.

use crate::support::{Stage, error, gpu};
use glam::{Affine3A, EulerRot, Quat, Vec3};
use lightwell::assets::{AlphaMode, Material, Shape};
use lightwell::gpu::{Gpu, ImageF32};
use lightwell::graph::{FrameReport, PassState};
use lightwell::measure::Image;
use lightwell::render::reference::{PathTracer, TraceSettings};
use lightwell::render::{GiMethod, Layer, RenderSettings, Renderer};
use lightwell::scene::LightShape;
use lightwell::world::{Bounces, Clpv, GatherRays, Quality};

fn mean(image: &ImageF32) -> Vec3 {
    let sum = image.rgba.iter().fold(Vec3::ZERO, |sum, p| sum + Vec3::new(p[0], p[1], p[2]));
    sum / image.rgba.len() as f32
}

fn indirect(gpu: &Gpu, stage: &Stage) -> ImageF32 {
    stage.render(gpu, GiMethod::CLPV, Layer::Indirect)
}

/// Mean of 16 images, each with rays of its own, over the area of the pixels as the path tracer has it.
fn averaged(gpu: &Gpu, mut stage: Stage) -> ImageF32 {
    let settings = RenderSettings { gi: GiMethod::CLPV, only: Layer::Indirect, images: 16, ..Default::default() };
    let mut renderer = Renderer::new(gpu);
    let mut image = |index: u8| {
        stage.view.jitter = [index % 4, index / 4].map(|place| (f32::from(place) + 0.5) / 4.0 - 0.5);
        stage.render_with(gpu, &mut renderer, &settings).0
    };
    let mut sum = image(0);
    for index in 1..16 {
        let next = image(index);
        sum.rgba.iter_mut().zip(&next.rgba).for_each(|(a, b)| (0..3).for_each(|c| a[c] += b[c]));
    }
    sum.rgba.iter_mut().for_each(|pixel| pixel.iter_mut().for_each(|value| *value /= 16.0));
    sum
}

fn traced(gpu: &Gpu, stage: &Stage, bounces: Option<u32>, samples: u32) -> Image {
    let mut tracer = PathTracer::new(gpu);
    let settings = TraceSettings { bounces, seed: 3 };
    tracer.begin(gpu, &stage.scene, &stage.view, &settings).expect("a scene that can be traced");
    tracer.advance(gpu, samples).expect("a device");
    let [mut image, odd] = tracer.estimate(gpu).expect("an image").indirect;
    for (pixel, other) in image.pixels_mut().iter_mut().zip(odd.pixels()) {
        (0..3).for_each(|channel| pixel[channel] = 0.5 * (pixel[channel] + other[channel]));
    }
    image
}

/// A closed room of bright walls with a box and a partition, all turned about two axes.
fn turned_room(material: Material, settings: Clpv) -> Stage {
    let turn = Affine3A::from_quat(Quat::from_euler(EulerRot::YXZ, 0.47, 0.31, 0.0));
    let at = |point: Vec3| turn.transform_point3(point);
    let mut stage = Stage::new(at(Vec3::new(1.6, 0.5, 1.6)), at(Vec3::new(-1.0, -0.5, -1.0)), 64);
    let mut add = |size: [f32; 3], center: Vec3, color: Vec3| {
        let material = Material { base_color: color.extend(1.0), ..material.clone() };
        stage.add_material(Shape::Box { size }, material, turn * Affine3A::from_translation(center));
    };
    let white = Vec3::splat(0.85);
    for side in [-1.0, 1.0] {
        let wall = if side < 0.0 { Vec3::new(0.8, 0.1, 0.1) } else { Vec3::new(0.1, 0.2, 0.8) };
        add([4.2, 0.1, 4.2], Vec3::Y * (1.3 * side), white);
        add([0.1, 2.5, 4.2], Vec3::X * (2.05 * side), wall);
        add([4.0, 2.5, 0.1], Vec3::Z * (2.05 * side), white);
    }
    add([0.1, 2.0, 1.6], Vec3::new(-0.6, -0.25, 0.5), white);
    add([0.7; 3], Vec3::new(-0.9, -0.9, -1.0), white);
    stage.light(LightShape::Point, Vec3::splat(3.0), at(Vec3::new(0.8, 0.8, -0.6)), Vec3::NEG_Y);
    stage.clpv(Vec3::ZERO, settings);
    stage
}

fn diffuse() -> Material {
    Material::diffuse("paint", Vec3::ONE)
}

/// Sweeps lost 7 % of the light here: grids have a direction, and their calibration hid it in rooms along the axes alone.
#[test]
fn a_turned_room_is_as_bright_as_the_path_tracer_has_it() {
    let gpu = gpu();
    let settings = Clpv { quality: Quality::Medium, ..Default::default() };
    let stage = turned_room(diffuse(), settings);
    let expected = traced(&gpu, &stage, None, 1024);
    let (nrmse, bias) = error(&averaged(&gpu, stage), &expected);
    assert!(bias.abs() < 0.01 && nrmse < 0.05, "bias {bias}, nrmse {nrmse}");
}

#[test]
fn each_bounce_is_that_of_the_path_tracer() {
    let gpu = gpu();
    for bounces in [2, 3, 5] {
        let settings = Clpv { quality: Quality::Medium, bounces: Bounces::Count(bounces), ..Default::default() };
        let stage = turned_room(diffuse(), settings);
        let expected = traced(&gpu, &stage, Some(bounces), 512);
        let (_, bias) = error(&averaged(&gpu, stage), &expected);
        assert!(bias.abs() < 0.012, "{bounces} bounces: bias {bias}");
    }
}

/// Metal reflects light that others see too.
#[test]
fn glossy_walls_send_light_on() {
    let gpu = gpu();
    let metal = Material { metallic: 1.0, roughness: 0.6, ..Material::new("metal") };
    let stage = turned_room(metal, Clpv { quality: Quality::Medium, ..Default::default() });
    let expected = traced(&gpu, &stage, None, 1024);
    let found = averaged(&gpu, stage);
    let (_, bias) = error(&found, &expected);
    assert!(bias.abs() < 0.1, "bias {bias}");
}

/// All sides of a closed box send out radiance 1 and reflect half of what arrives: there is radiance 2 everywhere, of which
/// one half is emitted and the other indirect.
#[test]
fn a_furnace_has_twice_its_light_whichever_way_it_stands() {
    let gpu = gpu();
    for turn in [0.0, 0.6] {
        let place = Affine3A::from_rotation_y(turn) * Affine3A::from_rotation_x(0.7 * turn);
        let mut stage = Stage::new(Vec3::splat(0.2), Vec3::new(-0.5, -0.3, -1.0), 32);
        let material =
            Material { emissive: Vec3::ONE, double_sided: true, ..Material::diffuse("glow", Vec3::splat(0.5)) };
        stage.add_material(Shape::Box { size: [3.0, 2.5, 4.0] }, material, place);
        for rays in [GatherRays::Auto, GatherRays::Count(0)] {
            stage.clpv(Vec3::ZERO, Clpv { quality: Quality::Medium, gather_rays: rays, ..Default::default() });
            let found = mean(&indirect(&gpu, &stage));
            // Volumes lose a tenth on their way to the walls of a room that is turned against them.
            let most = if rays == GatherRays::Auto { 0.01 } else { 0.12 };
            assert!((found - Vec3::ONE).abs().max_element() < most, "turned by {turn}, {rays:?}: {found}");
        }
    }
}

/// A blended pane in a furnace covers a share of all rays, and sends back as much light as they would have met beyond it.
#[test]
fn a_blended_pane_takes_no_light_from_a_furnace() {
    let gpu = gpu();
    let mut stage = Stage::new(Vec3::splat(0.2), Vec3::new(-0.5, -0.3, -1.0), 32);
    let shining =
        |name: &str| Material { emissive: Vec3::ONE, double_sided: true, ..Material::diffuse(name, Vec3::splat(0.5)) };
    let mut glass = shining("glass");
    (glass.alpha_mode, glass.base_color.w) = (AlphaMode::Blend, 0.4);
    stage.add_material(Shape::Box { size: [3.0, 2.5, 4.0] }, shining("glow"), Affine3A::IDENTITY);
    // Out of sight.
    let upright =
        Affine3A::from_rotation_translation(Quat::from_rotation_x(std::f32::consts::FRAC_PI_2), Vec3::Z * 0.8);
    stage.add_material(Shape::Plane { size: [2.8, 2.3], subdivisions: [1; 2] }, glass, upright);
    stage.clpv(Vec3::ZERO, Clpv { quality: Quality::Medium, ..Default::default() });
    let found = mean(&indirect(&gpu, &stage));
    assert!((found - Vec3::ONE).abs().max_element() < 0.01, "{found}");
}

fn ran(report: &FrameReport, name: &str) -> bool {
    report.passes.iter().any(|pass| pass.name == name && pass.state == PassState::Ran)
}

/// Rays go out again only where something moves; a light that moves needs shadow rays alone, and the camera nothing.
#[test]
fn links_are_kept_while_nothing_moves() {
    let gpu = gpu();
    let mut stage =
        turned_room(diffuse(), Clpv { quality: Quality::Low, gather_rays: GatherRays::Count(2), ..Default::default() });
    let settings = RenderSettings { gi: GiMethod::CLPV, only: Layer::Indirect, ..Default::default() };
    let mut renderer = Renderer::new(&gpu);
    let mut frame = |stage: &Stage| {
        let report = stage.render_with(&gpu, &mut renderer, &settings).1;
        ["surfel links", "first bounce", "radiosity", "gather"].map(|name| ran(&report, name))
    };
    assert_eq!(frame(&stage), [true; 4]);
    assert_eq!(frame(&stage), [false; 4]);
    stage.view.jitter = [0.25, 0.25];
    assert_eq!(frame(&stage), [false, false, false, true]);
    stage.scene.lights[0].position.x += 0.1;
    stage.scene.lights[0].revision += 1;
    stage.scene.revisions.lights += 1;
    assert_eq!(frame(&stage), [false, true, true, true]);
    stage.scene.primitives[0].world_from_object.translation.y -= 0.1;
    stage.scene.revisions.geometry += 1;
    assert_eq!(frame(&stage), [true; 4]);
}

/// Twice the light is exactly twice the image, and none is none.
#[test]
fn all_bounces_are_linear_in_the_lights() {
    let gpu = gpu();
    let mut stage =
        turned_room(diffuse(), Clpv { quality: Quality::Low, gather_rays: GatherRays::Count(2), ..Default::default() });
    let once = indirect(&gpu, &stage);
    stage.scene.lights[0].intensity *= 1024.0;
    let scaled = indirect(&gpu, &stage);
    let is_scaled = once.rgba.iter().zip(&scaled.rgba).all(|(a, b)| (0..3).all(|c| a[c] * 1024.0 == b[c]));
    assert!(is_scaled);
    stage.scene.lights[0].intensity = Vec3::ZERO;
    assert_eq!(mean(&indirect(&gpu, &stage)), Vec3::ZERO);
}
