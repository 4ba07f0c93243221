//! A game's own method of indirect light: registered by its name, drawn, kept and replaced like those of the engine.

mod constant_ambient;
use crate::support::{Stage, gpu};
use constant_ambient::{CONSTANT_AMBIENT, ConstantAmbient};
use glam::{Affine3A, Vec3};
use lightwell::assets::Shape;
use lightwell::graph::PassState;
use lightwell::render::{GiMethod, Layer, MethodInfo, RenderSettings, Renderer};
use std::f32::consts::PI;

fn floor() -> Stage {
    let mut stage = Stage::new(Vec3::new(0.0, 1.0, 0.0), Vec3::ZERO, 8);
    let floor = Shape::Plane { size: [20.0; 2], subdivisions: [1; 2] };
    stage.add(floor, Vec3::new(0.5, 0.25, 0.75), Affine3A::IDENTITY);
    stage
}

fn settings(only: Layer) -> RenderSettings {
    RenderSettings { gi: CONSTANT_AMBIENT, only, ..Default::default() }
}

#[test]
fn a_registered_method_lights_the_scene() {
    let (gpu, stage) = (gpu(), floor());
    let mut renderer = Renderer::new(&gpu);
    renderer.set_audit(true);
    renderer.add_method(&gpu, Box::new(ConstantAmbient { irradiance: Vec3::new(2.0, 2.0, 1.0) }));
    let is_listed = |info: MethodInfo| (info.id, info.title) == (CONSTANT_AMBIENT, "Constant ambient light");
    assert!(renderer.methods().list().any(is_listed));
    for only in [Layer::Total, Layer::Indirect] {
        let (image, _) = stage.render_with(&gpu, &mut renderer, &settings(only));
        for pixel in &image.rgba {
            let expected = Vec3::new(0.5, 0.25, 0.75) / PI * Vec3::new(2.0, 2.0, 1.0);
            assert!(Vec3::from_slice(pixel).abs_diff_eq(expected, 1e-4), "{pixel:?} is not {expected}");
        }
    }
    // Direct light has none of it, and asks for none of its passes.
    let (image, report) = stage.render_with(&gpu, &mut renderer, &settings(Layer::Direct));
    assert!(image.rgba.iter().all(|pixel| pixel[..3] == [0.0; 3]));
    assert!(report.pass("constant ambient").is_none(), "{report}");
}

#[test]
fn it_is_kept_while_nothing_changes_and_replaced_by_its_name() {
    let (gpu, stage) = (gpu(), floor());
    let mut renderer = Renderer::new(&gpu);
    renderer.add_method(&gpu, Box::new(ConstantAmbient { irradiance: Vec3::ONE }));
    let (first, _) = stage.render_with(&gpu, &mut renderer, &settings(Layer::Total));
    let (_, report) = stage.render_with(&gpu, &mut renderer, &settings(Layer::Total));
    assert_eq!(report.ran_count(), 0, "{report}");
    renderer.add_method(&gpu, Box::new(ConstantAmbient { irradiance: 2.0 * Vec3::ONE }));
    let (brighter, report) = stage.render_with(&gpu, &mut renderer, &settings(Layer::Total));
    assert_eq!(report.pass("constant ambient").map(|pass| &pass.state), Some(&PassState::Ran), "{report}");
    assert!((brighter.rgba[0][0] / first.rgba[0][0] - 2.0).abs() < 1e-5);
}

#[test]
fn an_unknown_method_is_an_error_that_names_those_there_are() {
    let (gpu, stage) = (gpu(), floor());
    let settings = RenderSettings { gi: GiMethod::named("radiosity"), ..Default::default() };
    let error = Renderer::new(&gpu).render(&gpu, &stage.scene, &stage.view, &settings).expect_err("no such method");
    let message = error.to_string();
    assert!(message.contains("`radiosity`"), "{message}");
    for known in [GiMethod::NONE, GiMethod::CLPV, GiMethod::VPL, GiMethod::SLC, GiMethod::REFERENCE] {
        assert!(message.contains(known.name()), "{message}");
    }
}
