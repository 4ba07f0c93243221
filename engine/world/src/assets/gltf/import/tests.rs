//! Import settings on models made by hand.
#![allow(clippy::unwrap_used)]

use super::super::GltfNode;
use super::*;
use crate::assets::{Shape, Vertex};
use lightwell_needs::needs;
use std::path::PathBuf;

fn node(name: &str, mesh: Mesh, material: &Arc<Material>) -> GltfNode {
    GltfNode { name: name.into(), primitives: vec![(Arc::new(mesh), material.clone())], ..GltfNode::default() }
}

fn model(nodes: Vec<GltfNode>) -> Gltf {
    let roots = (0..nodes.len()).filter(|i| nodes[*i].parent.is_none()).collect();
    Gltf {
        path: PathBuf::from("m.glb"),
        generator: String::new(),
        nodes,
        roots,
        skins: Vec::new(),
        clips: Arc::default(),
        files: Vec::new(),
        warnings: Vec::new(),
        faults: Vec::new(),
    }
}

fn cube() -> Mesh {
    Shape::Box { size: [2.0; 3] }.mesh().unwrap()
}

fn white() -> Arc<Material> {
    Arc::new(Material::new("white"))
}

fn only_mesh(model: &Gltf) -> &Mesh {
    &model.nodes[0].primitives[0].0
}

/// Smallest cosine between a vertex normal and the direction from the origin.
fn least_radial(mesh: &Mesh) -> f32 {
    let radial = |v: &Vertex| Vec3::from(v.normal).dot(Vec3::from(v.position).normalize());
    mesh.vertices.iter().map(radial).fold(1.0, f32::min)
}

#[test]
fn smooth_normals_stop_at_creases() {
    let smooth = |crease| {
        let settings = ImportSettings { normals: Normals::Smooth { crease }, ..Default::default() };
        settings.apply(model(vec![node("cube", cube(), &white())])).unwrap()
    };
    // All edges of a cube are of 90°: all of its corners are smooth, or none.
    let round = smooth(91.0);
    assert!(least_radial(only_mesh(&round)) > 0.9999, "{}", least_radial(only_mesh(&round)));
    let sharp = smooth(89.0);
    for triangle in only_mesh(&sharp).indices.chunks_exact(3) {
        let [a, b, c] = [0, 1, 2].map(|i| only_mesh(&sharp).vertices[triangle[i] as usize]);
        let face = (Vec3::from(b.position) - Vec3::from(a.position))
            .cross(Vec3::from(c.position) - Vec3::from(a.position))
            .normalize();
        assert!([a, b, c].iter().all(|v| Vec3::from(v.normal).dot(face) > 0.9999));
    }
}

#[test]
fn smooth_normals_of_a_sphere_point_outwards_and_flat_ones_do_not() {
    let sphere = || node("ball", Shape::Sphere { radius: 1.0, segments: 32, rings: 16 }.mesh().unwrap(), &white());
    let with = |normals| ImportSettings { normals, ..Default::default() }.apply(model(vec![sphere()])).unwrap();
    assert!(least_radial(only_mesh(&with(Normals::Smooth { crease: 40.0 }))) > 0.999);
    let flat = with(Normals::Flat);
    assert!(least_radial(only_mesh(&flat)) < 0.998);
    assert_eq!(only_mesh(&flat).triangle_count(), sphere().primitives[0].0.triangle_count());
}

#[test]
fn flipped_triangles_wind_the_other_way_and_recomputed_normals_follow() {
    let settings = ImportSettings { flip_winding: true, normals: Normals::Flat, ..Default::default() };
    let turned = settings.apply(model(vec![node("cube", cube(), &white())])).unwrap();
    assert!(only_mesh(&turned).vertices.iter().all(|v| Vec3::from(v.normal).dot(Vec3::from(v.position)) < 0.0));
    let settings = ImportSettings { flip_winding: true, ..Default::default() };
    let kept = settings.apply(model(vec![node("cube", cube(), &white())])).unwrap();
    assert!(only_mesh(&kept).vertices.iter().all(|v| Vec3::from(v.normal).dot(Vec3::from(v.position)) > 0.0));
}

#[test]
fn ignored_names_are_left_out_with_all_below_them() {
    let red = Arc::new(Material::new("red"));
    let three = || {
        let mut nodes = vec![
            node("Room", cube(), &white()),
            node("Blind 01", cube(), &white()),
            node("Cord", cube(), &white()),
            node("Ball", cube(), &red),
        ];
        (nodes[1].parent, nodes[2].parent) = (Some(0), Some(1));
        (nodes[0].children, nodes[1].children) = (vec![1], vec![2]);
        model(nodes)
    };
    let count = |ignore: &[&str]| {
        let ignore = ignore.iter().map(|s| s.to_string()).collect();
        ImportSettings { ignore, ..Default::default() }.apply(three()).map(|m| m.triangle_count() / 12)
    };
    assert_eq!(count(&[]).unwrap(), 4);
    assert_eq!(count(&["Blind*"]).unwrap(), 2);
    assert_eq!(count(&["Blind ??"]).unwrap(), 2);
    assert_eq!(count(&["Cord"]).unwrap(), 3);
    assert_eq!(count(&["re*"]).unwrap(), 3);
    let fault = count(&["Room", "Blnd*"]).unwrap_err();
    assert!(fault.index == Some(1) && fault.message.contains("Blnd*"), "{fault:?}");
}

#[test]
fn parts_that_touch_nowhere_are_split_and_shared_meshes_stay_shared() {
    let mut vertices = cube().vertices;
    let mut indices = cube().indices;
    let count = vertices.len() as u32;
    vertices.extend(cube().vertices.iter().map(|v| Vertex { position: v.position.map(|x| x + 5.0), ..*v }));
    indices.extend(cube().indices.iter().map(|i| i + count));
    let pair = Mesh::new("pair", vertices, indices);
    let material = white();
    let first = node("a", pair, &material);
    let second = GltfNode { name: "b".into(), ..first.clone() };
    let settings = ImportSettings { parts: Parts::Split { most: None }, ..Default::default() };
    let apart = settings.apply(model(vec![first, second])).unwrap();
    for part in &apart.nodes[0].primitives {
        // Vertices of the cube's faces differ in their normals; the faces are one part all the same.
        assert_eq!(part.0.triangle_count(), 12);
    }
    let ids = |node: usize| apart.nodes[node].primitives.iter().map(|p| p.0.id).collect::<Vec<_>>();
    assert_eq!(ids(0).len(), 2);
    assert_eq!(ids(0), ids(1));
    assert_eq!(apart.triangle_count(), 48);
}

#[test]
fn merged_primitives_lie_where_they_lay() {
    let material = white();
    let mut nodes = vec![node("a", cube(), &material), node("b", cube(), &material), node("c", cube(), &white())];
    nodes[0].local.translation = Vec3::new(3.0, 0.0, 0.0);
    (nodes[1].parent, nodes[0].children) = (Some(0), vec![1]);
    nodes[1].local.scale = Vec3::new(-1.0, 2.0, 0.5);
    let whole = ImportSettings { parts: Parts::Merge, ..Default::default() }.apply(model(nodes)).unwrap();
    let drawn: Vec<_> = whole.nodes.iter().flat_map(|n| &n.primitives).collect();
    assert_eq!((drawn.len(), whole.triangle_count()), (2, 36));
    let (mesh, _) = drawn[0];
    assert_eq!((mesh.bounds.min, mesh.bounds.max), (Vec3::new(2.0, -2.0, -1.0), Vec3::new(4.0, 2.0, 1.0)));
    for triangle in mesh.indices.chunks_exact(3) {
        let [a, b, c] = [0, 1, 2].map(|i| mesh.vertices[triangle[i] as usize]);
        let face =
            (Vec3::from(b.position) - Vec3::from(a.position)).cross(Vec3::from(c.position) - Vec3::from(a.position));
        assert!(face.dot(Vec3::from(a.normal)) > 0.0, "mirrored triangles keep their outside");
    }
}

#[test]
fn axes_are_turned_and_lengths_scaled() {
    for (up, axis) in [(UpAxis::X, Vec3::X), (UpAxis::Y, Vec3::Y), (UpAxis::Z, Vec3::Z)] {
        let mut nodes = vec![node("a", cube(), &white())];
        nodes[0].local.translation = 4.0 * axis;
        let turned = ImportSettings { up, scale: 0.5, ..Default::default() }.apply(model(nodes)).unwrap();
        let place = turned.nodes[0].local.matrix();
        assert!(Vec3::from(place.translation).distance(2.0 * Vec3::Y) < 1e-6, "{up:?}: {place:?}");
        assert!(place.transform_vector3(axis).distance(0.5 * Vec3::Y) < 1e-6, "{up:?}: {place:?}");
        assert!(place.matrix3.determinant() > 0.0);
    }
}

#[test]
fn settings_out_of_range_are_named() {
    let patterns = |patterns: &[&str]| patterns.iter().map(|p| p.to_string()).collect();
    for (settings, field) in [
        (ImportSettings { scale: 0.0, ..Default::default() }, "scale"),
        (ImportSettings { scale: f32::NAN, ..Default::default() }, "scale"),
        (ImportSettings { normals: Normals::Smooth { crease: -1.0 }, ..Default::default() }, "normals"),
        (ImportSettings { ignore: patterns(&["a", ""]), ..Default::default() }, "ignore"),
        (ImportSettings { parts: Parts::Split { most: Some(0) }, ..Default::default() }, "parts"),
    ] {
        assert_eq!(settings.validate().unwrap_err().field, field);
    }
}

#[test]
fn large_parts_are_halved_and_lose_no_triangle() {
    let ball = || node("ball", Shape::Sphere { radius: 1.0, segments: 32, rings: 16 }.mesh().unwrap(), &white());
    let triangles = ball().primitives[0].0.triangle_count();
    let settings = ImportSettings { parts: Parts::Split { most: Some(100) }, ..Default::default() };
    let apart = settings.apply(model(vec![ball()])).unwrap();
    let parts = &apart.nodes[0].primitives;
    assert!(parts.iter().all(|part| part.0.triangle_count() <= 100));
    assert!(parts.len() <= triangles / 50, "{} parts", parts.len());
    assert_eq!(apart.triangle_count(), triangles);
    // Halves lie beside each other. If they lay anywhere, each of the 16 would have nearly the bounds of the whole.
    let volume = |mesh: &Mesh| mesh.bounds.size().element_product();
    let sum: f32 = parts.iter().map(|part| volume(&part.0)).sum();
    assert!(sum < 0.2 * 8.0 * parts.len() as f32, "{sum} m³ in {} parts", parts.len());
}

#[needs("LIGHTWELL_MODELS")]
fn sibenik_splits_into_436_parts_and_into_more_than_1200_of_64_triangles() {
    let models = std::env::var_os("LIGHTWELL_MODELS").map(PathBuf::from).expect("LIGHTWELL_MODELS is not set");
    let whole = Gltf::load(models.join("sibenik/sibenik.glb")).unwrap();
    let parts = |most| {
        let start = std::time::Instant::now();
        let settings = ImportSettings { parts: Parts::Split { most }, ..Default::default() };
        let apart = settings.apply(whole.clone()).unwrap();
        let parts: usize = apart.nodes.iter().map(|node| node.primitives.len()).sum();
        eprintln!("Sibenik, most {most:?}: {parts} parts in {:?}", start.elapsed());
        assert_eq!(apart.triangle_count(), whole.triangle_count());
        parts
    };
    assert_eq!(parts(None), 436);
    assert!((1200..2500).contains(&parts(Some(64))));
}
