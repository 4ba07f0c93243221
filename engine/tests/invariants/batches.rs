//! Primitives with the same pipeline, material and mesh are drawn together.

use crate::support::{Stage, gpu};
use glam::{Affine3A, Vec3};
use lightwell::assets::{AlphaMode, Material, Shape};
use lightwell::graph::FrameReport;
use lightwell::render::{GiMethod, RenderSettings, Renderer};
use lightwell::scene::{LightShape, SceneId};
use std::sync::Arc;

/// 120 boxes and balls, red and blue by turns, in rows before the camera.
fn crowd() -> Stage {
    let mut stage = Stage::new(Vec3::new(0.0, 0.0, 12.0), Vec3::ZERO, 64);
    let ball = Shape::Sphere { radius: 0.3, segments: 8, rings: 4 };
    for shape in [Shape::Box { size: [0.5; 3] }, ball] {
        stage.add(shape, Vec3::X, Affine3A::IDENTITY);
    }
    let models = std::mem::take(&mut stage.scene.primitives);
    let materials = [Vec3::X, Vec3::Z].map(|color| Arc::new(Material::diffuse("paint", color)));
    for i in 0..120_u16 {
        let mut primitive = models[usize::from(i % 2)].clone();
        primitive.id = SceneId(100 + u64::from(i));
        primitive.material = materials[usize::from(i / 2 % 2)].clone();
        let at = Vec3::new(f32::from(i % 12) - 5.5, f32::from(i / 12) - 4.5, 0.0);
        primitive.world_from_object = Affine3A::from_translation(at);
        primitive.bounds = primitive.mesh.bounds.transformed(&primitive.world_from_object);
        stage.scene.primitives.push(primitive);
    }
    stage.light(LightShape::Directional, Vec3::ONE, Vec3::ZERO, Vec3::NEG_Z);
    stage
}

fn report(stage: &Stage) -> FrameReport {
    let settings = RenderSettings { gi: GiMethod::NONE, ..Default::default() };
    let gpu = gpu();
    stage.render_with(&gpu, &mut Renderer::new(&gpu), &settings).1
}

/// Draws and triangles of the passes whose name starts so.
fn drawn(report: &FrameReport, name: &str) -> (u64, u64) {
    let passes = report.passes.iter().filter(|pass| pass.name.starts_with(name));
    passes.fold((0, 0), |(draws, triangles), pass| (draws + pass.counts.draws, triangles + pass.counts.triangles))
}

#[test]
fn a_draw_for_each_mesh_and_material() {
    let stage = crowd();
    let all: usize = stage.scene.primitives.iter().map(|p| p.mesh.triangle_count()).sum();
    let report = report(&stage);
    assert_eq!(drawn(&report, "gbuffer"), (4, all as u64));
    assert_eq!(drawn(&report, "shadow "), (4, all as u64));
}

#[test]
fn mirrored_and_double_sided_ones_take_a_pipeline_of_their_own() {
    let mut stage = crowd();
    for primitive in &mut stage.scene.primitives[..12] {
        primitive.world_from_object.matrix3 *= -1.0;
    }
    assert_eq!(drawn(&report(&stage), "gbuffer").0, 8);
}

#[test]
fn what_lies_outside_the_view_is_not_drawn() {
    let mut stage = crowd();
    let all = drawn(&report(&stage), "gbuffer").1;
    for primitive in &mut stage.scene.primitives[60..] {
        primitive.world_from_object.translation.x += 100.0;
        primitive.bounds = primitive.mesh.bounds.transformed(&primitive.world_from_object);
    }
    let (draws, triangles) = drawn(&report(&stage), "gbuffer");
    assert!(draws <= 4 && triangles == all / 2, "{draws} draws, {triangles} of {all} triangles");
}

/// They are sorted by distance, so that no two of them may be drawn together.
#[test]
fn blended_ones_are_drawn_one_by_one() {
    let mut stage = crowd();
    let glass = Material { alpha_mode: AlphaMode::Blend, ..Material::diffuse("glass", Vec3::ONE) };
    let glass = Arc::new(Material { base_color: Vec3::ONE.extend(0.5), ..glass });
    stage.scene.primitives[..30].iter_mut().for_each(|primitive| primitive.material = glass.clone());
    let report = report(&stage);
    assert_eq!((drawn(&report, "gbuffer").0, drawn(&report, "blend").0), (4, 30));
}

/// Ninety boxes, each a mesh and some a surface of their own: handed over one by one or many in a call, the image is the
/// same to the bit, and so is what was drawn.
#[test]
fn many_draws_in_a_call_are_the_same_draws() {
    let mut stage = crowd();
    for (index, primitive) in stage.scene.primitives.iter_mut().enumerate().take(90) {
        let size = [0.3 + 0.004 * index as f32; 3];
        primitive.mesh = Arc::new(Shape::Box { size }.mesh().expect("a valid shape"));
        if index > 60 {
            primitive.material = Arc::new(Material::diffuse("own", Vec3::splat(0.01 * index as f32)));
        }
    }
    let settings = RenderSettings { gi: GiMethod::NONE, ..Default::default() };
    let mut gpu = gpu();
    let many = stage.render_with(&gpu, &mut Renderer::new(&gpu), &settings);
    gpu.draws_indirectly = false;
    let single = stage.render_with(&gpu, &mut Renderer::new(&gpu), &settings);
    let bits = |image: &lightwell::gpu::ImageF32| image.rgba.iter().map(|p| p.map(f32::to_bits)).collect::<Vec<_>>();
    assert!(bits(&many.0) == bits(&single.0), "the images differ");
    assert_eq!(drawn(&many.1, "gbuffer"), drawn(&single.1, "gbuffer"));
    assert!(drawn(&single.1, "gbuffer").0 >= 90, "{}", single.1);
}

/// What is seen in part is drawn primitive by primitive, what is seen whole a block at a time: the same draws, wherever the
/// view's border lies. Two hundred boxes in a row pass by; of some the box is empty, and they are never drawn.
#[test]
fn blocks_change_nothing_in_what_is_drawn() {
    let mut stage = crowd();
    let model = stage.scene.primitives[0].clone();
    stage.scene.primitives.clear();
    for index in 0..200_u16 {
        let mut primitive = model.clone();
        primitive.id = SceneId(100 + u64::from(index));
        let size = [0.3 + 0.0004 * f32::from(index); 3];
        primitive.mesh = Arc::new(Shape::Box { size }.mesh().expect("a valid shape"));
        primitive.world_from_object = Affine3A::from_translation(Vec3::new(f32::from(index) - 300.0, 0.0, 0.0));
        stage.scene.primitives.push(primitive);
    }
    let gpu = gpu();
    let settings = RenderSettings { gi: GiMethod::NONE, ..Default::default() };
    let mut most = 0;
    for shift in [0.0, 97.5, 180.0, 260.0, 300.0] {
        let mut inside = 0;
        let camera = lightwell::scene::Frustum::new(&stage.view.clip_from_world());
        for (index, primitive) in stage.scene.primitives.iter_mut().enumerate() {
            primitive.world_from_object.translation.x = index as f32 - 300.0 + shift;
            primitive.bounds = primitive.mesh.bounds.transformed(&primitive.world_from_object);
            if index % 50 == 3 {
                primitive.bounds = lightwell::scene::Aabb::EMPTY;
            }
            inside += u64::from(camera.intersects(&primitive.bounds));
        }
        stage.scene.revisions.geometry += 1;
        let report = stage.render_with(&gpu, &mut Renderer::new(&gpu), &settings).1;
        assert_eq!(drawn(&report, "gbuffer").0, inside, "moved by {shift}");
        most = most.max(inside);
    }
    assert!(most > 5, "{most} were seen at most");
}
