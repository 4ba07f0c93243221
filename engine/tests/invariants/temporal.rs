//! Frames of a window: light that changes is followed at once although many frames are averaged, objects take theirs along and
//! leave no ghosts, few rays are cast, and edges become smooth.

use crate::support::{Stage, error, gpu, left_of};
use glam::{Affine3A, Quat, Vec3};
use lightwell::assets::Shape;
use lightwell::gpu::{Gpu, ImageF32, read_texture_f32};
use lightwell::graph::FrameReport;
use lightwell::measure::Image;
use lightwell::render::reference::{PathTracer, TraceSettings};
use lightwell::render::{Layer, RenderSettings, Renderer};
use lightwell::scene::LightShape;
use lightwell::world::{Clpv, Quality};

const EDGE: u32 = 64;

fn settings() -> RenderSettings {
    RenderSettings { only: Layer::Indirect, display: false, average: true, ..Default::default() }
}

fn draw(gpu: &Gpu, renderer: &mut Renderer, stage: &Stage, frames: u32) -> (ImageF32, FrameReport) {
    let mut drawn = stage.render_with(gpu, renderer, &settings());
    for _ in 1..frames {
        drawn = stage.render_with(gpu, renderer, &settings());
    }
    drawn
}

fn traced(gpu: &Gpu, stage: &Stage) -> Image {
    let mut tracer = PathTracer::new(gpu);
    tracer.begin(gpu, &stage.scene, &stage.view, &TraceSettings { bounces: None, seed: 3 }).expect("a scene");
    tracer.advance(gpu, 400).expect("a device");
    tracer.estimate(gpu).expect("an image").indirect()
}

/// A closed room of 4 m with a box in it that may move.
fn room(box_at: Affine3A) -> Stage {
    let mut stage = Stage::new(Vec3::new(1.6, 0.6, 1.7), Vec3::new(-1.0, -1.0, -1.2), EDGE);
    stage.add_room(Vec3::splat(-2.0), Vec3::splat(4.0), Vec3::new(0.7, 0.55, 0.4));
    stage.add(Shape::Box { size: [0.8, 1.2, 0.8] }, Vec3::new(0.8, 0.2, 0.2), box_at);
    stage.scene.primitives.last_mut().expect("the box").moving = true;
    stage.light(LightShape::Point, Vec3::splat(2.0), Vec3::new(0.3, 1.2, -0.2), Vec3::NEG_Y);
    stage.clpv(Vec3::ZERO, Clpv { quality: Quality::Medium, ..Default::default() });
    stage
}

const STANDING: Vec3 = Vec3::new(-0.5, -1.4, -0.4);

fn move_box(stage: &mut Stage, place: Affine3A) {
    let revision = stage.scene.revisions.geometry + 1;
    stage.scene.revisions.geometry = revision;
    let moved = stage.scene.primitives.last_mut().expect("the box");
    moved.world_from_object = place;
    moved.bounds = moved.mesh.bounds.transformed(&place);
    moved.geometry_revision = revision;
}

#[test]
fn a_lamp_that_is_switched_off_is_gone_after_three_frames() {
    let gpu = gpu();
    let mut stage = room(Affine3A::from_translation(STANDING));
    stage.light(LightShape::Point, Vec3::new(6.0, 3.0, 2.0), Vec3::new(-1.5, 0.2, 1.4), Vec3::NEG_Y);
    let before = traced(&gpu, &stage);
    let mut renderer = Renderer::new(&gpu);
    draw(&gpu, &mut renderer, &stage, 24);
    stage.scene.lights.pop();
    stage.scene.revisions.lights += 1;
    let after = traced(&gpu, &stage);
    let (third, _) = draw(&gpu, &mut renderer, &stage, 3);
    let left = left_of(&before, &after, &third);
    assert!(left.abs() < 0.05, "after three frames {left} of the light is left");
    let ((found, bias), (fresh, _)) =
        (error(&third, &after), error(&draw(&gpu, &mut Renderer::new(&gpu), &stage, 1).0, &after));
    assert!(found < 1.5 * fresh && bias.abs() < 0.05, "error {found} against {fresh} of a first frame, bias {bias}");
}

#[test]
fn what_an_object_hid_and_lit_is_right_three_frames_after_it_left() {
    let gpu = gpu();
    let mut stage = room(Affine3A::from_translation(STANDING));
    let before = traced(&gpu, &stage);
    let mut renderer = Renderer::new(&gpu);
    draw(&gpu, &mut renderer, &stage, 24);
    move_box(&mut stage, Affine3A::from_translation(Vec3::new(1.4, -1.4, -1.5)));
    let after = traced(&gpu, &stage);
    let (third, _) = draw(&gpu, &mut renderer, &stage, 3);
    let left = left_of(&before, &after, &third);
    assert!(left.abs() < 0.1, "after three frames {left} of what was there is left");
}

/// While a box moves and a lamp swings, an image has no more error than one frame has by itself, although each pixel has
/// hardly more than a ray; and so have the surfaces that the box has just left, and its own.
#[test]
fn what_moves_takes_its_light_along_and_leaves_no_ghost() {
    let gpu = gpu();
    let place = |frame: u32| {
        let t = frame as f32 / 60.0;
        let at = STANDING + Vec3::new(1.6 * t, 0.0, 0.9 * t);
        Affine3A::from_rotation_translation(Quat::from_rotation_y(1.5 * t), at)
    };
    let mut stage = room(place(0));
    let mut renderer = Renderer::new(&gpu);
    let mut last = None;
    for frame in 0..24 {
        move_box(&mut stage, place(frame));
        stage.scene.lights[0].position.x = 0.3 + 0.02 * frame as f32;
        stage.scene.lights[0].revision += 1;
        stage.scene.revisions.lights += 1;
        last = Some(draw(&gpu, &mut renderer, &stage, 1));
    }
    let (found, report) = last.expect("a frame");
    let truth = traced(&gpu, &stage);
    let alone = RenderSettings { average: false, ..settings() };
    let (alone, plain) = stage.render_with(&gpu, &mut Renderer::new(&gpu), &alone);
    let ((moving, bias), (single, _)) = (error(&found, &truth), error(&alone, &truth));
    assert!(moving < 1.2 * single && bias.abs() < 0.03, "error {moving} against {single} of a frame, bias {bias}");
    let rays =
        |report: &FrameReport| report.pass("gather").expect("a pass").counts.rays as f64 / f64::from(EDGE * EDGE);
    assert!(rays(&report) <= 1.5 && rays(&plain) > 6.0, "{} and {} rays a pixel", rays(&report), rays(&plain));
}

/// What is shown, at rest and while something passes, against the mean of single frames whose pixel grids are shifted.
#[test]
fn edges_are_smooth_at_rest_and_while_an_object_passes() {
    let gpu = gpu();
    let display = RenderSettings { only: Layer::Total, display: true, mlaa: true, ..settings() };
    let shown = |renderer: &Renderer| {
        read_texture_f32(&gpu, renderer.target("smooth radiance").expect("an image")).expect("readable")
    };
    let mut stage = room(Affine3A::from_translation(STANDING));
    let mut renderer = Renderer::new(&gpu);
    let mut report = FrameReport::default();
    while report == FrameReport::default() || renderer.is_settling() {
        report = renderer.render(&gpu, &stage.scene, &stage.view, &display).expect("a frame");
    }
    assert!(!report.ran("mlaa") && !report.ran("temporal anti-aliasing"), "{report}");
    let (truth, jagged) = supersampled(&gpu, &mut stage);
    let (smooth, _) = error(&shown(&renderer), &truth);
    assert!(smooth < 0.35 * jagged, "{smooth} from the truth at rest, {jagged} without smooth edges");
    for frame in 1..=12 {
        move_box(&mut stage, Affine3A::from_translation(STANDING + 0.01 * frame as f32 * Vec3::X));
        report = renderer.render(&gpu, &stage.scene, &stage.view, &display).expect("a frame");
    }
    assert!(report.ran("temporal anti-aliasing"), "{report}");
    let (truth, jagged) = supersampled(&gpu, &mut stage);
    let (smooth, _) = error(&shown(&renderer), &truth);
    assert!(smooth < 0.8 * jagged, "{smooth} from the truth while a box moves, {jagged} without smooth edges");
}

/// The mean of frames with shifted pixel grids, and the error of one without.
fn supersampled(gpu: &Gpu, stage: &mut Stage) -> (Image, f64) {
    let mut renderer = Renderer::new(gpu);
    let alone = RenderSettings { only: Layer::Total, average: false, images: 64, ..settings() };
    let mut sums = vec![[0.0; 3]; (EDGE * EDGE) as usize];
    for index in 0..64 {
        stage.view.jitter = [(index % 8) as f32 / 8.0 - 0.4375, (index / 8) as f32 / 8.0 - 0.4375];
        let (image, _) = stage.render_with(gpu, &mut renderer, &alone);
        for (sum, pixel) in sums.iter_mut().zip(&image.rgba) {
            *sum = [0, 1, 2].map(|c| sum[c] + pixel[c] / 64.0);
        }
    }
    stage.view.jitter = [0.0; 2];
    let truth = Image::from_pixels(EDGE, EDGE, sums).expect("an image");
    let (image, _) = stage.render_with(gpu, &mut renderer, &alone);
    let (jagged, _) = error(&image, &truth);
    (truth, jagged)
}
