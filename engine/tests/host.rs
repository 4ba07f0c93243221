//! What frames ask of the device, and what they wait for.

#![allow(clippy::unwrap_used)]

mod support;

use glam::{Affine3A, Vec3};
use lightwell::assets::Shape;
use lightwell::gpu::{Gpu, read_texture};
use lightwell::graph::{FrameReport, Timing};
use lightwell::render::{GiMethod, RenderSettings, Renderer};
use lightwell::scene::{LightShape, ProbePoint};
use lightwell::world::{CellSize, Clpv, Quality};
use std::time::{Duration, Instant};
use support::{Stage, gpu};

/// A lit box on a floor in a light volume, all small.
fn stage() -> Stage {
    let mut stage = Stage::new(Vec3::new(0.0, 2.0, 5.0), Vec3::ZERO, 24);
    stage.add(Shape::Plane { size: [6.0; 2], subdivisions: [1; 2] }, Vec3::splat(0.6), Affine3A::IDENTITY);
    let at = Affine3A::from_translation(Vec3::new(0.5, 0.5, 0.0));
    stage.add(Shape::Box { size: [1.0; 3] }, Vec3::new(0.7, 0.2, 0.1), at);
    stage.light(LightShape::Point, Vec3::splat(5.0), Vec3::new(-1.0, 2.0, 1.0), Vec3::NEG_Y);
    let (cell_size, cells) = (CellSize::Meters(0.5), [12, 8, 12]);
    stage.clpv(Vec3::new(0.0, 1.5, 0.0), Clpv { quality: Quality::Low, cell_size, cells, ..Clpv::default() });
    stage
}

fn draw(gpu: &Gpu, stage: &Stage, renderer: &mut Renderer) -> FrameReport {
    let settings = RenderSettings { gi: GiMethod::Clpv, display: true, no_cache: true, ..RenderSettings::default() };
    renderer.render(gpu, &stage.scene, &stage.view, &settings).unwrap()
}

fn image(gpu: &Gpu, renderer: &Renderer) -> Vec<u8> {
    read_texture(gpu, renderer.radiance().unwrap(), 0, 0).unwrap()
}

#[test]
fn late_times_wait_for_nothing_and_arrive() {
    let (gpu, stage) = (gpu(), stage());
    let mut exact = Renderer::new(&gpu);
    let report = draw(&gpu, &stage, &mut exact);
    assert_eq!(report.host.waits, 1, "exact times are waited for: {}", report.host);
    let timed = |report: &FrameReport| report.passes.iter().filter(|pass| pass.gpu_ms.is_some()).count();
    let expected = timed(&report);
    let mut late = Renderer::new(&gpu);
    late.set_timing(Timing::Late);
    let mut known = 0;
    let begun = Instant::now();
    while known < expected {
        let report = draw(&gpu, &stage, &mut late);
        assert_eq!(report.host.waits, 0, "{}", report.host);
        known = timed(&report);
        assert!(begun.elapsed() < Duration::from_secs(60), "{known} of {expected} times after a minute");
    }
    assert!(image(&gpu, &late) == image(&gpu, &exact), "the same bits");
    late.set_timing(Timing::Off);
    assert_eq!(timed(&draw(&gpu, &stage, &mut late)), 0);
}

#[test]
fn late_probe_light_is_that_of_its_frame() {
    let (gpu, stage) = (gpu(), stage());
    let mut renderer = Renderer::new(&gpu);
    renderer.set_timing(Timing::Late);
    renderer.set_probes(vec![ProbePoint { position: Vec3::new(0.0, 0.4, 1.0), normal: None }]);
    let mut before = renderer.begin_probe_light(&gpu).unwrap();
    assert_eq!(before.try_take(&gpu).unwrap().unwrap(), [Vec3::ZERO], "nothing was drawn yet");
    draw(&gpu, &stage, &mut renderer);
    let waits = gpu.counts().waits;
    let mut pending = renderer.begin_probe_light(&gpu).unwrap();
    // What is asked for later does not change what is on its way.
    renderer.set_probes(Vec::new());
    let begun = Instant::now();
    let late = loop {
        match pending.try_take(&gpu) {
            Some(light) => break light.unwrap(),
            None => assert!(begun.elapsed() < Duration::from_secs(60), "no light after a minute"),
        }
    };
    assert_eq!(gpu.counts().waits, waits, "nothing was waited for");
    renderer.set_probes(vec![ProbePoint { position: Vec3::new(0.0, 0.4, 1.0), normal: None }]);
    draw(&gpu, &stage, &mut renderer);
    assert_eq!(late, renderer.probe_light(&gpu).unwrap());
    assert!(late[0].min_element() > 0.0, "{late:?}");
}
