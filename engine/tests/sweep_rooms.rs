//! Rooms that the sweep must keep apart: light stays where walls hold it, however near to each other they stand.

mod support;

use glam::{Affine3A, Quat, Vec3};
use lightwell::assets::{Material, Shape};
use lightwell::gpu::{Gpu, ImageF32};
use lightwell::render::{GiMethod, Layer};
use lightwell::scene::LightShape;
use lightwell::world::{Bounces, Clpv, GatherRays, Quality};
use support::{Stage, gpu};

fn settings(quality: Quality, bounces: Bounces) -> Clpv {
    Clpv { quality, bounces, gather_rays: GatherRays::Count(0), ..Default::default() }
}

fn mean(image: &ImageF32) -> f32 {
    image.rgba.iter().map(|p| p[0]).sum::<f32>() / image.rgba.len() as f32
}

fn indirect(gpu: &Gpu, stage: &Stage) -> ImageF32 {
    stage.render(gpu, GiMethod::CLPV, Layer::Indirect)
}

/// A house of thin sheets, seen from `eye`: a room of 6 × 3 × 4 m, and above it an attic under two slopes, which meet the
/// ceiling at sharp angles. A lamp burns in the attic.
fn house(eye: Vec3, target: Vec3, clpv: Clpv) -> Stage {
    let mut stage = Stage::new(eye, target, 48);
    let mut sheet = |width: f32, depth: f32, rotation: Quat, at: Vec3| {
        let material = Material { double_sided: true, ..Material::diffuse("plaster", Vec3::splat(0.7)) };
        let plane = Shape::Plane { size: [width, depth], subdivisions: [1, 1] };
        stage.add_material(plane, material, Affine3A::from_rotation_translation(rotation, at));
    };
    let upright = |turn: f32| Quat::from_rotation_y(turn) * Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
    sheet(6.0, 4.0, Quat::IDENTITY, Vec3::new(0.0, -1.5, 0.0));
    sheet(6.0, 4.0, Quat::IDENTITY, Vec3::new(0.0, 1.5, 0.0));
    for side in [-1.0, 1.0] {
        sheet(6.2, 5.0, upright(0.0), Vec3::new(0.0, 0.9, 2.0 * side));
        sheet(4.0, 3.0, upright(std::f32::consts::FRAC_PI_2), Vec3::new(3.0 * side, 0.0, 0.0));
        // From the eaves at ±3 m up to the ridge, and a little over both.
        let slope = 1.5_f32.atan2(3.0);
        let roof = Vec3::new(1.5 * side, 2.25, 0.0);
        sheet(2.0 * 1.5 / slope.cos() + 0.02, 4.0, Quat::from_rotation_z(-side * slope), roof);
    }
    stage.light(LightShape::Point, Vec3::splat(50.0), Vec3::new(0.3, 2.2, -0.2), Vec3::NEG_Y);
    stage.clpv(Vec3::ZERO, clpv);
    stage
}

/// The walls go through from the room to the attic: a patch that lies on both sides of the ceiling mixes their light.
#[test]
fn an_attic_of_sharp_angles_keeps_its_light() {
    let gpu = gpu();
    for (quality, most) in [(Quality::Low, 0.006), (Quality::Medium, 0.004)] {
        let settings = settings(quality, Bounces::Converged);
        let attic = house(Vec3::new(0.5, 1.8, 0.0), Vec3::new(-2.0, 1.7, 0.3), settings.clone());
        let room = house(Vec3::new(2.0, 0.0, 0.0), Vec3::new(-2.0, 0.6, 0.3), settings);
        let (attic, room) = (mean(&indirect(&gpu, &attic)), mean(&indirect(&gpu, &room)));
        println!("{quality:?}: {room} of {attic}");
        assert!(attic > 1.0 && room < most * attic, "{quality:?}: {room} in the room, {attic} in the attic");
    }
}

/// Two closed rooms with a lamp each, seen from within the second.
fn neighbours(first: f32, second: f32) -> Stage {
    let mut stage = Stage::new(Vec3::new(3.6, 0.6, 1.5), Vec3::new(1.0, -0.4, -1.2), 48);
    stage.add_room(Vec3::new(-4.2, -2.0, -2.0), Vec3::new(4.0, 4.0, 4.0), Vec3::splat(0.8));
    stage.add_room(Vec3::new(0.2, -2.0, -2.0), Vec3::new(4.0, 4.0, 4.0), Vec3::splat(0.5));
    stage.light(LightShape::Point, Vec3::splat(first), Vec3::new(-2.0, 0.4, 0.3), Vec3::NEG_Y);
    stage.light(LightShape::Point, Vec3::splat(second), Vec3::new(2.2, 0.6, -0.2), Vec3::NEG_Y);
    stage.clpv(Vec3::ZERO, settings(Quality::Low, Bounces::Count(6)));
    stage
}

#[test]
fn a_bright_room_changes_nothing_next_door() {
    let gpu = gpu();
    let alone = indirect(&gpu, &neighbours(0.0, 2.0));
    let beside = indirect(&gpu, &neighbours(2000.0, 2.0));
    let difference = (mean(&beside) / mean(&alone) - 1.0).abs();
    println!("difference {difference}");
    assert!(difference < 1e-3, "{} alone, {} beside a bright room", mean(&alone), mean(&beside));
}

#[test]
fn all_bounces_of_two_lamps_are_the_sum_of_each() {
    let gpu = gpu();
    let [first, second, both] = [(2.0, 0.0), (0.0, 3.0), (2.0, 3.0)].map(|(first, second)| {
        let mut stage = neighbours(0.0, first);
        stage.light(LightShape::Point, Vec3::splat(second), Vec3::new(3.4, -0.9, 1.2), Vec3::NEG_Y);
        indirect(&gpu, &stage)
    });
    let apart = |i: usize| (first.rgba[i][0] + second.rgba[i][0] - both.rgba[i][0]).abs();
    let most = (0..both.rgba.len()).map(apart).fold(0.0, f32::max);
    assert!(most < 1e-4 * mean(&both), "{most} of {}", mean(&both));
}

#[test]
fn no_sky_shines_through_the_backs_of_walls() {
    let gpu = gpu();
    for degrees in [0.0_f32, 17.0, 45.0] {
        let mut stage = neighbours(0.0, 0.0);
        stage.scene.sky = Vec3::ONE;
        let turn = Affine3A::from_rotation_y(degrees.to_radians());
        for primitive in &mut stage.scene.primitives {
            primitive.world_from_object = turn * primitive.world_from_object;
            primitive.bounds = primitive.mesh.bounds.transformed(&primitive.world_from_object);
        }
        stage.view.camera.world_from_view = turn * stage.view.camera.world_from_view;
        let leaked = mean(&indirect(&gpu, &stage)) / 0.5;
        println!("{degrees}°: {leaked}");
        assert!(leaked < 0.01, "turned by {degrees}°: {leaked} of the sky's radiance");
    }
}
