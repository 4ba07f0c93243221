//! The node hierarchy with cameras and lights.

use super::remarks::Remarks;
use super::{GltfCamera, GltfLight, GltfNode};
use crate::assets::AssetError;
use crate::core::{DEFAULT_NEAR, LightKind, ORTHOGRAPHIC_HEIGHTS, Transform, ViewProjection};
use glam::{Mat3, Mat4, Quat, Vec3};
use gltf::Document;
use gltf::camera::Projection;
use gltf::khr_lights_punctual::{Kind, Light};
use std::f32::consts::PI;
use std::path::Path;

/// Reads all nodes, without their meshes, and the roots of the scene.
pub(super) fn read(path: &Path, document: &Document, remarks: &mut Remarks) -> (Vec<GltfNode>, Vec<usize>) {
    let cameras = each(document.cameras(), remarks, |camera, remarks| self::camera(path, camera, remarks));
    let lights = document.lights().into_iter().flatten();
    let lights = each(lights, remarks, |light, remarks| self::light(path, light, remarks));
    let mut nodes = Vec::new();
    for node in document.nodes() {
        let name = node.name().map_or(format!("node {}", node.index()), str::to_string);
        let json = &document.as_json().nodes[node.index()];
        let local = transform(&place(node.index(), &name), placed(json, &node, &name, remarks), remarks);
        nodes.push(GltfNode {
            local,
            children: json.children.iter().flatten().map(|c| c.value()).collect(),
            camera: json.camera.and_then(|c| cameras.get(c.value()).cloned().flatten()),
            light: node.light().and_then(|l| lights.get(l.index()).cloned().flatten()),
            name,
            ..GltfNode::default()
        });
    }
    link(&mut nodes, remarks);
    let roots = roots(document, &nodes, remarks);
    (nodes, roots)
}

/// Reads elements one by one; those that are broken are left out.
fn each<J, T>(
    elements: impl Iterator<Item = J>,
    remarks: &mut Remarks,
    read: impl Fn(&J, &mut Remarks) -> Result<T, AssetError>,
) -> Vec<Option<T>> {
    let read = |element: J| read(&element, remarks).map_err(|error| remarks.broken(&error, "left out")).ok();
    elements.map(read).collect()
}

fn place(index: usize, name: &str) -> String {
    format!("node {index} \"{name}\"")
}

/// The transform of a node. Of a matrix and parts, which exclude each other, the matrix counts unless it does nothing.
fn placed(json: &gltf::json::Node, node: &gltf::Node, name: &str, remarks: &mut Remarks) -> gltf::scene::Transform {
    let has_parts = json.translation.is_some() || json.rotation.is_some() || json.scale.is_some();
    let Some(matrix) = json.matrix.filter(|_| has_parts) else { return node.transform() };
    let is_identity = matrix == Mat4::IDENTITY.to_cols_array();
    let outcome = if is_identity { "the matrix does nothing, so that the others count" } else { "the matrix counts" };
    remarks.fault(format!(
        "{}: has a matrix, and translation, rotation or scale too; {outcome}",
        place(node.index(), name)
    ));
    if !is_identity {
        return node.transform();
    }
    gltf::scene::Transform::Decomposed {
        translation: json.translation.unwrap_or([0.0; 3]),
        rotation: json.rotation.map_or([0.0, 0.0, 0.0, 1.0], |rotation| rotation.0),
        scale: json.scale.unwrap_or([1.0; 3]),
    }
}

/// Notes the parents. Each node has at most one, and none is its own ancestor: what says otherwise is cut.
fn link(nodes: &mut [GltfNode], remarks: &mut Remarks) {
    for i in 0..nodes.len() {
        let children = std::mem::take(&mut nodes[i].children);
        let mut kept = Vec::with_capacity(children.len());
        for c in children {
            match nodes[c].parent {
                None => {
                    nodes[c].parent = Some(i);
                    kept.push(c);
                }
                Some(other) => {
                    let at = place(c, &nodes[c].name);
                    remarks.fault(format!("{at}: is a child of node {other}, and then of node {i}; the first counts"));
                }
            }
        }
        nodes[i].children = kept;
    }
    let mut reached = vec![false; nodes.len()];
    let tops: Vec<usize> = (0..nodes.len()).filter(|i| nodes[*i].parent.is_none()).collect();
    reach(nodes, tops, &mut reached);
    for i in 0..nodes.len() {
        if !reached[i] {
            // With one parent each, what no top node leads to hangs on a cycle.
            let first = on_cycle(nodes, i);
            cut(nodes, first, remarks);
            reach(nodes, vec![first], &mut reached);
        }
    }
}

fn reach(nodes: &[GltfNode], mut open: Vec<usize>, reached: &mut [bool]) {
    while let Some(i) = open.pop() {
        reached[i] = true;
        open.extend(&nodes[i].children);
    }
}

/// A node of the cycle that a node hangs on, by Floyd's two walkers.
fn on_cycle(nodes: &[GltfNode], start: usize) -> usize {
    let up = |node: usize| nodes[node].parent.unwrap_or(node);
    let (mut slow, mut fast) = (up(start), up(up(start)));
    while slow != fast {
        (slow, fast) = (up(slow), up(up(fast)));
    }
    slow
}

/// Makes a top node of one that is part of a cycle.
fn cut(nodes: &mut [GltfNode], on_cycle: usize, remarks: &mut Remarks) {
    let at = place(on_cycle, &nodes[on_cycle].name);
    remarks.fault(format!("{at}: is part of a cycle of nodes; it is taken for a top node"));
    if let Some(parent) = nodes[on_cycle].parent.take() {
        nodes[parent].children.retain(|child| *child != on_cycle);
    }
}

/// The top nodes of the scene that is shown.
fn roots(document: &Document, nodes: &[GltfNode], remarks: &mut Remarks) -> Vec<usize> {
    let json = document.as_json();
    let scene = shown_scene(json, remarks);
    let Some(listed) = json.scenes.get(scene) else {
        return (0..nodes.len()).filter(|i| nodes[*i].parent.is_none()).collect();
    };
    let mut is_root = vec![false; nodes.len()];
    let mut roots = Vec::new();
    for n in listed.nodes.iter().map(|n| n.value()) {
        if std::mem::replace(&mut is_root[n], true) {
            remarks.fault(format!("scene {scene}, {}: is listed twice; it counts once", place(n, &nodes[n].name)));
        } else {
            roots.push(n);
        }
    }
    let below_listed = |mut n: usize| {
        while let Some(parent) = nodes[n].parent {
            if is_root[parent] {
                return true;
            }
            n = parent;
        }
        false
    };
    roots.retain(|n| {
        let Some(parent) = nodes[*n].parent else { return true };
        let at = format!("scene {scene}, {}", place(*n, &nodes[*n].name));
        let is_below = below_listed(*n);
        let outcome = if is_below { "it counts as its child" } else { "it is shown without its parent" };
        remarks.fault(format!("{at}: is listed as a root, but is a child of node {parent}; {outcome}"));
        !is_below
    });
    roots
}

/// The scene that is shown: the default one, or the first one. Where it is empty, and nodes are there, one that is not.
fn shown_scene(json: &gltf::json::Root, remarks: &mut Remarks) -> usize {
    let scene = json.scene.map_or(0, |s| s.value());
    let is_empty = json.scenes.get(scene).is_some_and(|scene| scene.nodes.is_empty());
    if !is_empty || json.nodes.is_empty() {
        return scene;
    }
    let other = json.scenes.iter().position(|scene| !scene.nodes.is_empty());
    let outcome = other.map_or("all nodes are shown".into(), |other| format!("scene {other} is shown"));
    remarks.fault(format!("scene {scene}: has no nodes; {outcome}"));
    other.unwrap_or(json.scenes.len())
}

fn transform(place: &str, transform: gltf::scene::Transform, remarks: &mut Remarks) -> Transform {
    let local = match transform {
        gltf::scene::Transform::Matrix { matrix } => {
            let matrix = Mat4::from_cols_array_2d(&matrix);
            let local = decompose(&matrix);
            let error =
                (Mat4::from(local.matrix()) - matrix).to_cols_array().into_iter().fold(0.0, |m, x| x.abs().max(m));
            let size = matrix.to_cols_array().into_iter().fold(1.0, |m, x| x.abs().max(m));
            if matrix.is_finite() && error > 1e-3 * size {
                remarks.push(format!(
                    "{place}: its matrix shears or projects; only translation, rotation and scale are kept"
                ));
            }
            local
        }
        gltf::scene::Transform::Decomposed { translation, rotation, scale } => Transform {
            translation: Vec3::from(translation),
            rotation: Quat::from_array(rotation),
            scale: Vec3::from(scale),
        },
    };
    if !local.translation.is_finite() || !local.scale.is_finite() || !local.matrix().is_finite() {
        remarks.fault(format!("{place}: its transform is not finite; it stays where its parent is"));
        return Transform::default();
    }
    let rotation = local.rotation.length_squared();
    if !(rotation.is_finite() && rotation > 0.0) {
        remarks.fault(format!("{place}: its rotation has no direction; taken for none"));
        return Transform { rotation: Quat::IDENTITY, ..local };
    }
    Transform { rotation: local.rotation.normalize(), ..local }
}

/// Takes a matrix apart into translation, rotation and scale. A mirroring one gets a negative x scale; axes of length
/// zero are replaced for the rotation.
fn decompose(m: &Mat4) -> Transform {
    let axes = [m.x_axis, m.y_axis, m.z_axis].map(|c| c.truncate());
    let sign = if Mat3::from_cols(axes[0], axes[1], axes[2]).determinant() < 0.0 { -1.0 } else { 1.0 };
    let scale = Vec3::new(sign * axes[0].length(), axes[1].length(), axes[2].length());
    let translation = m.w_axis.truncate();
    let unit = |v: Vec3, s: f32| (s != 0.0).then(|| v / s);
    let (x, y, z) = match (unit(axes[0], scale.x), unit(axes[1], scale.y), unit(axes[2], scale.z)) {
        (Some(x), Some(y), Some(z)) => (x, y, z),
        (None, Some(y), Some(z)) => (y.cross(z), y, z),
        (Some(x), None, Some(z)) => (x, z.cross(x), z),
        (Some(x), Some(y), None) => (x, y, x.cross(y)),
        (Some(x), None, None) => (x, x.any_orthonormal_vector(), x.cross(x.any_orthonormal_vector())),
        (None, Some(y), None) => (y.cross(y.any_orthonormal_vector()).normalize_or_zero(), y, Vec3::ZERO),
        (None, None, Some(z)) => (z.any_orthonormal_vector(), z.cross(z.any_orthonormal_vector()), z),
        (None, None, None) => (Vec3::X, Vec3::Y, Vec3::Z),
    };
    let z = if z == Vec3::ZERO { x.cross(y) } else { z };
    let rotation = Quat::from_mat3(&Mat3::from_cols(x, y, z));
    Transform { translation, rotation, scale }
}

fn camera(path: &Path, camera: &gltf::Camera, remarks: &mut Remarks) -> Result<GltfCamera, AssetError> {
    let place = match camera.name() {
        Some(name) => format!("camera {} \"{name}\"", camera.index()),
        None => format!("camera {}", camera.index()),
    };
    let fail = |problem: String| Err(AssetError::format(path, &place, problem));
    let usual = DEFAULT_NEAR;
    let (projection, aspect, near, far, is_near) = match camera.projection() {
        Projection::Perspective(p) => {
            if !(p.yfov() > 0.0 && p.yfov() < PI) {
                return fail(format!("yfov {} must lie between 0 and π", p.yfov()));
            }
            let projection = ViewProjection::Perspective { vertical_fov: p.yfov() };
            (projection, p.aspect_ratio(), p.znear(), p.zfar(), p.znear() > 0.0)
        }
        Projection::Orthographic(o) => {
            // Half the width and height; negative ones, which would mirror the image, glTF advises against.
            let (width, height) = (2.0 * o.xmag().abs(), 2.0 * o.ymag().abs());
            if !ORTHOGRAPHIC_HEIGHTS.contains(&height) {
                return fail(format!("ymag {} must be between 5e-7 and 5e8 m", o.ymag()));
            }
            let projection = ViewProjection::Orthographic { height };
            (projection, Some(width / height), o.znear(), Some(o.zfar()), o.znear() >= 0.0)
        }
    };
    let near = if is_near && near.is_finite() {
        near
    } else {
        remarks.fault(format!("{place}: znear {near} must be positive and finite; taken as {usual}"));
        usual
    };
    let is_far = |far: &f32| *far > near && far.is_finite();
    if let Some(far) = far.filter(|far| !is_far(far)) {
        remarks.fault(format!("{place}: zfar {far} must be finite and beyond znear {near}; taken for infinite"));
    }
    let far = far.filter(is_far);
    let aspect = aspect.filter(|a| a.is_finite() && *a > 0.0);
    Ok(GltfCamera { name: camera.name().unwrap_or("").to_string(), projection, near, far, aspect })
}

fn light(path: &Path, light: &Light, remarks: &mut Remarks) -> Result<GltfLight, AssetError> {
    let place = match light.name() {
        Some(name) => format!("light {} \"{name}\"", light.index()),
        None => format!("light {}", light.index()),
    };
    let (color, intensity) = (Vec3::from(light.color()), light.intensity());
    if !(intensity >= 0.0 && intensity.is_finite()) {
        return Err(AssetError::format(path, place, format!("intensity {intensity} must be finite and not negative")));
    }
    if color.min_element() < 0.0 {
        remarks.fault(format!("{place}: colour {color} is negative; taken for black there"));
    }
    let range = light.range().filter(|range| {
        let is_valid = *range > 0.0 && range.is_finite();
        if !is_valid {
            remarks.fault(format!("{place}: range {range} must be positive and finite; taken for infinite"));
        }
        is_valid
    });
    let kind = match light.kind() {
        Kind::Directional => LightKind::Directional,
        Kind::Point => LightKind::Point,
        Kind::Spot { inner_cone_angle: inner, outer_cone_angle: outer } => cone(&place, inner, outer, remarks),
    };
    let name = light.name().unwrap_or("").to_string();
    Ok(GltfLight { name, kind, color: color.max(Vec3::ZERO), intensity, range })
}

/// The cone of a spot. Equal angles, as exporters write them for a hard edge, and those out of range become the nearest valid
/// ones.
fn cone(place: &str, inner: f32, outer: f32, remarks: &mut Remarks) -> LightKind {
    let within = outer.clamp(LEAST_CONE, 0.5 * PI);
    let inside = inner.clamp(0.0, (within - HARD_EDGE).max(0.0));
    if inner == outer && within == outer {
        remarks.fault(format!("{place}: its cone angles are both {outer}; taken for a hard edge"));
    } else if within + 1e-6 < outer || within > outer || inner < 0.0 || inner >= outer {
        remarks.fault(format!(
            "{place}: cone angles {inner} and {outer} must be 0 ≤ inner < outer ≤ π/2; taken as {inside} and {within}"
        ));
    }
    LightKind::Spot { inner: inside.to_degrees(), outer: within.to_degrees() }
}

/// Smallest outer angle of a spot \[rad\].
const LEAST_CONE: f32 = 2e-4;
/// Width of the edge of a spot that has none \[rad\]: a hundredth of a degree.
const HARD_EDGE: f32 = 1.745e-4;
