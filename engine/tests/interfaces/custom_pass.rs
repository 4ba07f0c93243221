//! The pass that `docs/frame.md` adds: it runs, and the page shows it as it is.

#![allow(clippy::unwrap_used)]

mod dusk;
use crate::support::{Stage, gpu};
use glam::{Affine3A, Vec3};
use lightwell::assets::Shape;
use lightwell::gpu::{read_texture, read_texture_f32};
use lightwell::graph::PassState;
use lightwell::render::{GiMethod, RenderSettings, Renderer};
use lightwell::scene::LightShape;

const SHADER: &str = include_str!("custom_pass/dusk.wgsl");

#[test]
fn the_page_shows_the_pass_as_it_is() {
    let page = include_str!("../../../docs/frame.md");
    assert!(page.contains(include_str!("custom_pass/dusk.rs").trim()), "docs/frame.md shows another dusk.rs");
    assert!(page.contains(SHADER.trim()), "docs/frame.md shows another dusk.wgsl");
}

/// A red floor far from its lamp turns blue on the screen; what is measured stays red, and nothing runs twice.
#[test]
fn the_pass_runs_before_the_tone_map() {
    let gpu = gpu();
    let mut stage = Stage::new(Vec3::new(0.0, 3.0, 0.0), Vec3::ZERO, 16);
    stage.add(Shape::Plane { size: [20.0; 2], subdivisions: [1; 2] }, Vec3::new(0.5, 0.05, 0.02), Affine3A::IDENTITY);
    stage.light(LightShape::Point, Vec3::splat(0.02), Vec3::new(0.0, 2.0, 0.0), Vec3::NEG_Y);
    let settings = RenderSettings { gi: GiMethod::NONE, display: true, exposure: 8.0, ..RenderSettings::default() };
    let mut renderer = Renderer::new(&gpu);
    let shown = |renderer: &mut Renderer| {
        let report = renderer.render(&gpu, &stage.scene, &stage.view, &settings).unwrap();
        let display = read_texture(&gpu, renderer.display().unwrap(), 0, 0).unwrap();
        let radiance = read_texture_f32(&gpu, renderer.radiance().unwrap()).unwrap();
        (report, [display[0], display[1], display[2]], radiance.rgba)
    };
    let (_, day, measured) = shown(&mut renderer);
    assert!(day[0] > day[2], "{day:?}");
    gpu.shaders.add("dusk.wgsl", SHADER);
    renderer.add_pass(dusk::declare);
    let (report, night, still) = shown(&mut renderer);
    assert!(night[2] > night[0], "{night:?}");
    assert_eq!(measured, still, "what is measured is the scene's light");
    let state =
        |report: &lightwell::graph::FrameReport| report.passes.iter().find(|p| p.name == "dusk").unwrap().state.clone();
    assert_eq!(state(&report), PassState::Ran);
    let (again, ..) = shown(&mut renderer);
    assert!(matches!(state(&again), PassState::Cached), "{again}");
}

/// A shader that is not there, or does not compile, is an error that names it.
#[test]
fn a_broken_shader_is_told() {
    let gpu = gpu();
    let stage = Stage::new(Vec3::new(0.0, 3.0, 0.0), Vec3::ZERO, 8);
    let settings = RenderSettings { gi: GiMethod::NONE, display: true, ..RenderSettings::default() };
    let mut renderer = Renderer::new(&gpu);
    renderer.add_pass(dusk::declare);
    let missing = renderer.render(&gpu, &stage.scene, &stage.view, &settings).unwrap_err().to_string();
    assert!(missing.contains("dusk.wgsl"), "{missing}");
    gpu.shaders.add("dusk.wgsl", &SHADER.replace("luminance *", "luminence *"));
    let broken = renderer.render(&gpu, &stage.scene, &stage.view, &settings).unwrap_err().to_string();
    assert!(broken.contains("dusk.wgsl:13") && broken.contains("luminence"), "{broken}");
    gpu.shaders.add("dusk.wgsl", SHADER);
    renderer.render(&gpu, &stage.scene, &stage.view, &settings).unwrap();
}
