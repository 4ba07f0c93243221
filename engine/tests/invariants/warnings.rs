//! Warnings: what a scene asks for and a frame does not show, with the name of its entity.

use crate::support::{Stage, gpu};
use glam::{Affine3A, Vec3};
use lightwell::assets::{Material, Shape};
use lightwell::render::{GiMethod, RenderSettings, Renderer};
use lightwell::scene::LightShape;
use lightwell::world::{
    CellSize, Clpv, ClpvPlacement, GatherRays, InstantRadiosity, Quality, Transport, VirtualPlacement, VirtualShading,
};

fn stage() -> Stage {
    let mut stage = Stage::new(Vec3::new(0.0, 1.0, 2.0), Vec3::ZERO, 16);
    stage.add(Shape::Plane { size: [4.0; 2], subdivisions: [1; 2] }, Vec3::splat(0.5), Affine3A::IDENTITY);
    let mut glow = Material::diffuse("glow", Vec3::splat(0.5));
    glow.emissive = Vec3::ONE;
    stage.add_material(Shape::Box { size: [0.2; 3] }, glow, Affine3A::from_translation(Vec3::Y));
    stage.light(LightShape::Point, Vec3::ONE, Vec3::new(0.5, 1.5, 0.0), Vec3::NEG_Y);
    stage.scene.sky = Vec3::splat(0.1);
    stage.scene.settings_names.clpv = "Light volume".into();
    stage.scene.settings_names.vpl = "Virtual lights".into();
    stage
}

fn warnings(stage: &Stage, renderer: &mut Renderer, gpu: &lightwell::gpu::Gpu, gi: GiMethod) -> Vec<String> {
    let (_, report) = stage.render_with(gpu, renderer, &RenderSettings { gi, ..Default::default() });
    let text = report.to_string();
    assert!(report.warnings.iter().all(|warning| text.contains(&format!("warning: {warning}"))), "{text}");
    report.warnings
}

#[test]
fn of_cascades_that_rays_do_not_look_at() {
    let (gpu, mut stage) = (gpu(), stage());
    let mut renderer = Renderer::new(&gpu);
    let mut told = |settings: Clpv| {
        stage.clpv(Vec3::ZERO, settings);
        warnings(&stage, &mut renderer, &gpu, GiMethod::CLPV)
    };
    let medium = Clpv { quality: Quality::Medium, ..Clpv::default() };
    assert_eq!(told(Clpv { cascades: 1, ..medium.clone() }), Vec::<String>::new());
    assert_eq!(told(Clpv { cascades: 3, gather_rays: GatherRays::Count(0), ..medium.clone() }), Vec::<String>::new());
    let lost = told(Clpv { cascades: 3, ..medium.clone() });
    assert_eq!(lost.len(), 1, "{lost:?}");
    for part in ["`Light volume`", "`cascades` is 3", "2 finer"] {
        assert!(lost[0].contains(part), "{part} in {lost:?}");
    }
    let fixed = Clpv {
        cascades: 2,
        cell_size: CellSize::Meters(0.25),
        placement: ClpvPlacement::Camera { ahead: 0.5 },
        ..medium
    };
    assert!(told(fixed)[0].contains("the coarsest"));
}

#[test]
fn of_what_virtual_lights_leave_out() {
    let (gpu, mut stage) = (gpu(), stage());
    let mut renderer = Renderer::new(&gpu);
    let mut told = |settings: InstantRadiosity| {
        stage.scene.vpl = Some(InstantRadiosity { particles: 8, ..settings });
        warnings(&stage, &mut renderer, &gpu, GiMethod::VPL)
    };
    assert_eq!(told(InstantRadiosity::default()), Vec::<String>::new());
    let lost = told(InstantRadiosity { placement: VirtualPlacement::Rsm, ..Default::default() });
    assert!(lost.len() == 1 && lost[0].contains("`Virtual lights`") && lost[0].contains("`glow`"), "{lost:?}");
    let lost = told(InstantRadiosity { shading: VirtualShading::AsPublished, ..Default::default() });
    assert!(lost.len() == 2 && lost[0].contains("sky") && lost[1].contains("`glow`"), "{lost:?}");
}

/// The diffusion takes what emits, light culling does not.
#[test]
fn of_surfaces_that_emit() {
    let (gpu, mut stage) = (gpu(), stage());
    let mut renderer = Renderer::new(&gpu);
    let lost = warnings(&stage, &mut renderer, &gpu, GiMethod::SLC);
    assert!(lost.len() == 1 && lost[0].contains("`glow`") && lost[0].contains("light nothing"), "{lost:?}");
    stage.clpv(Vec3::ZERO, Clpv { transport: Transport::Diffusion, ..Default::default() });
    assert_eq!(warnings(&stage, &mut renderer, &gpu, GiMethod::CLPV), Vec::<String>::new());
}

/// Those of the scene come first, whatever draws it.
#[test]
fn of_the_scene_itself() {
    let (gpu, mut stage) = (gpu(), stage());
    stage.scene.warnings = vec!["`Lamp`: is a light that gives none".into()];
    for gi in [GiMethod::NONE, GiMethod::REFERENCE] {
        let told = warnings(&stage, &mut Renderer::new(&gpu), &gpu, gi);
        assert_eq!(told, stage.scene.warnings, "{gi:?}");
    }
}
