//! Windows that bring the light between surfaces up to date over several frames: they follow slow changes closely, sudden ones at
//! once, cast fewer rays meanwhile, and come to rest in the same light to the bit.

use crate::support::{Stage, gpu};
use glam::{Affine3A, Vec3};
use lightwell::assets::Shape;
use lightwell::gpu::{Gpu, read_buffer};
use lightwell::graph::FrameReport;
use lightwell::render::{Layer, RenderSettings, Renderer, UpdateRate};
use lightwell::scene::{LightShape, SceneLight};
use lightwell::world::{Clpv, Quality};

type Change = fn(&mut SceneLight);

const EDGE: u32 = 32;
/// Frames after the last change until all light is computed whole.
const UNREST: u32 = 9;

/// A closed room of 4 m with a box in it that may move.
fn room() -> Stage {
    let mut stage = Stage::new(Vec3::new(1.6, 0.6, 1.7), Vec3::new(-1.0, -1.0, -1.2), EDGE);
    stage.add_room(Vec3::splat(-2.0), Vec3::splat(4.0), Vec3::new(0.7, 0.55, 0.4));
    stage.add(Shape::Box { size: [0.8, 1.2, 0.8] }, Vec3::new(0.8, 0.2, 0.2), Affine3A::from_translation(STANDING));
    stage.scene.primitives.last_mut().expect("the box").moving = true;
    stage.light(LightShape::Point, Vec3::splat(0.3), Vec3::new(-1.2, 1.0, 1.0), Vec3::NEG_Y);
    // The one that changes.
    stage.light(LightShape::Point, Vec3::splat(2.0), Vec3::new(0.3, 1.2, -0.2), Vec3::NEG_Y);
    stage.clpv(Vec3::ZERO, Clpv { quality: Quality::Medium, ..Default::default() });
    stage
}

const STANDING: Vec3 = Vec3::new(-0.5, -1.4, -0.4);

fn move_box(stage: &mut Stage, by: Vec3) {
    let revision = stage.scene.revisions.geometry + 1;
    stage.scene.revisions.geometry = revision;
    let moved = stage.scene.primitives.last_mut().expect("the box");
    moved.world_from_object.translation += glam::Vec3A::from(by);
    moved.bounds = moved.mesh.bounds.transformed(&moved.world_from_object);
    moved.geometry_revision = revision;
}

fn change_light(stage: &mut Stage, change: impl FnOnce(&mut lightwell::scene::SceneLight)) {
    let light = stage.scene.lights.last_mut().expect("a light");
    change(light);
    light.revision += 1;
    stage.scene.revisions.lights += 1;
}

/// A window of some rate.
struct Window<'g> {
    gpu: &'g Gpu,
    renderer: Renderer,
    settings: RenderSettings,
}

impl<'g> Window<'g> {
    fn new(gpu: &'g Gpu, update: UpdateRate) -> Self {
        let settings =
            RenderSettings { only: Layer::Indirect, display: false, average: true, update, ..Default::default() };
        Self { gpu, renderer: Renderer::new(gpu), settings }
    }

    /// Draws a frame; the light of the patches in it, and what was done.
    fn draw(&mut self, stage: &Stage) -> (Vec<[f32; 4]>, FrameReport) {
        let (_, report) = stage.render_with(self.gpu, &mut self.renderer, &self.settings);
        let buffer = self.renderer.buffer("light of patches").expect("patches");
        (read_buffer(self.gpu, buffer).expect("readable"), report)
    }
}

/// Mean difference of light over its mean.
fn apart(a: &[[f32; 4]], b: &[[f32; 4]]) -> f32 {
    let sum = |f: &dyn Fn(usize, usize) -> f32| {
        (0..a.len()).flat_map(|i| (0..3).map(move |k| (i, k))).map(|(i, k)| f(i, k)).sum::<f32>()
    };
    sum(&|i, k| (a[i][k] - b[i][k]).abs()) / sum(&|i, k| b[i][k])
}

fn rays(report: &FrameReport, pass: &str) -> u64 {
    report.pass(pass).map_or(0, |pass| pass.counts.rays)
}

#[test]
fn slow_changes_are_followed_closely_and_end_in_the_same_light() {
    let gpu = gpu();
    for update in [UpdateRate::Half, UpdateRate::Quarter] {
        let mut stage = room();
        let (mut whole, mut part) = (Window::new(&gpu, UpdateRate::Whole), Window::new(&gpu, update));
        let [(a, _), (b, _)] = [whole.draw(&stage), part.draw(&stage)];
        assert!(a == b, "the first frame is whole");
        for frame in 0..12 {
            move_box(&mut stage, Vec3::new(0.03, 0.0, 0.01));
            change_light(&mut stage, |light| {
                light.position.x -= 0.04;
                light.intensity *= 1.01;
            });
            let [(a, of_whole), (b, of_part)] = [whole.draw(&stage), part.draw(&stage)];
            let difference = apart(&b, &a);
            assert!(difference < 0.06, "{update:?}, frame {frame}: light is {difference} off");
            for pass in ["first bounce", "surfel links"] {
                let [all, some] = [rays(&of_whole, pass), rays(&of_part, pass)];
                // Where a box begins to move, its surfels are others once, and all links are.
                let is_share = (some * u64::from(update.frames())).abs_diff(all) <= all / 50;
                assert!(frame < 2 || is_share, "{update:?}, frame {frame}: {pass} casts {some} of {all} rays");
            }
        }
        for _ in 0..UNREST {
            whole.draw(&stage);
            part.draw(&stage);
        }
        let [(a, _), (b, report)] = [whole.draw(&stage), part.draw(&stage)];
        assert!(a == b, "{update:?}: at rest the light is {} off", apart(&b, &a));
        assert_eq!(rays(&report, "first bounce"), 0, "and nothing is cast");
    }
}

#[test]
fn sudden_changes_are_whole_at_once() {
    let gpu = gpu();
    let mut stage = room();
    let (mut whole, mut part) = (Window::new(&gpu, UpdateRate::Whole), Window::new(&gpu, UpdateRate::Quarter));
    let draw = |stage: &Stage, whole: &mut Window, part: &mut Window| [whole.draw(stage), part.draw(stage)];
    // Light changes slowly.
    for _ in 0..6 {
        draw(&stage, &mut whole, &mut part);
        change_light(&mut stage, |light| light.position.x -= 0.02);
    }
    let changes: [(&str, Change); 4] = [
        ("another colour", |light| light.intensity = Vec3::new(2.0, 0.5, 0.5)),
        ("a jump", |light| light.position = Vec3::new(-1.0, -0.5, 1.2)),
        ("off", |light| light.intensity = Vec3::ZERO),
        ("on", |light| light.intensity = Vec3::splat(3.0)),
    ];
    for (name, change) in changes {
        change_light(&mut stage, change);
        let [(a, _), (b, _)] = draw(&stage, &mut whole, &mut part);
        assert!(a == b, "{name}: the light is {} off", apart(&b, &a));
        change_light(&mut stage, |light| light.position.x += 0.01);
        draw(&stage, &mut whole, &mut part);
    }
    // An object that jumps, and stands.
    move_box(&mut stage, Vec3::new(1.2, 0.0, 0.6));
    for _ in 0..4 {
        draw(&stage, &mut whole, &mut part);
    }
    let [(a, _), (b, _)] = draw(&stage, &mut whole, &mut part);
    let difference = apart(&b, &a);
    assert!(difference < 0.02, "five frames after an object jumped light is {difference} off");
}

#[test]
fn images_by_themselves_have_all_light() {
    let gpu = gpu();
    let stage = room();
    let draw = |update| {
        let settings = RenderSettings { only: Layer::Indirect, display: false, update, ..Default::default() };
        stage.render_with(&gpu, &mut Renderer::new(&gpu), &settings).0
    };
    assert!(draw(UpdateRate::Whole).rgba == draw(UpdateRate::Quarter).rgba);
}
