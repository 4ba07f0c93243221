//! Light on its way in half precision: as near to single precision as is said, at any strength of light.

use crate::support::{Stage, gpu};
use glam::{Affine3A, Vec3};
use lightwell::assets::Shape;
use lightwell::gpu::{Gpu, ImageF32};
use lightwell::graph::FrameReport;
use lightwell::render::{GiMethod, Layer, RenderSettings, Renderer};
use lightwell::scene::LightShape;
use lightwell::world::{Bounces, Clpv, Precision, Quality};

/// The stated bound of what half precision changes, relative to the mean.
const BOUND: f32 = 1e-3;

fn settings(precision: Precision) -> Clpv {
    Clpv { quality: Quality::Low, bounces: Bounces::Converged, precision, ..Default::default() }
}

/// A lamp and a block in a closed room of 4 m.
fn room(settings: Clpv) -> Stage {
    let mut stage = Stage::new(Vec3::new(1.6, 1.0, 1.5), Vec3::new(-1.0, -0.8, -1.2), 48);
    stage.add_room(Vec3::splat(-2.0), Vec3::splat(4.0), Vec3::new(0.8, 0.5, 0.2));
    let block = Affine3A::from_rotation_y(0.4) * Affine3A::from_translation(Vec3::new(-0.6, -1.3, -0.5));
    stage.add(Shape::Box { size: [0.9, 1.4, 0.9] }, Vec3::splat(0.7), block);
    stage.light(LightShape::Point, Vec3::splat(2.0), Vec3::new(0.3, 0.6, -0.2), Vec3::NEG_Y);
    stage.clpv(Vec3::ZERO, settings);
    stage
}

fn indirect(gpu: &Gpu, stage: &Stage) -> (ImageF32, FrameReport) {
    let settings = RenderSettings { gi: GiMethod::CLPV, only: Layer::Indirect, ..Default::default() };
    stage.render_with(gpu, &mut Renderer::new(gpu), &settings)
}

/// Root of the mean square difference, over the mean.
fn difference(found: &ImageF32, expected: &ImageF32) -> f32 {
    let pairs =
        || found.rgba.iter().zip(&expected.rgba).flat_map(|(a, b)| (0..3).map(|channel| (a[channel], b[channel])));
    let count = pairs().count() as f32;
    let mean = pairs().map(|(_, b)| b).sum::<f32>() / count;
    (pairs().map(|(a, b)| (a - b).powi(2)).sum::<f32>() / count).sqrt() / mean
}

/// How much half precision changes of a stage, which is changed by it.
fn change(gpu: &Gpu, mut stage: Stage) -> f32 {
    let mut with = |precision| {
        stage.scene.clpv.as_mut().expect("a volume").settings.precision = precision;
        indirect(gpu, &stage).0
    };
    let [single, half] = [Precision::Single, Precision::Half].map(&mut with);
    assert!(single.rgba.iter().all(|pixel| pixel[0] > 0.0), "there is light everywhere");
    assert_ne!(single, half, "half precision is the same to the bit");
    difference(&half, &single)
}

#[test]
fn half_precision_changes_less_than_a_thousandth_in_one_cascade_and_several() {
    let gpu = gpu();
    for cascades in [1, 2, 3] {
        let found = change(&gpu, room(Clpv { cascades, ..settings(Precision::Half) }));
        assert!(found < BOUND, "{cascades} cascades: {found}");
    }
}

#[test]
fn half_precision_changes_less_than_a_thousandth_of_the_light_of_a_sky() {
    let gpu = gpu();
    let mut stage = Stage::new(Vec3::new(2.0, 1.5, 2.0), Vec3::new(0.0, 0.5, 0.0), 48);
    let slab = |size: [f32; 3]| Shape::Box { size };
    stage.add(slab([6.0, 0.2, 6.0]), Vec3::splat(0.6), Affine3A::from_translation(Vec3::new(0.0, -0.1, 0.0)));
    stage.add(slab([1.0; 3]), Vec3::splat(0.6), Affine3A::from_translation(Vec3::new(0.0, 0.5, 0.0)));
    stage.scene.sky = Vec3::new(0.7, 0.9, 1.3);
    stage.clpv(Vec3::ZERO, Clpv { cascades: 2, ..settings(Precision::Half) });
    let mut with = |precision| {
        stage.scene.clpv.as_mut().expect("a volume").settings.precision = precision;
        indirect(&gpu, &stage).0
    };
    let [single, half] = [Precision::Single, Precision::Half].map(&mut with);
    assert!(single != half && difference(&half, &single) < BOUND, "{}", difference(&half, &single));
}

#[test]
fn the_exposure_follows_the_light_so_that_its_strength_changes_no_bit() {
    let gpu = gpu();
    let mut stage = room(Clpv { cascades: 2, ..settings(Precision::Half) });
    let once = indirect(&gpu, &stage).0;
    // At 2⁻⁴⁰ processors have the same bits still, and the one card that has run this has not.
    for power in [-36, -17, 1, 17, 40] {
        let factor = 2.0_f32.powi(power);
        stage.scene.lights[0].intensity = Vec3::splat(2.0 * factor);
        let scaled = indirect(&gpu, &stage).0;
        let differing = once.rgba.iter().zip(&scaled.rgba).filter(|(a, b)| a[0] * factor != b[0]).count();
        assert_eq!(differing, 0, "pixels that differ at 2^{power}");
    }
}

#[test]
fn a_dim_room_beside_a_bright_one_keeps_its_light() {
    // A lamp ten thousand times as bright shines in the room next door, and sets the exposure.
    let gpu = gpu();
    let mut stage = room(settings(Precision::Half));
    stage.add_room(Vec3::new(3.0, -2.0, -2.0), Vec3::splat(4.0), Vec3::splat(0.5));
    stage.light(LightShape::Point, Vec3::splat(2e4), Vec3::new(5.0, 0.0, 0.0), Vec3::NEG_Y);
    let found = change(&gpu, stage);
    assert!(found < BOUND, "{found}");
}

#[test]
fn light_on_its_way_takes_half_the_memory() {
    let gpu = gpu();
    let bytes = |precision| {
        let (_, report) = indirect(&gpu, &room(Clpv { cascades: 2, ..settings(precision) }));
        let of_light = report.resources.iter().filter(|r| r.name.contains("fronts") || r.name.contains("shell"));
        of_light.map(|resource| resource.bytes).sum::<u64>()
    };
    let [single, half] = [Precision::Single, Precision::Half].map(bytes);
    assert!(single > 0 && single == 2 * half, "{single} and {half} bytes");
}
