//! Frames of a window after sudden changes, object by object: each has the light of now within a few frames, whatever its shape
//! and wherever it stands among the scene's primitives.

use crate::support::{Stage, gpu, rgb};
use glam::{Affine3A, Vec3};
use lightwell::assets::Shape;
use lightwell::gpu::{Gpu, ImageF32};
use lightwell::render::{Layer, RenderSettings, Renderer};
use lightwell::scene::LightShape;
use lightwell::world::{Clpv, Quality};

const EDGE: u32 = 96;
/// Frames before a change.
const LEAD: u32 = 16;
/// Images without averaging whose mean is what a window should show.
const IMAGES: u32 = 16;
/// Reflectances, by which objects are told apart in an image: a ball, a chest and a pillar. All else is the room.
const OBJECTS: [(&str, Vec3); 3] =
    [("ball", Vec3::new(0.7, 0.7, 0.5)), ("chest", Vec3::new(0.7, 0.5, 0.7)), ("pillar", Vec3::new(0.5, 0.7, 0.7))];

fn settings(only: Layer, average: bool) -> RenderSettings {
    RenderSettings { only, display: false, average, ..Default::default() }
}

/// A closed room of 6 m by 3 m by 6 m in which nothing stands yet.
fn room(eye: Vec3, target: Vec3) -> Stage {
    let mut stage = Stage::new(eye, target, EDGE);
    stage.add_room(Vec3::new(-3.0, 0.0, -3.0), Vec3::new(6.0, 3.0, 6.0), Vec3::new(0.6, 0.6, 0.6));
    stage.clpv(1.5 * Vec3::Y, Clpv { quality: Quality::Medium, ..Default::default() });
    stage
}

/// Puts the objects into it: the last of its primitives, so that their number is no multiple of four.
fn furnish(stage: &mut Stage, [ball, chest, pillar]: [Vec3; 3]) {
    let shapes = [
        (Shape::Sphere { radius: 0.6, segments: 32, rings: 16 }, ball),
        (Shape::Box { size: [1.0, 0.8, 0.6] }, chest),
        (Shape::Box { size: [0.7, 1.2, 0.7] }, pillar),
    ];
    for ((shape, at), (_, albedo)) in shapes.into_iter().zip(OBJECTS) {
        stage.add(shape, albedo, Affine3A::from_translation(at));
    }
    assert_ne!(stage.scene.primitives.len() % 4, 0);
}

fn point_light(stage: &mut Stage, intensity: Vec3, at: Vec3) {
    stage.light(LightShape::Point, intensity, at, Vec3::NEG_Y);
}

/// A furnished room with a weak light, and a strong one that is switched.
fn lit_room(strong: Vec3) -> Stage {
    let mut stage = room(Vec3::new(0.5, 1.4, 0.6), Vec3::new(0.1, 0.5, -1.3));
    furnish(&mut stage, [Vec3::new(-1.2, 0.6, -1.0), Vec3::new(1.4, 0.4, -1.6), Vec3::new(0.1, 0.6, -1.5)]);
    point_light(&mut stage, Vec3::splat(1.5), Vec3::new(-2.2, 2.6, 2.2));
    point_light(&mut stage, strong, Vec3::new(1.5, 2.5, -1.0));
    stage
}

/// A room in two halves. Its light comes from beyond a door, which is the first of the primitives that are no walls.
fn parted_room() -> Stage {
    let mut stage = room(Vec3::new(-2.4, 1.9, 2.2), Vec3::new(-1.2, 0.4, -1.0));
    let wall = Vec3::splat(0.6);
    stage.add(Shape::Box { size: [0.06, 2.0, 1.1] }, wall, Affine3A::from_translation(OPEN));
    stage.scene.primitives.last_mut().expect("the door").moving = true;
    for (size, at) in [
        ([0.12, 3.0, 2.5], Vec3::new(0.0, 1.5, -1.75)),
        ([0.12, 3.0, 2.5], Vec3::new(0.0, 1.5, 1.75)),
        ([0.12, 1.0, 1.0], Vec3::new(0.0, 2.5, 0.0)),
    ] {
        stage.add(Shape::Box { size }, wall, Affine3A::from_translation(at));
    }
    furnish(&mut stage, [Vec3::new(-2.2, 0.6, -0.6), Vec3::new(-1.0, 0.4, -0.9), Vec3::new(-0.7, 0.6, 0.7)]);
    point_light(&mut stage, Vec3::splat(0.6), Vec3::new(-2.4, 2.3, -1.6));
    point_light(&mut stage, Vec3::splat(14.0), Vec3::new(1.6, 2.1, 0.2));
    stage
}

const OPEN: Vec3 = Vec3::new(-0.1, 1.0, 1.1);
const SHUT: Vec3 = Vec3::new(-0.1, 1.0, 0.0);

fn move_door(stage: &mut Stage, at: Vec3) {
    let revision = stage.scene.revisions.geometry + 1;
    stage.scene.revisions.geometry = revision;
    let door = stage.scene.primitives.iter_mut().find(|primitive| primitive.moving).expect("a door");
    door.world_from_object = Affine3A::from_translation(at);
    door.bounds = door.mesh.bounds.transformed(&door.world_from_object);
    door.geometry_revision = revision;
}

fn set_strong(stage: &mut Stage, intensity: Vec3) {
    let light = stage.scene.lights.last_mut().expect("the strong light");
    light.intensity = intensity;
    light.revision += 1;
    stage.scene.revisions.lights += 1;
}

/// Mean radiance of the room and of each object.
fn means(image: &ImageF32, albedo: &ImageF32) -> Vec<(&'static str, Vec3)> {
    let mut sums = [(Vec3::ZERO, 0.0_f32); 1 + OBJECTS.len()];
    for (x, y) in (0..EDGE).flat_map(|y| (0..EDGE).map(move |x| (x, y))) {
        let seen = rgb(albedo, x, y);
        let object = OBJECTS.iter().position(|(_, albedo)| seen.abs_diff_eq(*albedo, 0.02));
        let (sum, count) = &mut sums[object.map_or(0, |index| index + 1)];
        *sum += rgb(image, x, y);
        *count += 1.0;
    }
    let names = ["room"].into_iter().chain(OBJECTS.map(|(name, _)| name));
    assert!(sums.iter().all(|(_, count)| *count > 150.0), "all objects are in view: {sums:?}");
    names.zip(sums).map(|(name, (sum, count))| (name, sum / count)).collect()
}

fn draw(gpu: &Gpu, renderer: &mut Renderer, stage: &Stage, settings: &RenderSettings) -> ImageF32 {
    stage.render_with(gpu, renderer, settings).0
}

/// Mean light of images without averaging, with shifted pixel grids.
fn expected(gpu: &Gpu, stage: &mut Stage, albedo: &ImageF32) -> Vec<(&'static str, Vec3)> {
    let settings = RenderSettings { images: IMAGES, ..settings(Layer::Indirect, false) };
    let mut renderer = Renderer::new(gpu);
    let mut sums: Vec<(&str, Vec3)> = Vec::new();
    for index in 0..IMAGES {
        stage.view.jitter = [(index % 4) as f32 / 4.0 - 0.375, (index / 4) as f32 / 4.0 - 0.375];
        let found = means(&draw(gpu, &mut renderer, stage, &settings), albedo);
        match sums.is_empty() {
            true => sums = found,
            false => sums.iter_mut().zip(found).for_each(|((_, sum), (_, mean))| *sum += mean),
        }
    }
    stage.view.jitter = [0.0; 2];
    sums.into_iter().map(|(name, sum)| (name, sum / IMAGES as f32)).collect()
}

/// Draws a window in which everything changes in the frames that `steps` are for. After three frames of the last state each
/// mean is within the first tolerance of that of images without averaging, and after ten within the second.
fn assert_followed(gpu: &Gpu, mut stage: Stage, steps: &[&dyn Fn(&mut Stage)], tolerances: [f32; 2]) {
    let window = settings(Layer::Indirect, true);
    let mut renderer = Renderer::new(gpu);
    for _ in 0..LEAD {
        draw(gpu, &mut renderer, &stage, &window);
    }
    let mut shown = Vec::new();
    for step in steps {
        step(&mut stage);
        shown = vec![draw(gpu, &mut renderer, &stage, &window)];
    }
    shown.extend((1..10).map(|_| draw(gpu, &mut renderer, &stage, &window)));
    let albedo = draw(gpu, &mut Renderer::new(gpu), &stage, &settings(Layer::Albedo, false));
    let expected = expected(gpu, &mut stage, &albedo);
    let mut off = Vec::new();
    for (number, tolerance) in [3, 10].into_iter().zip(tolerances) {
        for ((name, found), (_, expected)) in means(&shown[number - 1], &albedo).into_iter().zip(&expected) {
            let scale = expected.max(Vec3::splat(expected.element_sum() / 3.0));
            let error = ((found - *expected).abs() / scale).max_element();
            let line = format!("{name}, frame {number}: {found}, not {expected}: off by {error}");
            println!("{line}");
            off.extend((error > tolerance).then_some(line));
        }
    }
    assert!(off.is_empty(), "{off:#?}");
}

const WHITE: Vec3 = Vec3::splat(10.0);
const TOLERANCES: [f32; 2] = [0.05, 0.05];

#[test]
fn a_light_that_is_switched_off_leaves_all_objects_at_once() {
    assert_followed(&gpu(), lit_room(WHITE), &[&|stage| set_strong(stage, Vec3::ZERO)], TOLERANCES);
}

#[test]
fn a_light_that_is_switched_on_reaches_all_objects_at_once() {
    assert_followed(&gpu(), lit_room(Vec3::ZERO), &[&|stage| set_strong(stage, WHITE)], TOLERANCES);
}

#[test]
fn a_light_that_changes_its_color_does_so_on_all_objects_at_once() {
    let red = Vec3::new(10.0, 1.0, 0.5);
    assert_followed(&gpu(), lit_room(WHITE), &[&|stage| set_strong(stage, red)], TOLERANCES);
}

/// In a second, by a few per cent a frame.
#[test]
fn a_light_that_fades_fades_on_all_objects() {
    let levels: Vec<f32> = (1..=30).map(|frame| 1.0 - frame as f32 / 40.0).collect();
    let steps: Vec<_> = levels.iter().map(|level| move |stage: &mut Stage| set_strong(stage, *level * WHITE)).collect();
    let steps: Vec<&dyn Fn(&mut Stage)> = steps.iter().map(|step| step as &dyn Fn(&mut Stage)).collect();
    assert_followed(&gpu(), lit_room(WHITE), &steps, TOLERANCES);
}

#[test]
fn a_door_that_shuts_takes_the_light_of_all_objects() {
    let part = |share: f32| move |stage: &mut Stage| move_door(stage, OPEN.lerp(SHUT, share));
    assert_followed(&gpu(), parted_room(), &[&part(0.3), &part(0.6), &part(1.0)], [0.08, 0.05]);
}
