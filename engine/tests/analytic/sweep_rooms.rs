//! Rooms that the sweep must keep apart: light stays where walls hold it, however near to each other they stand.

use crate::support::{Stage, gpu};
use glam::{Affine3A, Quat, Vec3};
use lightwell::assets::{Material, Shape};
use lightwell::gpu::{Gpu, ImageF32};
use lightwell::render::{GiMethod, Layer};
use lightwell::scene::LightShape;
use lightwell::world::{Bounces, Clpv, GatherRays, Quality};

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

/// The walls go through from the room to the attic: a patch that lay on both sides of the ceiling would mix their light.
#[test]
fn an_attic_of_sharp_angles_keeps_its_light() {
    let gpu = gpu();
    for (quality, most) in [(Quality::Low, 0.002), (Quality::Medium, 0.001)] {
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

/// A closed room of which everything but a partition goes through from one half to the other, turned about two axes. The
/// partition is so thick [m], stands askew, and ends so far before a wall [m]; a lamp burns behind it.
fn parted(thickness: f32, gap: f32, angle: f32, is_lit_half: bool, rays: GatherRays) -> Stage {
    let turn = Affine3A::from_quat(Quat::from_euler(glam::EulerRot::YXZ, 0.4, 0.3, 0.0));
    let at = |point: Vec3| turn.transform_point3(point);
    let side = if is_lit_half { -1.0 } else { 1.0 };
    let mut stage = Stage::new(at(Vec3::new(1.7 * side, 0.6, 0.9)), at(Vec3::new(0.0, -0.8, -0.9)), 48);
    let mut add = |size: [f32; 3], place: Affine3A| {
        stage.add(Shape::Box { size }, Vec3::splat(0.8), turn * place);
    };
    for side in [-1.0, 1.0] {
        add([4.2, 0.1, 3.2], Affine3A::from_translation(Vec3::Y * 1.05 * side));
        add([0.1, 2.0, 3.2], Affine3A::from_translation(Vec3::X * 2.05 * side));
        add([4.0, 2.0, 0.1], Affine3A::from_translation(Vec3::Z * 1.55 * side));
    }
    // Through all that it stands at, but for its free end.
    let partition = Affine3A::from_rotation_y(angle) * Affine3A::from_translation(Vec3::new(0.02, 0.0, -0.5 * gap));
    let length = if gap > 0.0 { 3.0 - gap } else { 3.16 / angle.cos() };
    add([thickness, 2.08, length], partition);
    stage.light(LightShape::Point, Vec3::splat(5.0), at(Vec3::new(-1.2, 0.4, 0.3)), Vec3::NEG_Y);
    let clpv = Clpv { gather_rays: rays, ..settings(Quality::Medium, Bounces::Converged) };
    stage.clpv(Vec3::ZERO, clpv);
    stage
}

fn passed(gpu: &Gpu, thickness: f32, gap: f32, angle: f32, rays: GatherRays) -> f32 {
    let of = |is_lit_half| mean(&indirect(gpu, &parted(thickness, gap, angle, is_lit_half, rays)));
    let (dark, lit) = (of(false), of(true));
    println!("{thickness} m thick, {gap} m open, turned by {angle}, {rays:?}: {} of {lit}", dark / lit);
    assert!(lit > 0.1, "{lit} in the lit half");
    dark / lit
}

/// Floor, ceiling and walls go through, and have patches on both sides of the partition.
#[test]
fn no_light_passes_a_partition_however_thin_and_askew() {
    let gpu = gpu();
    for (thickness, angle) in [(0.01, 0.0), (0.01, 0.35), (0.1, 0.2)] {
        let of_rays = passed(&gpu, thickness, 0.0, angle, GatherRays::Count(16));
        assert!(of_rays < 1e-4, "{thickness} m thick, turned by {angle}: {of_rays}");
        // Volumes have cells that lie on both sides.
        let of_volumes = passed(&gpu, thickness, 0.0, angle, GatherRays::Count(0));
        assert!(of_volumes < 0.02, "{thickness} m thick, turned by {angle}, volumes alone: {of_volumes}");
    }
}

/// Cells that a solid fills for the most part are as dark as the solid: the floor beside it must not take its light from
/// them. The lamp hangs in the middle; what the block shades is lit by the walls.
#[test]
fn the_floor_at_the_foot_of_a_turned_block_is_lit() {
    let gpu = gpu();
    let half = 0.33;
    for degrees in [0.0_f32, 17.0, 31.0, 45.0, 62.0, 73.0] {
        let mut stage = Stage::new(Vec3::new(0.0, 1.3, 0.0), Vec3::new(0.0, -1.5, 0.0), 96);
        stage.add_room(Vec3::splat(-1.5), Vec3::splat(3.0), Vec3::splat(0.7));
        let (turn, at) = (Quat::from_rotation_y(degrees.to_radians()), Vec3::new(0.43, half - 1.5, 0.31));
        let block = Affine3A::from_rotation_translation(turn, at);
        stage.add(Shape::Box { size: [2.0 * half; 3] }, Vec3::splat(0.7), block);
        stage.light(LightShape::Point, Vec3::splat(5.0), Vec3::new(-0.4, 1.0, -0.5), Vec3::NEG_Y);
        stage.clpv(Vec3::ZERO, settings(Quality::Low, Bounces::Count(4)));
        let image = indirect(&gpu, &stage);
        let eye = Vec3::from(stage.view.camera.world_from_view.translation);
        let mut floor = Vec::new();
        for (x, y) in (0..96).flat_map(|y| (0..96).map(move |x| (x, y))) {
            let ray = stage.ray(x, y);
            let point = eye + ray * ((-1.5 - eye.y) / ray.y);
            let beside = block.inverse().transform_point3(point).abs();
            // A pixel away from walls and block, and not behind it.
            let is_hidden = (1..60).any(|step| {
                let way = block.inverse().transform_point3(eye.lerp(point, step as f32 / 60.0)).abs();
                way.max_element() < half + 0.05
            });
            if ray.y < 0.0 && point.abs().max_element() < 1.501 && beside.x.max(beside.z) > half + 0.05 && !is_hidden {
                floor.push(image.rgba[(x + 96 * y) as usize][0]);
            }
        }
        let mean = floor.iter().sum::<f32>() / floor.len() as f32;
        let darkest = floor.iter().copied().fold(f32::INFINITY, f32::min);
        println!("{degrees}°: darkest {} of the mean, {} pixels", darkest / mean, floor.len());
        assert!(floor.len() > 500 && darkest > 0.2 * mean, "{degrees}°: {darkest} of {mean}");
    }
}

/// A block whose faces slant through the cells, seen along the normal of one: the largest change from pixel to pixel over its
/// mean, away from the block's edges.
fn largest_step(gpu: &Gpu, degrees: f32) -> f32 {
    let turn = Quat::from_rotation_y(degrees.to_radians());
    let mut stage = Stage::new(turn * Vec3::new(0.0, 0.0, 1.3), Vec3::ZERO, 64);
    stage.add_room(Vec3::splat(-2.0), Vec3::splat(4.0), Vec3::new(0.7, 0.6, 0.5));
    let block = Shape::Box { size: [2.4, 2.4, 0.6] };
    stage.add(block, Vec3::splat(0.7), Affine3A::from_quat(turn));
    stage.light(LightShape::Point, Vec3::splat(2.0), Vec3::new(1.2, 1.5, 1.5), Vec3::NEG_Y);
    stage.clpv(Vec3::ZERO, settings(Quality::Low, Bounces::Converged));
    let image = indirect(gpu, &stage);
    let at = |x: u32, y: u32| image.rgba[(x + y * image.width) as usize][1];
    let inner = 6..image.width - 7;
    let steps = inner.clone().flat_map(|y| inner.clone().map(move |x| (x, y)));
    let steps = steps.map(|(x, y)| (at(x + 1, y) - at(x, y)).abs().max((at(x, y + 1) - at(x, y)).abs()));
    steps.fold(0.0, f32::max) / mean(&image)
}

#[test]
fn slanting_faces_have_no_steps_from_cell_to_cell() {
    let gpu = gpu();
    for degrees in [5.0, 17.0] {
        let step = largest_step(&gpu, degrees);
        println!("{degrees}°: {step}");
        assert!(step < 0.03, "{degrees}°: light changes by {step} of its mean from pixel to pixel");
    }
}
