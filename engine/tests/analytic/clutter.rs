//! Rooms full of things that are smaller than patches of surfels, or reach into each other, against the path tracer. In such
//! rooms the mean light of a patch is not what its neighbours see: each bounce was a tenth too bright in crevices, and too
//! dark where most of a patch lies within other solids.

use crate::support::{Stage, error, gpu};
use glam::{Affine3A, EulerRot, Quat, Vec3};
use lightwell::assets::{Material, Mesh, Shape};
use lightwell::gpu::Gpu;
use lightwell::render::reference::{PathTracer, TraceSettings};
use lightwell::render::{GiMethod, Layer};
use lightwell::scene::{LightShape, Surfel, SurfelCloud};
use lightwell::world::Clpv;
use std::f32::consts::PI;

const SIZE: Vec3 = Vec3::new(3.0, 2.5, 3.5);

/// The room, from one side, with a lamp below its ceiling.
fn room() -> Stage {
    let mut stage = Stage::new(Vec3::new(1.5, 1.5, 3.4), Vec3::new(1.5, 0.7, 0.0), 48);
    stage.add_room(Vec3::ZERO, SIZE, Vec3::splat(0.7));
    stage.light(LightShape::Point, Vec3::splat(2.0), Vec3::new(1.2, 2.2, 1.6), Vec3::NEG_Y);
    stage.clpv(Vec3::ZERO, Clpv::default());
    stage
}

/// Numbers in 0..1 that fill a cube evenly (Roberts 2018, "The unreasonable effectiveness of quasirandom sequences").
fn spread(index: u32) -> Vec3 {
    (index as f32 * Vec3::new(0.819_172_5, 0.671_043_6, 0.549_700_5)).fract()
}

/// Adds a part of a mesh.
fn append(mesh: &mut Mesh, shape: &Shape, place: Affine3A) {
    let part = shape.mesh().expect("a valid shape");
    let first = mesh.vertices.len() as u32;
    for mut vertex in part.vertices {
        let point = place.transform_point3(vertex.position.into());
        vertex.position = point.to_array();
        vertex.normal = place.transform_vector3(vertex.normal.into()).normalize().to_array();
        mesh.bounds.min = mesh.bounds.min.min(point);
        mesh.bounds.max = mesh.bounds.max.max(point);
        mesh.vertices.push(vertex);
    }
    mesh.indices.extend(part.indices.iter().map(|index| index + first));
}

/// A heap of so many boxes of 3 to 25 cm, tumbled, on the floor.
fn heap(count: u32) -> Mesh {
    let boxed = |index: u32| {
        let edges = 0.03 + 0.22 * spread(3 * index + 1);
        let at = Vec3::new(0.0, 0.02, 0.0) + Vec3::new(2.2, 0.6, 3.3) * spread(index);
        let [x, y, z] = (6.0 * spread(7 * index + 2)).to_array();
        let turn = Quat::from_euler(EulerRot::XYZ, x, y, z);
        (Shape::Box { size: edges.to_array() }, Affine3A::from_rotation_translation(turn, at))
    };
    let (first, _) = boxed(0);
    let mut mesh = first.mesh().expect("a valid shape");
    for (shape, place) in (1..count).map(boxed) {
        append(&mut mesh, &shape, place);
    }
    mesh
}

/// Bias of all light between surfaces.
fn bias(gpu: &Gpu, stage: &Stage) -> f64 {
    let mut tracer = PathTracer::new(gpu);
    let settings = TraceSettings { bounces: None, seed: 3 };
    tracer.begin(gpu, &stage.scene, &stage.view, &settings).expect("a scene that can be traced");
    tracer.advance(gpu, 512).expect("a device");
    let truth = tracer.estimate(gpu).expect("an image").indirect();
    error(&stage.render(gpu, GiMethod::CLPV, Layer::Indirect), &truth).1
}

#[test]
fn a_heap_of_small_things_is_as_bright_as_traced() {
    let gpu = gpu();
    let mut stage = room();
    stage.add_mesh(heap(500), Material::diffuse("things", Vec3::new(0.7, 0.6, 0.8)), Affine3A::IDENTITY);
    let bias = bias(&gpu, &stage);
    assert!(bias.abs() < 0.015, "bias {bias:+.4}");
}

/// Boxes and cones on each other, each of which ends within the next, as capitals and mouldings are put together.
#[test]
fn solids_that_end_in_others_are_as_bright_as_traced() {
    let gpu = gpu();
    let mut stage = room();
    for (x, z) in [(0.5, 0.6), (1.5, 0.5), (2.5, 0.6), (0.6, 1.6), (2.4, 1.6)] {
        for layer in 0..15 {
            let [wide, high, _] = (Vec3::new(0.25, 0.3, 0.0) + 0.2 * spread(layer)).to_array();
            let at = Vec3::new(x, 0.15 * layer as f32 + 0.5 * high, z);
            let (shape, turn) = match layer % 2 {
                0 => (Shape::Cone { radius: 0.6 * wide, height: high, segments: 32 }, Quat::from_rotation_x(PI)),
                _ => (Shape::Box { size: [wide, high, wide] }, Quat::IDENTITY),
            };
            stage.add(shape, Vec3::splat(0.7), Affine3A::from_rotation_translation(turn, at));
        }
    }
    let bias = bias(&gpu, &stage);
    assert!(bias.abs() < 0.01, "bias {bias:+.4}");
}

/// Three boxes around one place: a ray from within one of them may meet the front of another first.
#[test]
fn hardly_a_surfel_is_within_a_solid_where_several_overlap() {
    let boxes = [
        (Vec3::ZERO, Vec3::new(1.0, 0.4, 1.0)),
        (Vec3::new(0.1, 0.1, 0.0), Vec3::new(0.8, 0.8, 0.5)),
        (Vec3::new(-0.1, -0.1, 0.1), Vec3::new(0.5, 1.2, 0.6)),
    ];
    let mut stage = Stage::new(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, 8);
    for (at, size) in boxes {
        let mut mesh = Shape::Box { size: size.to_array() }.mesh().expect("a valid shape");
        mesh.vertices.iter_mut().for_each(|vertex| vertex.position = (Vec3::from(vertex.position) + at).to_array());
        mesh.bounds.min += at;
        mesh.bounds.max += at;
        stage.add_mesh(mesh, Material::diffuse("box", Vec3::ONE), Affine3A::IDENTITY);
    }
    let mut cloud = SurfelCloud::default();
    cloud.update(&stage.scene, 0.1);
    let within = |surfel: &Surfel| {
        let point = Vec3::from(surfel.position);
        boxes.iter().any(|(at, size)| (point - at).abs().cmplt(0.5 * *size - 0.01).all())
    };
    let buried = cloud.surfels.iter().filter(|surfel| within(surfel)).count();
    assert!(cloud.surfels.len() > 1000 && 100 * buried < cloud.surfels.len(), "{buried} of {}", cloud.surfels.len());
}
