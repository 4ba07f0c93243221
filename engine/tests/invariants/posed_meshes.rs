//! A posed mesh is the same for all who look at it: drawing, shadows, rays, surfels and bounds.

use crate::support::{Stage, error, gpu, rgb};
use glam::{Affine3A, Vec3};
use lightwell::assets::{Deform, Influences, Material, Mesh, MorphTarget, Shape};
use lightwell::bvh::Ray;
use lightwell::render::reference::{PathTracer, TraceSettings};
use lightwell::render::{GiMethod, Layer, RenderSettings, Renderer};
use lightwell::scene::{Extractor, LightShape, Primitive, Scene, SceneId, SurfelCloud};
use lightwell::scene::{RayKind, SceneBvh, Updated};
use lightwell::world::{Clpv, GameWorld, MeshRenderer, MorphWeights, Posed, Quality, Transform};
use std::sync::Arc;

/// A world with a cube whose upper half follows a joint and leans over.
struct Leaning {
    world: GameWorld,
    joint: bevy_ecs::prelude::Entity,
    extractor: Extractor,
    scene: Scene,
}

impl Leaning {
    fn new() -> Self {
        let mut mesh = Shape::Box { size: [1.0, 2.0, 1.0] }.mesh().expect("a box");
        let mut skin = Influences::default();
        mesh.vertices.iter().for_each(|v| skin.push([(u16::from(v.position[1] > 0.0), 1.0)].into_iter()));
        let positions = mesh.vertices.iter().map(|v| [0.0, 0.0, 0.2 * v.position[2]]).collect();
        let targets = vec![MorphTarget { positions, ..Default::default() }];
        mesh.deform = Some(Arc::new(Deform { skin: Some(skin), targets, flat: true }));
        // Flat normals belong to triangles that share no vertices.
        let mesh = Arc::new(unshared(mesh));
        let mut world = GameWorld::new();
        let model = world.spawn("model", None);
        let [low, joint] = ["low", "joint"].map(|name| world.spawn(name, Some(model)));
        let inverse_bind = Arc::new(vec![Affine3A::IDENTITY; 2]);
        let posed = Posed::new(mesh.clone(), Some(model)).with_skin(model, vec![low, joint], inverse_bind);
        let material = Arc::new(Material::diffuse("skin", Vec3::new(0.8, 0.4, 0.2)));
        let renderer = MeshRenderer { mesh, material, casts_shadow: true, visible: true };
        world.ecs.entity_mut(low).insert((posed, renderer));
        world.ecs.entity_mut(model).insert(MorphWeights(vec![0.5]));
        Self { world, joint, extractor: Extractor::new(), scene: Scene::default() }
    }

    fn lean(&mut self, by: f32) {
        let transform = Transform { translation: Vec3::X * by, ..Default::default() };
        self.world.ecs.entity_mut(self.joint).insert(transform);
        self.world.update();
        self.extractor.extract(&mut self.world, &mut self.scene);
    }

    fn mesh(&self) -> Arc<Mesh> {
        self.scene.primitives[0].mesh.clone()
    }
}

fn unshared(mesh: Mesh) -> Mesh {
    let deform = mesh.deform.as_ref().expect("a deformation").reordered(&mesh.indices);
    let vertices: Vec<_> = mesh.indices.iter().map(|i| mesh.vertices[*i as usize]).collect();
    let indices = (0..vertices.len() as u32).collect();
    let mut mesh = Mesh::new("box", vertices, indices);
    mesh.deform = Some(Arc::new(deform));
    mesh
}

#[test]
fn drawing_and_rays_see_the_same_pose() {
    let gpu = gpu();
    let mut leaning = Leaning::new();
    let mut stage = Stage::new(Vec3::new(0.3, 0.5, 3.0), Vec3::ZERO, 64);
    stage.light(LightShape::Directional, Vec3::splat(3.0), Vec3::ZERO, Vec3::new(-0.4, -1.0, -0.8));
    let mut renderer = Renderer::new(&gpu);
    let mut tracer = PathTracer::new(&gpu);
    let mut before: Option<Vec<[f32; 4]>> = None;
    for by in [0.0, 0.6, 1.0] {
        leaning.lean(by);
        stage.scene.primitives = leaning.scene.primitives.clone();
        stage.scene.revisions.geometry = 100 + leaning.scene.revisions.geometry;
        let settings = RenderSettings { gi: GiMethod::NONE, only: Layer::Direct, ..Default::default() };
        let drawn = stage.render_with(&gpu, &mut renderer, &settings).0;
        tracer.begin(&gpu, &stage.scene, &stage.view, &TraceSettings { bounces: Some(0), seed: 1 }).expect("begun");
        tracer.advance(&gpu, 32).expect("traced");
        let traced = tracer.estimate(&gpu).expect("read").total();
        let (mut far, mut lit) = (0, 0);
        for y in 0..64 {
            for x in 0..64 {
                let [r, g, b] = traced.pixels()[(x + 64 * y) as usize];
                lit += usize::from(r > 0.0);
                far += usize::from((rgb(&drawn, x, y) - Vec3::new(r, g, b)).abs().max_element() > 0.05);
            }
        }
        // All but the pixels on edges, which the tracer averages over.
        assert!(lit > 300 && far < 160, "leaning by {by}: {far} of {lit} pixels differ");
        assert!(before.is_none_or(|before| before != drawn.rgba), "the picture follows the pose");
        before = Some(drawn.rgba);
    }
}

#[test]
fn the_hierarchy_is_fitted_and_surfels_move_along() {
    let mut leaning = Leaning::new();
    leaning.lean(0.0);
    let mut bvh = SceneBvh::new(&leaning.scene);
    let mut cloud = SurfelCloud::default();
    cloud.update(&leaning.scene, 0.45);
    let before = cloud.surfels.clone();
    let down = Ray::new(Vec3::new(1.2, 5.0, 0.0), Vec3::NEG_Y);
    assert!(bvh.closest_hit(&down, 1e9, RayKind::Light).is_none());
    leaning.lean(1.0);
    assert_eq!(bvh.update(&leaning.scene), Updated::Refitted);
    assert_eq!(bvh.update(&leaning.scene), Updated::Nothing);
    let hit = bvh.closest_hit(&down, 1e9, RayKind::Light).expect("the lid is there now");
    assert!((hit.t - 4.0).abs() < 1e-5, "{hit:?}");
    assert_eq!(leaning.scene.primitives[0].bounds.max.x, 1.5);
    cloud.update(&leaning.scene, 0.45);
    assert_eq!(cloud.surfels.len(), before.len());
    // Their order is that of their patches, which they may leave.
    let moved = |a: &lightwell::scene::Surfel| {
        let lid = a.position[1] > 0.999 && a.normal[1] > 0.5;
        let expected = Vec3::from(a.position) + if lid { Vec3::X } else { Vec3::ZERO };
        let on_side = !lid && a.position[1] > -0.999;
        on_side || cloud.surfels.iter().any(|b| Vec3::from(b.position).distance(expected) < 1e-5)
    };
    assert!(before.iter().all(moved), "surfels of lid and floor move with them");
    assert!(leaning.mesh().rest.is_some());
}

/// A room with the leaning cube, lit by a lamp.
struct LeaningRoom {
    leaning: Leaning,
    stage: Stage,
}

impl LeaningRoom {
    fn new() -> Self {
        let mut stage = Stage::new(Vec3::new(1.6, 0.6, 1.7), Vec3::new(-1.0, -1.0, -1.2), 64);
        stage.add_room(Vec3::splat(-2.0), Vec3::splat(4.0), Vec3::new(0.7, 0.55, 0.4));
        stage.light(LightShape::Point, Vec3::splat(2.0), Vec3::new(0.3, 1.6, -0.2), Vec3::NEG_Y);
        stage.clpv(Vec3::ZERO, Clpv { quality: Quality::Medium, ..Default::default() });
        stage.scene.revisions.statics = 1;
        let mut room = Self { leaning: Leaning::new(), stage };
        room.leaning.lean(0.0);
        let cube = room.leaning.scene.primitives[0].clone();
        room.stage.scene.primitives.push(Primitive { id: SceneId(1000), ..cube });
        room
    }

    fn lean(&mut self, by: f32) {
        self.leaning.lean(by);
        let now = &self.leaning.scene.primitives[0];
        let scene = &mut self.stage.scene;
        scene.revisions.geometry += 1;
        let geometry_revision = scene.revisions.geometry;
        let place = Affine3A::from_translation(Vec3::new(-0.6, -0.9, -0.6));
        let bounds = now.mesh.bounds.transformed(&place);
        let posed = Primitive { id: SceneId(1000), world_from_object: place, bounds, geometry_revision, ..now.clone() };
        if let Some(last) = scene.primitives.last_mut() {
            *last = posed;
        }
    }
}

/// Patches of what bends are found elsewhere in each pose: a renderer that knew other poses draws the same bits.
#[test]
fn a_pose_is_lit_alike_whatever_came_before() {
    let gpu = gpu();
    let mut room = LeaningRoom::new();
    let settings = RenderSettings { only: Layer::Indirect, display: false, ..Default::default() };
    let mut renderer = Renderer::new(&gpu);
    let mut before: Option<Vec<[f32; 4]>> = None;
    for by in [0.0, 0.4, 0.9, 0.2] {
        room.lean(by);
        let kept = room.stage.render_with(&gpu, &mut renderer, &settings).0;
        let fresh = room.stage.render_with(&gpu, &mut Renderer::new(&gpu), &settings).0;
        assert!(kept.rgba == fresh.rgba, "leaning by {by}");
        assert!(before.is_none_or(|before| before != kept.rgba), "the light follows the pose");
        before = Some(kept.rgba);
    }
}

/// In a window an object that bends costs as few rays as one that moves, and its light is as right as that of one frame.
#[test]
fn what_bends_in_a_window_costs_few_rays() {
    let gpu = gpu();
    let mut room = LeaningRoom::new();
    let alone = RenderSettings { only: Layer::Indirect, display: false, ..Default::default() };
    let averaged = RenderSettings { average: true, ..alone.clone() };
    let mut renderer = Renderer::new(&gpu);
    let mut last = None;
    for frame in 0..24 {
        room.lean(0.02 * frame as f32);
        last = Some(room.stage.render_with(&gpu, &mut renderer, &averaged));
    }
    let (found, report) = last.expect("a frame");
    let rays = report.pass("gather").expect("a pass").counts.rays as f64 / (64.0 * 64.0);
    assert!(rays <= 1.5, "{rays} rays a pixel");
    let single = room.stage.render_with(&gpu, &mut Renderer::new(&gpu), &alone).0;
    let mut tracer = PathTracer::new(&gpu);
    let trace = TraceSettings { bounces: None, seed: 3 };
    tracer.begin(&gpu, &room.stage.scene, &room.stage.view, &trace).expect("a scene");
    tracer.advance(&gpu, 400).expect("a device");
    let truth = tracer.estimate(&gpu).expect("an image").indirect();
    let ((moving, bias), (single, _)) = (error(&found, &truth), error(&single, &truth));
    assert!(moving < 1.2 * single && bias.abs() < 0.03, "error {moving} against {single} of a frame, bias {bias}");
}
