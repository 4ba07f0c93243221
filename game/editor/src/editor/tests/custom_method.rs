//! The settings of a game's method of indirect light in the inspector, and in the image.

#[path = "../../../../examples/custom_method/method.rs"]
mod method;

use super::*;
use crate::editor::custom_component::CustomComponent;
use lightwell::gpu::{Gpu, GpuOptions, read_texture_f32};
use lightwell::render::{Layer, RenderSettings, Renderer};
use lightwell::scene::SceneView;
use method::{Hemisphere, HemisphereLight};

/// The editor with the example's scene, a part of which is selected.
fn bench() -> Bench {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/custom_method/yard.scene.ron");
    let mut options = LoadOptions::default();
    options.types.add_method(Hemisphere::ID);
    options.types.add_settings::<HemisphereLight>().unwrap();
    let mut desk = Desk::with_options(&path, options);
    desk.methods.push(MethodInfo::of(&Hemisphere));
    desk.editor.set_own(vec![CustomComponent::of::<HemisphereLight>()]);
    desk.select("Ambient");
    let builder =
        Harness::builder().with_size([1400.0, 900.0]).with_max_steps(12).with_context_setup(crate::editor::set_fonts);
    let mut harness = builder.build_ui_state(|ui, desk: &mut Desk| desk.show(ui), desk);
    harness.run_steps(3);
    harness
}

/// Mean indirect radiance of the scene as the editor shows it [W/(m² sr)].
fn indirect(gpu: &Gpu, renderer: &mut Renderer, scene: &Scene) -> f64 {
    let view = SceneView { camera: scene.cameras[0].clone(), size: [32, 20], jitter: [0.0; 2] };
    let settings = RenderSettings { gi: Hemisphere::ID, only: Layer::Indirect, display: false, ..Default::default() };
    renderer.render(gpu, scene, &view, &settings).unwrap();
    let image = read_texture_f32(gpu, renderer.radiance().unwrap()).unwrap();
    image.rgba.iter().map(|pixel| f64::from(pixel[0])).sum::<f64>() / (32.0 * 20.0)
}

#[test]
fn its_settings_are_edited_and_change_the_image() {
    let gpu = Gpu::headless(&GpuOptions::default()).unwrap();
    let mut renderer = Renderer::new(&gpu);
    renderer.add_method(&gpu, Box::new(Hemisphere));
    let mut bench = bench();
    let before = indirect(&gpu, &mut renderer, &bench.state().scene);
    let at = place_of(&bench, "Sky");
    drag(&mut bench, at, at + egui::vec2(60.0, 0.0));
    let sky = bench.state().scene.method_settings.get::<HemisphereLight>().unwrap().sky;
    assert!(sky > 1.6 && sky <= 100.0, "{sky}");
    let after = indirect(&gpu, &mut renderer, &bench.state().scene);
    assert!(before > 0.0 && after > 1.02 * before, "{before} to {after} W/(m² sr)");
    let note = bench.state().editor.kit.note("HemisphereLight.sky");
    assert_eq!((note.unit, note.range), (Some("W/m²"), Some(0.0..=100.0)));
}

#[test]
fn it_is_listed_by_its_title() {
    let mut bench = bench();
    open(&mut bench, Pane::Display);
    click(&mut bench, "Indirect light");
    for title in ["Light propagation volumes", "Instant radiosity", "Stochastic light culling", "Path tracer"] {
        assert!(bench.query_all_by_label(title).next().is_some(), "{title}");
    }
    click(&mut bench, "Hemisphere light");
    assert_eq!(bench.state().look.gi, Some(Hemisphere::ID));
}
