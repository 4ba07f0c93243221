//! Shapes against closed formulas, and their validation.
#![allow(clippy::unwrap_used)]

use super::{AssetLibrary, Mesh, Shape};
use glam::Vec3;
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

fn position(mesh: &Mesh, index: u32) -> Vec3 {
    Vec3::from(mesh.vertices[index as usize].position)
}

/// Area and enclosed volume (divergence theorem).
fn measure(mesh: &Mesh) -> (f64, f64) {
    mesh.indices.chunks_exact(3).fold((0.0, 0.0), |(area, volume), t| {
        let [a, b, c] = [0, 1, 2].map(|i| position(mesh, t[i]).as_dvec3());
        (area + 0.5 * (b - a).cross(c - a).length(), volume + a.dot(b.cross(c)) / 6.0)
    })
}

/// Every edge, taken by position, must be used once in each direction.
fn assert_closed(mesh: &Mesh) {
    let key = |i: u32| position(mesh, i).to_array().map(|x| (f64::from(x) * 1e5).round() as i64);
    let mut edges: HashMap<_, i32> = HashMap::new();
    for t in mesh.indices.chunks_exact(3) {
        for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
            assert_ne!(key(a), key(b), "{}: degenerate edge", mesh.name);
            *edges.entry((key(a), key(b))).or_default() += 1;
        }
    }
    for ((a, b), count) in &edges {
        assert_eq!((*count, edges.get(&(*b, *a))), (1, Some(&1)), "{}: edge {a:?} {b:?}", mesh.name);
    }
}

/// Normals and tangents are perpendicular units, triangles face their normals, and the tangent frame follows the
/// texture: the tangent along +u, the bitangent up the image (−v).
fn assert_frames(mesh: &Mesh) {
    for v in &mesh.vertices {
        let (n, t) = (Vec3::from(v.normal), Vec3::from_slice(&v.tangent[..3]));
        assert!(n.is_normalized() && t.is_normalized() && n.dot(t).abs() < 1e-5, "{}: {v:?}", mesh.name);
        assert!(v.uv.iter().all(|x| (-1e-6..=1.000_001).contains(x)), "{}: {v:?}", mesh.name);
    }
    for t in mesh.indices.chunks_exact(3) {
        let v = [0, 1, 2].map(|i| mesh.vertices[t[i] as usize]);
        let p = v.map(|v| Vec3::from(v.position));
        let uv = v.map(|v| glam::Vec2::from(v.uv));
        let normal = (p[1] - p[0]).cross(p[2] - p[0]);
        assert!(v.iter().all(|v| normal.dot(Vec3::from(v.normal)) > 0.0), "{}: {v:?}", mesh.name);
        let (d, e) = (uv[1] - uv[0], uv[2] - uv[0]);
        let det = d.perp_dot(e);
        assert!(det < 0.0, "{}: mirrored texture {v:?}", mesh.name);
        let along_u = ((p[1] - p[0]) * e.y - (p[2] - p[0]) * d.y) / det;
        assert!(v.iter().any(|v| along_u.dot(Vec3::from_slice(&v.tangent[..3])) > 0.0), "{}: {v:?}", mesh.name);
    }
}

fn close(what: &str, a: f64, b: f64) {
    assert!((a - b).abs() <= 2e-5 * b.abs(), "{what}: {a} is not {b}");
}

/// Area of the regular n-gon in a circle.
fn polygon(n: u32, radius: f64) -> f64 {
    0.5 * f64::from(n) * radius * radius * (TAU / f64::from(n)).sin()
}

#[test]
fn flat_shapes() {
    let quad = Shape::Quad { size: [2.0, 3.0] }.mesh().unwrap();
    assert_frames(&quad);
    assert_eq!(quad.triangle_count(), 2);
    assert!(quad.vertices.iter().all(|v| v.normal == [0.0, 0.0, 1.0] && v.position[2] == 0.0));
    close("area", measure(&quad).0, 6.0);
    let plane = Shape::Plane { size: [2.0, 3.0], subdivisions: [4, 5] }.mesh().unwrap();
    assert_frames(&plane);
    assert_eq!(plane.triangle_count(), 40);
    assert!(plane.vertices.iter().all(|v| v.normal == [0.0, 1.0, 0.0] && v.position[1] == 0.0));
    close("area", measure(&plane).0, 6.0);
    assert_eq!(plane.bounds.size(), Vec3::new(2.0, 0.0, 3.0));
}

#[test]
fn closed_shapes_have_their_area_and_volume() {
    let n = 24u32;
    let (r, h) = (0.7f32, 1.9f32);
    let (rd, hd) = (f64::from(r), f64::from(h));
    let edge = 2.0 * rd * (PI / f64::from(n)).sin();
    let apothem = rd * (PI / f64::from(n)).cos();
    let base = polygon(n, rd);
    let cases = [
        (Shape::Box { size: [1.0, 2.0, 3.0] }, 22.0, 6.0),
        (Shape::Cylinder { radius: r, height: h, segments: n }, 2.0 * base + f64::from(n) * edge * hd, base * hd),
        (
            Shape::Cone { radius: r, height: h, segments: n },
            base + 0.5 * f64::from(n) * edge * apothem.hypot(hd),
            base * hd / 3.0,
        ),
    ];
    for (shape, area, volume) in cases {
        let mesh = shape.mesh().unwrap();
        assert_closed(&mesh);
        assert_frames(&mesh);
        close("area", measure(&mesh).0, area);
        close("volume", measure(&mesh).1, volume);
    }
}

#[test]
fn round_shapes_approach_their_area_and_volume() {
    let (r, h, t) = (0.8f32, 1.5f32, 0.3f32);
    let (rd, hd, td) = (f64::from(r), f64::from(h), f64::from(t));
    let fine = 256;
    let cases = [
        (Shape::Sphere { radius: r, segments: fine, rings: fine }, 4.0 * PI * rd * rd, 4.0 / 3.0 * PI * rd.powi(3)),
        (
            Shape::Torus { radius: r, tube: t, segments: fine, sides: fine },
            TAU * rd * TAU * td,
            TAU * rd * PI * td * td,
        ),
        (
            Shape::Capsule { radius: r, height: h, segments: fine, rings: fine / 2 },
            4.0 * PI * rd * rd + TAU * rd * hd,
            4.0 / 3.0 * PI * rd.powi(3) + PI * rd * rd * hd,
        ),
    ];
    for (shape, area, volume) in cases {
        let mesh = shape.mesh().unwrap();
        assert_closed(&mesh);
        assert_frames(&mesh);
        let (a, v) = measure(&mesh);
        // Chords lie within the surface: both come out a little small, by O(1/n²).
        assert!(a < area && a > area * 0.999 && v < volume && v > volume * 0.999, "{shape:?}: {a} {area} {v} {volume}");
    }
}

#[test]
fn coarsest_and_default_shapes_are_closed() {
    let shapes = [
        "Box()",
        "Sphere()",
        "Cylinder()",
        "Cone()",
        "Torus()",
        "Capsule()",
        "Sphere(segments: 3, rings: 2)",
        "Cylinder(segments: 3)",
        "Cone(segments: 3)",
        "Torus(segments: 3, sides: 3)",
        "Capsule(segments: 3, rings: 1)",
    ];
    for text in shapes {
        let shape: Shape = ron::from_str(text).unwrap();
        let mesh = shape.mesh().unwrap();
        assert_closed(&mesh);
        assert!(measure(&mesh).1 > 0.0, "{text}");
        let back: Shape = ron::from_str(&ron::to_string(&shape).unwrap()).unwrap();
        assert_eq!(back, shape);
    }
    assert!(ron::from_str::<Shape>("Sphere(radios: 1.0)").is_err());
}

#[test]
fn senseless_parameters_are_refused_by_name() {
    let cases = [
        (Shape::Box { size: [1.0, -1.0, 1.0] }, "size"),
        (Shape::Box { size: [1.0, 0.0, 1.0] }, "size"),
        (Shape::Quad { size: [f32::NAN, 1.0] }, "size"),
        (Shape::Sphere { radius: f32::INFINITY, segments: 8, rings: 8 }, "radius"),
        (Shape::Sphere { radius: 1.0, segments: 2, rings: 8 }, "segments"),
        (Shape::Sphere { radius: 1.0, segments: u32::MAX, rings: 8 }, "segments"),
        (Shape::Sphere { radius: 1.0, segments: 4096, rings: 4096 }, "segments"),
        (Shape::Cone { radius: 1.0, height: -0.1, segments: 8 }, "height"),
        (Shape::Torus { radius: 1.0, tube: 1.0, segments: 8, sides: 8 }, "tube"),
        (Shape::Plane { size: [1.0; 2], subdivisions: [0, 1] }, "subdivisions"),
        (Shape::Plane { size: [1.0; 2], subdivisions: [4096, 4096] }, "subdivisions"),
        (Shape::Capsule { radius: 1.0, height: 1.0, segments: 8, rings: 0 }, "rings"),
    ];
    for (shape, field) in cases {
        let message = shape.mesh().unwrap_err().to_string();
        assert!(message.contains(shape.kind()) && message.contains(field), "{message}");
    }
}

#[test]
fn the_library_shares_shapes() {
    let mut library = AssetLibrary::new();
    let a = library.shape(&Shape::default()).unwrap();
    let b = library.shape(&Shape::default()).unwrap();
    let c = library.shape(&Shape::Box { size: [1.0, 1.0, 2.0] }).unwrap();
    assert!(Arc::ptr_eq(&a, &b) && !Arc::ptr_eq(&a, &c));
}
