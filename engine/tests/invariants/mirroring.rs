//! Objects that nodes or joints mirror look as meshes do whose vertices were mirrored: to the rasterizer, to rays and to
//! the path tracer.

use crate::support::{Stage, error, gpu};
use glam::{Affine3A, EulerRot, Mat3, Quat, Vec3};
use lightwell::assets::{AssetId, Deform, Influences, Material, Mesh, Sampling, Shape, Texture, Vertex};
use lightwell::gpu::{Gpu, ImageF32};
use lightwell::measure::Image;
use lightwell::render::reference::{PathTracer, TraceSettings};
use lightwell::render::{GiMethod, Layer, RenderSettings, Renderer};
use lightwell::scene::{Extractor, LightShape, Primitive, Scene, SceneId};
use lightwell::world::{Clpv, GameWorld, MeshRenderer, Posed, Quality, Transform};
use std::sync::Arc;

/// Numbers that look random (Knuth's linear congruential generator).
struct Rng(u64);

impl Rng {
    /// From 0 to 1.
    fn f32(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1 << 24) as f32
    }

    fn bool(&mut self) -> bool {
        self.f32() < 0.5
    }
}

/// A node of random turn, with uneven scales of which any number mirror.
fn node(random: &mut Rng) -> Transform {
    let angle = |random: &mut Rng| 6.0 * random.f32();
    let turn = Quat::from_euler(EulerRot::XYZ, angle(random), angle(random), angle(random));
    let mut scale = || (0.8 + 0.4 * random.f32()) * if random.bool() { -1.0 } else { 1.0 };
    Transform { translation: Vec3::ZERO, rotation: turn, scale: Vec3::from_array([0; 3].map(|_| scale())) }
}

/// A mesh with another place and other normals on each side.
fn model() -> Mesh {
    let mut mesh = Shape::Box { size: [1.2, 0.9, 0.7] }.mesh().expect("a box");
    for vertex in &mut mesh.vertices {
        vertex.position[0] += 0.3 * vertex.position[1];
    }
    Mesh::new("model", mesh.vertices, mesh.indices)
}

/// Smooth bumps that lean to one side, so that a tangent frame of the other hand shows.
fn material(double_sided: bool) -> Material {
    let mut material = Material::diffuse("bumps", Vec3::new(0.8, 0.6, 0.4));
    let texel = |i: u32| {
        [if i.is_multiple_of(2) { 210 } else { 120 }, if (i / 2).is_multiple_of(2) { 60 } else { 180 }, 230, 255]
    };
    material.normal_texture = Some(Arc::new(Texture {
        id: AssetId::fresh(),
        name: "bumps".into(),
        width: 2,
        height: 2,
        rgba: (0..4).flat_map(texel).collect(),
        srgb: false,
        sampling: Sampling { nearest: true, ..Default::default() },
    }));
    material.double_sided = double_sided;
    material
}

/// The mesh with a transform in its vertices.
fn baked(mesh: &Mesh, m: &Affine3A) -> Mesh {
    let linear = Mat3::from(m.matrix3);
    let (is_mirrored, normals) = (linear.determinant() < 0.0, linear.inverse().transpose());
    let vertex = |v: &Vertex| {
        let [x, y, z, w] = v.tangent;
        Vertex {
            position: m.transform_point3(v.position.into()).to_array(),
            normal: (normals * Vec3::from(v.normal)).normalize().to_array(),
            tangent: (linear * Vec3::new(x, y, z)).normalize().extend(if is_mirrored { -w } else { w }).to_array(),
            uv: v.uv,
        }
    };
    let turned = |t: &[u32]| if is_mirrored { [t[0], t[2], t[1]] } else { [t[0], t[1], t[2]] };
    let indices = mesh.indices.chunks_exact(3).flat_map(turned).collect();
    Mesh::new("baked", mesh.vertices.iter().map(vertex).collect(), indices)
}

/// The primitives of a world in which nodes, one below the other, hold the model; with `joints` the last ones are joints
/// of its skin, which lie below a node that is not the skin's root.
fn hierarchy(nodes: &[Transform], mesh: Mesh, material: &Arc<Material>, joints: bool) -> Vec<Primitive> {
    let mut world = GameWorld::new();
    let root = world.spawn("root", None);
    let mut last = root;
    for node in nodes {
        last = world.spawn("node", Some(last));
        world.ecs.entity_mut(last).insert(*node);
    }
    let (mut mesh, material) = (mesh, material.clone());
    let mut holder = last;
    if joints {
        let mut skin = Influences::default();
        mesh.vertices.iter().for_each(|_| skin.push([(0, 0.7), (1, 0.3)].into_iter()));
        mesh.deform = Some(Arc::new(Deform { skin: Some(skin), ..Default::default() }));
        holder = root;
    }
    let mesh = Arc::new(mesh);
    let renderer = MeshRenderer { mesh: mesh.clone(), material, casts_shadow: true, visible: true };
    world.ecs.entity_mut(holder).insert(renderer);
    if joints {
        let inverse_bind = Arc::new(vec![Affine3A::IDENTITY; 2]);
        world.ecs.entity_mut(holder).insert(Posed::new(mesh, None).with_skin(root, vec![last; 2], inverse_bind));
    }
    world.update();
    let mut scene = Scene::default();
    Extractor::new().extract(&mut world, &mut scene);
    scene.primitives
}

/// A floor, a light, and the object.
fn stage(object: Vec<Primitive>) -> Stage {
    let mut stage = Stage::new(Vec3::new(0.6, 1.1, 1.5), Vec3::ZERO, 48);
    let floor = Shape::Plane { size: [6.0; 2], subdivisions: [1; 2] };
    stage.add(floor, Vec3::splat(0.6), Affine3A::from_translation(Vec3::Y * -0.9));
    stage.light(LightShape::Directional, Vec3::splat(3.0), Vec3::ZERO, Vec3::new(-0.4, -1.0, -0.7));
    stage.clpv(Vec3::ZERO, Clpv { quality: Quality::Low, ..Default::default() });
    let placed = |(primitive, id): (Primitive, u64)| Primitive {
        id: SceneId(id),
        moving: false,
        geometry_revision: 1,
        material_revision: 1,
        ..primitive
    };
    stage.scene.primitives.extend(object.into_iter().zip(1000..).map(placed));
    stage.scene.revisions.geometry += 1;
    stage
}

fn traced(gpu: &Gpu, stage: &Stage) -> Image {
    let mut tracer = PathTracer::new(gpu);
    let settings = TraceSettings { bounces: Some(1), seed: 1 };
    tracer.begin(gpu, &stage.scene, &stage.view, &settings).expect("begun");
    tracer.advance(gpu, 64).expect("traced");
    tracer.estimate(gpu).expect("read").total()
}

fn image(found: &ImageF32) -> Image {
    Image::from_rgba(found.width, found.height, &found.rgba).expect("an image")
}

fn difference(a: &Image, b: &Image) -> f64 {
    let pairs = || a.pixels().iter().zip(b.pixels()).flat_map(|(a, b)| a.iter().zip(b));
    let square: f64 = pairs().map(|(a, b)| f64::from(a - b).powi(2)).sum();
    let total: f64 = pairs().map(|(_, b)| f64::from(*b)).sum();
    let count = pairs().count() as f64;
    (square / count).sqrt() / (total / count)
}

#[test]
fn mirrored_nodes_and_joints_look_as_mirrored_vertices() {
    let gpu = gpu();
    let mut random = Rng(4);
    let (mut mirrored, mut plain) = (0, 0);
    for number in 0..6 {
        let nodes: Vec<Transform> = (0..2 + number % 2).map(|_| node(&mut random)).collect();
        let whole = nodes.iter().fold(Affine3A::IDENTITY, |whole, node| whole * node.matrix());
        *(if whole.matrix3.determinant() < 0.0 { &mut mirrored } else { &mut plain }) += 1;
        let material = Arc::new(material(number % 3 == 0));
        let expected = stage(hierarchy(&[], baked(&model(), &whole), &material, false));
        let [drawn, lit] = [GiMethod::NONE, GiMethod::CLPV].map(|gi| image(&expected.render(&gpu, gi, Layer::Total)));
        let reference = traced(&gpu, &expected);
        for joints in [false, true] {
            let found = stage(hierarchy(&nodes, model(), &material, joints));
            let (nrmse, _) = error(&found.render(&gpu, GiMethod::NONE, Layer::Total), &drawn);
            assert!(nrmse < 0.02, "{number}, joints {joints}: rasterized, nrmse {nrmse}");
            let (nrmse, _) = error(&found.render(&gpu, GiMethod::CLPV, Layer::Total), &lit);
            assert!(nrmse < 0.02, "{number}, joints {joints}: with light volumes, nrmse {nrmse}");
            let nrmse = difference(&traced(&gpu, &found), &reference);
            assert!(nrmse < 0.05, "{number}, joints {joints}: traced, nrmse {nrmse}");
        }
    }
    assert!(mirrored > 0 && plain > 0, "{mirrored} mirrored, {plain} not");
}

/// A renderer that knew the object before it was mirrored draws what a fresh one draws.
#[test]
fn scales_may_go_through_zero_while_a_renderer_looks() {
    let gpu = gpu();
    let material = Arc::new(material(false));
    let mut kept = Renderer::new(&gpu);
    let settings = |only| RenderSettings { gi: GiMethod::CLPV, only, display: false, ..Default::default() };
    for joints in [false, true] {
        let mut mesh = model();
        let mut skin = Influences::default();
        mesh.vertices.iter().for_each(|_| skin.push([(0, 1.0)].into_iter()));
        mesh.deform = joints.then(|| Arc::new(Deform { skin: Some(skin), ..Default::default() }));
        let mesh = Arc::new(mesh);
        let mut world = GameWorld::new();
        let root = world.spawn("root", None);
        let moved = world.spawn("moved", Some(root));
        let holder = if joints { root } else { moved };
        let renderer =
            MeshRenderer { mesh: mesh.clone(), material: material.clone(), casts_shadow: true, visible: true };
        world.ecs.entity_mut(holder).insert(renderer);
        if joints {
            let posed = Posed::new(mesh, None).with_skin(root, vec![moved], Arc::new(vec![Affine3A::IDENTITY]));
            world.ecs.entity_mut(holder).insert(posed);
        }
        let (mut extractor, mut scene) = (Extractor::new(), Scene::default());
        let mut stage = stage(Vec::new());
        let floor = stage.scene.primitives.len();
        for (frame, x) in [1.0, 0.4, -0.4, -1.0, 0.7_f32].into_iter().enumerate() {
            let scale = Transform { scale: Vec3::new(x, 1.0, 1.0), ..Default::default() };
            world.ecs.entity_mut(moved).insert(scale);
            world.update();
            extractor.extract(&mut world, &mut scene);
            stage.scene.primitives.truncate(floor);
            let revision = 10 + frame as u64;
            let placed = |primitive: &Primitive| Primitive {
                id: SceneId(1000 + u64::from(joints)),
                moving: true,
                geometry_revision: revision,
                ..primitive.clone()
            };
            stage.scene.primitives.extend(scene.primitives.iter().map(placed));
            stage.scene.revisions.geometry = revision + 100 * u64::from(joints);
            stage.scene.revisions.statics = 1 + u64::from(joints);
            // Samples of a posed surface stay where they were taken on it, so that its indirect light has other noise.
            for (only, most) in [(Layer::Direct, 1e-3), (Layer::Total, if joints { 0.06 } else { 1e-3 })] {
                let known = stage.render_with(&gpu, &mut kept, &settings(only)).0;
                let fresh = stage.render_with(&gpu, &mut Renderer::new(&gpu), &settings(only)).0;
                let (nrmse, _) = error(&known, &image(&fresh));
                assert!(nrmse < most, "joints {joints}, scale {x}, {only:?}: nrmse {nrmse}");
            }
        }
    }
}
