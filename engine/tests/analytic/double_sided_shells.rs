//! Closed meshes of double-sided material, which may be rooms seen from within as well as solids seen from without.

use crate::support::{Stage, error, gpu};
use glam::{Affine3A, Quat, Vec3};
use lightwell::assets::{Material, Mesh, Shape};
use lightwell::gpu::{Gpu, ImageF32};
use lightwell::measure::Image;
use lightwell::render::reference::{PathTracer, TraceSettings};
use lightwell::render::{GiMethod, Layer};
use lightwell::scene::{LightShape, Surfel, SurfelCloud};
use lightwell::world::{Bounces, CellSize, Clpv, GatherRays, Quality};
use std::f32::consts::PI;

fn paint(albedo: Vec3) -> Material {
    Material { double_sided: true, ..Material::diffuse("both sides", albedo) }
}

/// The shape with its surface turned inside out.
fn turned(shape: Shape) -> Mesh {
    let mut mesh = shape.mesh().expect("a valid shape");
    mesh.indices.chunks_exact_mut(3).for_each(|triangle| triangle.swap(1, 2));
    mesh.vertices.iter_mut().for_each(|vertex| vertex.normal = vertex.normal.map(|n| -n));
    mesh
}

fn settings(bounces: Bounces) -> Clpv {
    Clpv { bounces, quality: Quality::Low, ..Default::default() }
}

fn mean(image: &ImageF32) -> f32 {
    image.rgba.iter().map(|p| p[0]).sum::<f32>() / image.rgba.len() as f32
}

fn indirect(gpu: &Gpu, stage: &Stage) -> ImageF32 {
    stage.render(gpu, GiMethod::CLPV, Layer::Indirect)
}

fn traced(gpu: &Gpu, stage: &Stage, bounces: Option<u32>) -> Image {
    let mut tracer = PathTracer::new(gpu);
    let settings = TraceSettings { bounces, seed: 3 };
    tracer.begin(gpu, &stage.scene, &stage.view, &settings).expect("a scene that can be traced");
    tracer.advance(gpu, 128).expect("a device");
    tracer.estimate(gpu).expect("an image").indirect()
}

fn sphere(cell: Option<f32>, albedo: f32, inward: bool, bounces: Bounces) -> Stage {
    let mut stage = Stage::new(Vec3::new(0.0, 0.0, 0.3), Vec3::ZERO, 32);
    let shape = Shape::Sphere { radius: 1.0, segments: 64, rings: 32 };
    let mesh = if inward { turned(shape) } else { shape.mesh().expect("valid") };
    stage.add_mesh(mesh, paint(Vec3::splat(albedo)), Affine3A::IDENTITY);
    stage.light(LightShape::Point, Vec3::splat(PI), Vec3::ZERO, Vec3::Y);
    let mut clpv = settings(bounces);
    if let Some(cell) = cell {
        clpv.cell_size = CellSize::Meters(cell);
        clpv.cells = [(2.0 / cell).ceil() as u32 + 6; 3];
    }
    stage.clpv(Vec3::ZERO, clpv);
    stage
}

/// A room with a lamp: of six inward walls, or a double-sided box.
fn room(kind: &str, albedo: f32, size: Vec3, clpv: Clpv) -> Stage {
    let eye = 0.35 * size;
    let mut stage = Stage::new(eye, -eye, 32);
    let albedo = albedo * Vec3::new(1.0, 0.8, 0.6);
    let shape = || Shape::Box { size: size.to_array() };
    match kind {
        "walls" => stage.add_room(-0.5 * size, size, albedo),
        "outward" => stage.add_material(shape(), paint(albedo), Affine3A::IDENTITY),
        "inward" => stage.add_mesh(turned(shape()), paint(albedo), Affine3A::IDENTITY),
        "mirrored" => stage.add_material(shape(), paint(albedo), Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0))),
        _ => {
            // Thick walls, one mesh: an inner box in an outer one.
            let mut mesh = if kind == "thick" { turned(shape()) } else { shape().mesh().expect("valid") };
            let outer = Shape::Box { size: (size + 0.4).to_array() }.mesh().expect("valid");
            let first = mesh.vertices.len() as u32;
            mesh.vertices.extend(outer.vertices);
            mesh.indices.extend(outer.indices.iter().map(|i| i + first));
            mesh.bounds = outer.bounds;
            stage.add_mesh(mesh, paint(albedo), Affine3A::IDENTITY);
        }
    }
    stage.light(LightShape::Point, Vec3::splat(2.0), Vec3::new(0.08, 0.15, -0.05) * size, Vec3::NEG_Y);
    stage.clpv(Vec3::ZERO, clpv);
    stage
}

#[test]
fn a_double_sided_box_is_a_room_within() {
    let gpu = gpu();
    for (size, albedo, cascades, most) in [
        (Vec3::splat(4.0), 0.5, 1, [0.06, 0.02]),
        (Vec3::splat(4.0), 0.9, 2, [0.11, 0.03]),
        (Vec3::new(6.0, 2.5, 3.0), 0.5, 2, [0.08, 0.03]),
    ] {
        let of = |kind| room(kind, albedo, size, Clpv { cascades, ..settings(Bounces::Converged) });
        let truth = traced(&gpu, &of("inward"), None);
        for kind in ["inward", "outward", "mirrored", "thick", "thick out"] {
            let (nrmse, bias) = error(&indirect(&gpu, &of(kind)), &truth);
            let what = format!("{kind} {size}, albedo {albedo}, {cascades} cascades");
            assert!(nrmse < most[0] && bias.abs() < most[1], "{what}: nrmse {nrmse}, bias {bias}");
        }
    }
}

/// The first bounce in a sphere of albedo ½ around a light of intensity π brings ¼.
#[test]
fn a_sphere_of_few_cells_is_lit_within_whichever_way_it_faces() {
    let gpu = gpu();
    for (cell, least) in [(None, 0.75), (Some(0.66), 0.75), (Some(0.25), 0.85)] {
        let of = |inward| mean(&indirect(&gpu, &sphere(cell, 0.5, inward, Bounces::Count(1)))) / 0.25;
        let [outward, inward] = [false, true].map(of);
        assert!((outward / inward - 1.0).abs() < 0.05, "cells of {cell:?}: {outward}, facing inward {inward}");
        assert!((least..1.25).contains(&outward), "cells of {cell:?}: {outward} of the light");
    }
}

/// All ways to draw light turn the normal of a back that is seen.
#[test]
fn all_methods_light_a_back_as_they_light_a_front() {
    let gpu = gpu();
    let of = |kind| {
        room(kind, 0.5, Vec3::splat(4.0), Clpv { gather_rays: GatherRays::Count(2), ..settings(Bounces::Count(1)) })
    };
    for method in [GiMethod::NONE, GiMethod::CLPV, GiMethod::VPL, GiMethod::SLC] {
        let [outward, inward] = ["outward", "inward"].map(|kind| of(kind).render(&gpu, method, Layer::Total));
        let (outward, inward) = (mean(&outward), mean(&inward));
        assert!(inward > 0.0 && (outward / inward - 1.0).abs() < 0.01, "{method:?}: {outward}, inward {inward}");
    }
}

/// A plank, a book or a post encloses no room, and neither do the edges of a wide slab.
#[test]
fn what_is_thin_in_any_direction_has_no_inner_side() {
    let cloud = |size: [f32; 3], cell: f32, place: Affine3A| {
        let mut stage = Stage::new(Vec3::Z, Vec3::ZERO, 8);
        stage.add_material(Shape::Box { size }, paint(Vec3::ONE), place);
        let mut cloud = SurfelCloud::default();
        cloud.update(&stage.scene, cell);
        cloud.surfels
    };
    for size in [[2.0, 0.05, 1.0], [0.3, 0.2, 0.15], [0.2, 3.0, 0.2], [4.0, 0.2, 4.0]] {
        let surfels = cloud(size, 0.2, Affine3A::IDENTITY);
        assert!(surfels.iter().all(|s| s.thickness > 0.0 && s.place == 0), "a box of {size:?} has an inner side");
    }
    let of_room = cloud([2.0, 1.0, 3.0], 0.2, Affine3A::IDENTITY);
    let inner = of_room.iter().filter(|s| s.place != 0).count();
    assert_eq!(2 * inner, of_room.iter().filter(|s| s.thickness < -0.4).count());
    assert!(200 * inner > 97 * of_room.len(), "{inner} of {} are inner ones", of_room.len());
    // No surfel comes or goes where the object moves, and what is near them stays where it is.
    let moved = Affine3A::from_rotation_translation(Quat::from_rotation_y(0.7), Vec3::new(0.3, -5.0, 1.1));
    let moved = cloud([2.0, 1.0, 3.0], 0.2, moved);
    let same = |[a, b]: [&Surfel; 2]| {
        let sides = [a, b].map(|s| s.place >> 31);
        (a.position, a.normal, a.thickness, sides[0]) == (b.position, b.normal, b.thickness, sides[1])
    };
    assert!(of_room.len() == moved.len() && of_room.iter().zip(&moved).all(|(a, b)| same([a, b])));
    let changed = of_room.iter().zip(&moved).filter(|(a, b)| a.openness() != b.openness()).count();
    assert!(100 * changed < of_room.len(), "{changed} of {} surfels see something else", of_room.len());
}

/// A floor with boxes on it under a lamp, and a sky.
fn outside(double_sided: bool, edge: f32, cell: f32, bounces: Bounces) -> Stage {
    let mut stage = Stage::new(Vec3::new(1.5, 1.4, 1.9), Vec3::new(0.0, 0.2, 0.0), 48);
    let material = |albedo| if double_sided { paint(albedo) } else { Material::diffuse("outer side", albedo) };
    let floor = Shape::Box { size: [6.0, 1.2, 6.0] };
    stage.add_material(floor, material(Vec3::splat(0.7)), Affine3A::from_translation(Vec3::new(0.0, -0.6, 0.0)));
    for (x, z, color) in [(-0.8, -0.6, Vec3::new(0.8, 0.2, 0.1)), (0.7, -0.5, Vec3::new(0.1, 0.7, 0.2))] {
        let size = Vec3::new(edge, 1.0, edge);
        let at = Affine3A::from_translation(Vec3::new(x, 0.5, z));
        stage.add_material(Shape::Box { size: size.to_array() }, material(color), at);
    }
    stage.add_material(
        Shape::Box { size: [edge, 1.6, 4.0] },
        material(Vec3::splat(0.8)),
        Affine3A::from_translation(Vec3::new(-1.4 - 0.5 * edge, 0.8, 0.0)),
    );
    stage.light(LightShape::Point, Vec3::splat(2.0), Vec3::new(0.3, 1.1, 0.9), Vec3::NEG_Y);
    let cells = [(8.0 / cell) as u32, (4.5 / cell) as u32, (8.0 / cell) as u32];
    stage.clpv(Vec3::new(0.0, 0.6, 0.0), Clpv { cell_size: CellSize::Meters(cell), cells, ..settings(bounces) });
    stage
}

#[test]
fn outer_sides_are_lit_as_those_of_one_sided_solids() {
    let gpu = gpu();
    for (edge, cell) in [(0.05, 0.2), (0.2, 0.2), (0.4, 0.1), (0.6, 0.2)] {
        let of = |double_sided| outside(double_sided, edge, cell, Bounces::Converged);
        let truth = traced(&gpu, &of(false), None);
        let [one, both] = [false, true].map(|double_sided| error(&indirect(&gpu, &of(double_sided)), &truth));
        let what = format!("boxes of {edge} in cells of {cell}: {both:?}, one-sided {one:?}");
        assert!(both.0 < 1.1 * one.0 && both.1.abs() < one.1.abs() + 0.06, "{what}");
    }
}

/// Light that passes a closed shell, one way or the other, over what is on the lit side.
fn passed(gpu: &Gpu, kind: &str, edge: f32, cell: f32, shift: f32, degrees: f32, outwards: bool) -> f32 {
    let center = Vec3::new(shift, -0.4 * shift, 0.7 * shift);
    let inside = center + Vec3::new(0.1, 0.05, -0.12) * edge;
    let outside = center + Vec3::new(0.2, 0.15, 0.9) * edge;
    let lamp = if outwards { inside } else { outside };
    let of = |eye: Vec3| {
        let mut stage = Stage::new(eye, center - 0.3 * edge, 32);
        let place = Affine3A::from_translation(center) * Affine3A::from_rotation_y(degrees.to_radians());
        let shape = Shape::Box { size: [edge; 3] };
        match kind {
            "outward" => stage.add_material(shape, paint(Vec3::splat(0.8)), place),
            _ => stage.add_mesh(turned(shape), paint(Vec3::splat(0.8)), place),
        }
        let floor = center - Vec3::new(0.0, 0.5 * edge + 0.1, 0.0);
        let slab = Shape::Box { size: [3.0 * edge, 0.2, 3.0 * edge] };
        stage.add(slab, Vec3::splat(0.8), Affine3A::from_translation(floor));
        stage.light(LightShape::Point, Vec3::splat(2.0 * edge * edge), lamp, Vec3::NEG_Y);
        let cells = [(3.2 * edge / cell) as u32 + 2, (1.6 * edge / cell) as u32 + 4, (3.2 * edge / cell) as u32 + 2];
        stage.clpv(center, Clpv { cell_size: CellSize::Meters(cell), cells, ..settings(Bounces::Count(3)) });
        mean(&indirect(gpu, &stage))
    };
    let (within, without) = (of(inside), of(outside));
    if outwards { without / within } else { within / without }
}

#[test]
fn closed_shells_are_tight_both_ways() {
    let gpu = gpu();
    for outwards in [false, true] {
        let straight = passed(&gpu, "outward", 1.0, 0.25, 0.1, 0.0, outwards);
        println!("outwards {outwards}: {straight}");
        assert!(straight < 4e-3, "outwards {outwards}: {straight}");
        // As through one that faces inward.
        let [outward, inward] = ["outward", "inward"].map(|kind| passed(&gpu, kind, 1.0, 0.25, 0.1, 17.0, outwards));
        assert!(outward < 0.05 && outward < inward + 0.005, "outwards {outwards}: {outward}, facing inward {inward}");
    }
}

#[test]
fn a_shell_too_small_for_light_within_is_dark() {
    let gpu = gpu();
    let image = indirect(
        &gpu,
        &room(
            "outward",
            0.8,
            Vec3::splat(1.5),
            Clpv { cell_size: CellSize::Meters(1.0), cells: [6; 3], ..settings(Bounces::Converged) },
        ),
    );
    let wide = indirect(&gpu, &room("outward", 0.8, Vec3::splat(1.5), settings(Bounces::Converged)));
    assert!(mean(&image) < 0.05 * mean(&wide), "{} of {}", mean(&image), mean(&wide));
}
