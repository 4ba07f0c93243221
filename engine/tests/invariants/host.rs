//! Requests of frames to the device, and their waits.

#![allow(clippy::unwrap_used)]

use crate::support::{Stage, gpu};
use glam::{Affine3A, Vec3};
use lightwell::assets::Shape;
use lightwell::gpu::{Gpu, read_texture};
use lightwell::graph::{FrameReport, Timing};
use lightwell::render::{GiMethod, RenderSettings, Renderer};
use lightwell::scene::{LightShape, ProbePoint};
use lightwell::world::{CellSize, Clpv, GatherRays, Quality};
use std::time::{Duration, Instant};

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
    let settings = RenderSettings { gi: GiMethod::CLPV, display: true, no_cache: true, ..RenderSettings::default() };
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

/// Every pass runs in both frames, and the second finds all that it binds.
#[test]
fn a_frame_like_the_one_before_makes_and_uploads_nothing() {
    let (gpu, stage) = (gpu(), stage());
    let mut renderer = Renderer::new(&gpu);
    renderer.set_timing(Timing::Late);
    let mut before = Vec::new();
    for _ in 0..2 {
        draw(&gpu, &stage, &mut renderer);
        // A busy machine may be through with neither of them by itself, and each has times on their way.
        before = image(&gpu, &renderer);
    }
    let report = draw(&gpu, &stage, &mut renderer);
    let host = report.host;
    assert!(host.dispatches > 20, "the frame does something: {host}");
    assert_eq!((host.bind_groups, host.buffers, host.uploaded, host.waits), (0, 0, 0, 0), "{host}");
    assert!(host.compute_passes < host.dispatches / 2, "dispatches share passes: {host}");
    assert!(image(&gpu, &renderer) == before, "the same bits");
}

/// A value that changes is another buffer, whatever the label; one that comes back is the same.
#[test]
fn uniforms_are_kept_by_their_values() {
    let gpu = gpu();
    let [one, other] = [1.0_f32, 2.0].map(|value| gpu.uniform("value", &value));
    assert_ne!(one, other);
    let uploaded = gpu.counts().uploaded;
    assert_eq!(gpu.uniform("another name", &1.0_f32), one);
    assert_eq!(gpu.counts().uploaded, uploaded);
    let constants = |values: &[u32]| gpu.constants("values", values);
    assert_eq!(constants(&[1, 2]), constants(&[1, 2]));
    assert_ne!(constants(&[1, 2]), constants(&[2, 1]));
}

/// Software drivers get the gather in pieces, a graphics card in one: the image is the same.
#[test]
fn pieces_of_work_change_no_bit() {
    let (mut software, mut hardware) = (gpu(), gpu());
    // What follows from the kind of the adapter follows from what it says of itself.
    software.info.device_type = wgpu::DeviceType::Cpu;
    hardware.info.device_type = wgpu::DeviceType::DiscreteGpu;
    let mut stage = stage();
    stage.view.size = [256, 256];
    // Rays gather the light then.
    stage.scene.clpv.as_mut().unwrap().settings.gather_rays = GatherRays::Count(5);
    let [mut pieces, mut whole] = [&software, &hardware].map(Renderer::new);
    let in_pieces = draw(&software, &stage, &mut pieces);
    let in_one = draw(&hardware, &stage, &mut whole);
    let dispatches = |report: &FrameReport| report.pass("gather").unwrap().counts.dispatches;
    assert!(dispatches(&in_pieces) > 1, "{}", in_pieces);
    assert_eq!(dispatches(&in_one), 1, "{}", in_one);
    assert!(in_one.submits < in_pieces.submits && in_one.submits <= 4, "{} and {}", in_one.submits, in_pieces.submits);
    assert!(image(&hardware, &whole) == image(&software, &pieces));
}

/// The file is written when the device is let go, taken up by the next, and passed over if it is not whole.
#[test]
fn pipelines_are_kept_on_disk() {
    let folder = tempfile::tempdir().unwrap();
    let run = || {
        let gpu = gpu();
        gpu.keep_pipelines(folder.path());
        let mut renderer = Renderer::new(&gpu);
        draw(&gpu, &stage(), &mut renderer);
        let can = gpu.features.contains(wgpu::Features::PIPELINE_CACHE);
        (image(&gpu, &renderer), can && gpu.info.backend == wgpu::Backend::Vulkan)
    };
    let files = || -> Vec<_> { std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().path()).collect() };
    let (first, can) = run();
    assert_eq!(files().len(), usize::from(can));
    assert!(run().0 == first);
    for path in files() {
        let whole = std::fs::read(&path).unwrap();
        assert!(whole.starts_with(b"lwpipe"));
        for broken in [&whole[..whole.len() / 2], b"something else", b""] {
            std::fs::write(&path, broken).unwrap();
            assert!(run().0 == first);
            let anew = std::fs::read(&path).unwrap();
            assert!(anew.starts_with(b"lwpipe") && anew != broken, "it is rewritten");
        }
    }
}
