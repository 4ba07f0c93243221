//! The static layer cache: its costs, and that it changes no bit.

use crate::support::{Stage, gpu};
use glam::{Affine3A, Quat, Vec3};
use lightwell::assets::{Material, Shape};
use lightwell::gpu::Gpu;
use lightwell::graph::{FrameReport, PassState};
use lightwell::render::{GiMethod, RenderSettings, Renderer};
use lightwell::scene::{LightShape, SceneId};
use lightwell::world::{CellSize, Clpv, Transport};
use std::sync::Arc;

/// Boxes on a floor.
const BOXES: u64 = 1_200;
/// The one that moves.
const MOVER: SceneId = SceneId(5_000);

/// 1,200 boxes on a floor under a sun and a spot light, and a cube above them that moves. All that does not move is of
/// two meshes.
fn field() -> Stage {
    let mut stage = Stage::new(Vec3::new(0.0, 9.0, 12.0), Vec3::ZERO, 64);
    stage.add(Shape::Plane { size: [30.0, 30.0], subdivisions: [1, 1] }, Vec3::splat(0.5), Affine3A::IDENTITY);
    stage.add(Shape::Box { size: [0.3; 3] }, Vec3::new(0.7, 0.3, 0.2), Affine3A::IDENTITY);
    let model = stage.scene.primitives.pop().expect("just added");
    for index in 0..BOXES {
        let mut primitive = model.clone();
        primitive.id = SceneId(100 + index);
        let at = Vec3::new((index % 40) as f32 - 20.0, 0.3, (index / 40) as f32 - 15.0) * Vec3::new(0.6, 0.5, 0.6);
        primitive.world_from_object = Affine3A::from_translation(at);
        stage.scene.primitives.push(primitive);
    }
    let mut mover = model;
    (mover.id, mover.moving) = (MOVER, true);
    mover.material = Arc::new(Material::diffuse("paint", Vec3::new(0.1, 0.2, 0.8)));
    stage.scene.primitives.push(mover);
    stage.scene.primitives.iter_mut().for_each(|p| p.bounds = p.mesh.bounds.transformed(&p.world_from_object));
    stage.scene.revisions.statics = 1;
    let down = Vec3::new(0.2, -1.0, -0.3);
    let sun = stage.light(LightShape::Directional, Vec3::splat(3.0), Vec3::ZERO, down);
    (sun.id, sun.name) = (SceneId(9_001), "sun".into());
    let cone = LightShape::Spot { inner: 0.3, outer: 0.4 };
    let lamp = stage.light(cone, Vec3::splat(40.0), Vec3::new(-8.0, 6.0, -4.0), Vec3::NEG_Y);
    (lamp.id, lamp.name) = (SceneId(9_002), "lamp".into());
    put(&mut stage, Vec3::new(1.0, 2.0, 1.0), 0.3);
    stage
}

/// Moves the cube.
fn put(stage: &mut Stage, at: Vec3, turn: f32) {
    let scene = &mut stage.scene;
    scene.revisions.geometry += 1;
    let mover = scene.primitives.iter_mut().find(|p| p.id == MOVER).expect("there");
    mover.world_from_object = Affine3A::from_rotation_translation(Quat::from_rotation_y(turn), at);
    mover.bounds = mover.mesh.bounds.transformed(&mover.world_from_object);
    mover.geometry_revision = scene.revisions.geometry;
}

fn settings(no_cache: bool) -> RenderSettings {
    RenderSettings { gi: GiMethod::NONE, no_cache, ..Default::default() }
}

fn state<'r>(report: &'r FrameReport, pass: &str) -> &'r PassState {
    &report.pass(pass).unwrap_or_else(|| panic!("no pass `{pass}` in\n{report}")).state
}

/// Bits of an image that was drawn from nothing.
fn afresh(gpu: &Gpu, stage: &Stage) -> Vec<[u32; 4]> {
    bits(&stage.render_with(gpu, &mut Renderer::new(gpu), &settings(true)).0.rgba)
}

fn bits(pixels: &[[f32; 4]]) -> Vec<[u32; 4]> {
    pixels.iter().map(|pixel| pixel.map(f32::to_bits)).collect()
}

#[test]
fn one_moving_cube_among_1200_costs_itself() {
    let (gpu, mut stage) = (gpu(), field());
    let mut renderer = Renderer::new(&gpu);
    let (_, first) = stage.render_with(&gpu, &mut renderer, &settings(false));
    assert!(first.pass("gbuffer, still").is_none() && first.pass("shadow sun#9001, still").is_none(), "{first}");
    for step in 0..4 {
        put(&mut stage, Vec3::new(1.0, 2.0, 1.0 + 0.1 * step as f32), 0.1 * step as f32);
        let (image, report) = stage.render_with(&gpu, &mut renderer, &settings(false));
        let expected = if step == 0 { PassState::Ran } else { PassState::Cached };
        for pass in ["gbuffer", "shadow sun#9001"] {
            assert_eq!(*state(&report, &format!("{pass}, still")), expected, "step {step}:\n{report}");
            let drawn = report.pass(pass).expect("asserted above").counts;
            assert_eq!((drawn.draws, drawn.triangles), (1, 12), "step {step}:\n{report}");
        }
        // It moves where the lamp does not shine.
        assert_eq!(*state(&report, "shadow lamp#9002"), PassState::Cached, "step {step}:\n{report}");
        assert!(report.pass("shadow lamp#9002, still").is_none(), "step {step}:\n{report}");
        assert!(bits(&image.rgba) == afresh(&gpu, &stage), "step {step}: other bits than without reuse");
    }
    let (_, rest) = stage.render_with(&gpu, &mut renderer, &settings(false));
    assert_eq!(rest.ran_count(), 0, "{rest}");
}

#[test]
fn reflective_shadow_maps_and_blockers_pay_for_what_moves() {
    let (gpu, mut stage) = (gpu(), field());
    let cells = Clpv {
        transport: Transport::Diffusion,
        cells: [16, 8, 16],
        cell_size: CellSize::Meters(2.0),
        steps: 4,
        ..Default::default()
    };
    stage.clpv(Vec3::new(0.0, 2.0, 0.0), cells);
    let mut renderer = Renderer::new(&gpu);
    let settings = RenderSettings { gi: GiMethod::CLPV, ..settings(false) };
    for step in 0..3 {
        put(&mut stage, Vec3::new(1.0, 2.0, 1.0 + 0.1 * step as f32), 0.0);
        let (image, report) = stage.render_with(&gpu, &mut renderer, &settings);
        if step == 2 {
            assert_eq!(*state(&report, "rsm sun#9001, still"), PassState::Cached, "{report}");
            assert_eq!(report.pass("rsm sun#9001").expect("asserted above").counts.triangles, 12, "{report}");
            assert_eq!(*state(&report, "rsm lamp#9002"), PassState::Cached, "{report}");
            let afresh = RenderSettings { no_cache: true, ..settings.clone() };
            let other = stage.render_with(&gpu, &mut Renderer::new(&gpu), &afresh).0;
            assert!(bits(&image.rgba) == bits(&other.rgba), "other bits than without reuse");
        }
    }
}

/// Of surfaces at the same depth that was drawn first which does not move, whatever their identities.
#[test]
fn coinciding_surfaces_are_the_same_with_and_without_reuse() {
    let (gpu, mut stage) = (gpu(), field());
    let mut renderer = Renderer::new(&gpu);
    let twin = stage.scene.primitives[600].world_from_object.translation;
    stage.scene.primitives.iter_mut().find(|p| p.id == MOVER).expect("there").id = SceneId(50);
    stage.scene.primitives.sort_by_key(|p| p.id);
    for step in 0..3 {
        let mover = &mut stage.scene.primitives.iter_mut().find(|p| p.id == SceneId(50)).expect("there");
        let height = if step == 1 { 0.5 } else { 0.0 };
        mover.world_from_object = Affine3A::from_translation(Vec3::from(twin) + Vec3::Y * height);
        mover.bounds = mover.mesh.bounds.transformed(&mover.world_from_object);
        stage.scene.revisions.geometry += 1;
        mover.geometry_revision = stage.scene.revisions.geometry;
        let image = stage.render_with(&gpu, &mut renderer, &settings(false)).0;
        assert!(bits(&image.rgba) == afresh(&gpu, &stage), "step {step}: other bits than without reuse");
    }
}

#[test]
fn a_camera_that_moves_keeps_no_second_image() {
    let (gpu, mut stage) = (gpu(), field());
    let mut renderer = Renderer::new(&gpu);
    for step in 0..4 {
        put(&mut stage, Vec3::new(1.0, 2.0, 1.0 + 0.1 * step as f32), 0.0);
        stage.view.camera.world_from_view.translation.x += 0.1;
        let (image, report) = stage.render_with(&gpu, &mut renderer, &settings(false));
        assert!(report.pass("gbuffer, still").is_none(), "{report}");
        assert!(bits(&image.rgba) == afresh(&gpu, &stage), "step {step}: other bits than without reuse");
    }
}

/// Twenty frames of changes of all kinds: moves, new surfaces, mirroring, things that begin to move, come and go.
#[test]
fn whatever_changes_the_bits_are_those_without_reuse() {
    let (gpu, mut stage) = (gpu(), field());
    let mut renderer = Renderer::new(&gpu);
    for step in 0..20_u64 {
        let at = Vec3::new((step % 7) as f32 - 3.0, 1.0 + (step % 3) as f32, (step % 5) as f32 - 2.0);
        put(&mut stage, at, step as f32);
        let scene = &mut stage.scene;
        let mover = scene.primitives.len() - 1;
        match step % 6 {
            1 => {
                scene.revisions.materials += 1;
                let color = Vec3::new(0.9, 0.1 * (step % 10) as f32, 0.1);
                scene.primitives[mover].material = Arc::new(Material::diffuse("paint", color));
                scene.primitives[mover].material_revision = scene.revisions.materials;
            }
            2 => {
                let primitive = &mut scene.primitives[mover];
                primitive.world_from_object.matrix3 *= -1.0;
                primitive.bounds = primitive.mesh.bounds.transformed(&primitive.world_from_object);
            }
            3 => {
                scene.revisions.statics += 1;
                let primitive = &mut scene.primitives[(37 * step as usize) % 1000 + 1];
                primitive.moving = true;
                primitive.world_from_object.translation.y += 1.0;
                primitive.bounds = primitive.mesh.bounds.transformed(&primitive.world_from_object);
                primitive.geometry_revision = scene.revisions.geometry;
            }
            4 => {
                scene.revisions.statics += 1;
                scene.primitives.remove((53 * step as usize) % 1000 + 1);
            }
            5 => {
                scene.revisions.statics += 1;
                scene.primitives.iter_mut().filter(|p| p.id != MOVER).for_each(|p| p.moving = false);
            }
            _ => {}
        }
        let image = stage.render_with(&gpu, &mut renderer, &settings(false)).0;
        assert!(bits(&image.rgba) == afresh(&gpu, &stage), "step {step}: other bits than without reuse");
    }
}
