//! The node hierarchy with cameras and lights.

use super::{GltfCamera, GltfLight, GltfNode};
use crate::assets::AssetError;
use crate::scene::ViewProjection;
use crate::world::{self, LightKind, Transform};
use glam::{Mat3, Mat4, Quat, Vec3};
use gltf::Document;
use gltf::camera::Projection;
use gltf::khr_lights_punctual::Kind;
use std::f32::consts::PI;
use std::path::Path;

/// Reads all nodes, without their meshes, and the roots of the scene.
pub(super) fn read(
    path: &Path,
    document: &Document,
    warnings: &mut Vec<String>,
) -> Result<(Vec<GltfNode>, Vec<usize>), AssetError> {
    let cameras = cameras(path, document)?;
    let lights = lights(path, document)?;
    let mut nodes = Vec::new();
    for node in document.nodes() {
        let name = node.name().map_or(format!("node {}", node.index()), str::to_string);
        let place = place(node.index(), &name);
        let local = transform(path, &place, node.transform(), warnings)?;
        let json = &document.as_json().nodes[node.index()];
        nodes.push(GltfNode {
            local,
            children: json.children.iter().flatten().map(|c| c.value()).collect(),
            camera: json.camera.and_then(|c| cameras.get(c.value()).cloned()),
            light: node.light().and_then(|l| lights.get(l.index()).cloned()),
            name,
            ..GltfNode::default()
        });
    }
    link(path, &mut nodes)?;
    let roots = roots(path, document, &nodes)?;
    Ok((nodes, roots))
}

fn place(index: usize, name: &str) -> String {
    format!("node {index} \"{name}\"")
}

/// Notes the parents. Each node has at most one, and none is its own ancestor.
fn link(path: &Path, nodes: &mut [GltfNode]) -> Result<(), AssetError> {
    for i in 0..nodes.len() {
        for c in nodes[i].children.clone() {
            if let Some(other) = nodes[c].parent.replace(i) {
                let problem = format!("is a child of both node {other} and node {i}; a node has one parent");
                return Err(AssetError::format(path, place(c, &nodes[c].name), problem));
            }
        }
    }
    let mut reached = vec![false; nodes.len()];
    let mut open: Vec<usize> = (0..nodes.len()).filter(|i| nodes[*i].parent.is_none()).collect();
    while let Some(i) = open.pop() {
        reached[i] = true;
        open.extend(&nodes[i].children);
    }
    match reached.iter().position(|r| !r) {
        Some(i) => Err(AssetError::format(path, place(i, &nodes[i].name), "is part of a cycle of nodes")),
        None => Ok(()),
    }
}

fn roots(path: &Path, document: &Document, nodes: &[GltfNode]) -> Result<Vec<usize>, AssetError> {
    let json = document.as_json();
    let scene = json.scene.map_or(0, |s| s.value());
    for (i, s) in json.scenes.iter().enumerate() {
        let mut seen = vec![false; nodes.len()];
        for n in s.nodes.iter().map(|n| n.value()) {
            let fail = |problem: &str| {
                Err(AssetError::format(path, format!("scene {i}, {}", place(n, &nodes[n].name)), problem))
            };
            if let Some(parent) = nodes[n].parent {
                return fail(&format!("is listed as a root, but is a child of node {parent}"));
            }
            if std::mem::replace(&mut seen[n], true) {
                return fail("is listed twice");
            }
        }
    }
    match json.scenes.get(scene) {
        Some(scene) => Ok(scene.nodes.iter().map(|n| n.value()).collect()),
        None => Ok((0..nodes.len()).filter(|i| nodes[*i].parent.is_none()).collect()),
    }
}

fn transform(
    path: &Path,
    place: &str,
    transform: gltf::scene::Transform,
    warnings: &mut Vec<String>,
) -> Result<Transform, AssetError> {
    let local = match transform {
        gltf::scene::Transform::Matrix { matrix } => {
            let matrix = Mat4::from_cols_array_2d(&matrix);
            let local = decompose(&matrix);
            let error =
                (Mat4::from(local.matrix()) - matrix).to_cols_array().into_iter().fold(0.0, |m, x| x.abs().max(m));
            let size = matrix.to_cols_array().into_iter().fold(1.0, |m, x| x.abs().max(m));
            if matrix.is_finite() && error > 1e-3 * size {
                warnings.push(format!(
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
    if !(local.translation.is_finite() && local.rotation.is_finite() && local.scale.is_finite()) {
        return Err(AssetError::format(path, place, "its transform has numbers that are not finite"));
    }
    let rotation = local.rotation.length_squared();
    let rotation = if rotation > 0.0 && rotation.is_finite() { local.rotation.normalize() } else { Quat::IDENTITY };
    Ok(Transform { rotation, ..local })
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

fn cameras(path: &Path, document: &Document) -> Result<Vec<GltfCamera>, AssetError> {
    let mut cameras = Vec::new();
    for camera in document.cameras() {
        let place = format!("camera {}", camera.index());
        let fail = |problem: String| Err(AssetError::format(path, place.clone(), problem));
        let (projection, aspect, near, far) = match camera.projection() {
            Projection::Perspective(p) => {
                if !(p.yfov() > 0.0 && p.yfov() < PI) {
                    return fail(format!("yfov {} must lie between 0 and π", p.yfov()));
                }
                if !(p.znear() > 0.0 && p.znear().is_finite()) {
                    return fail(format!("znear {} must be positive and finite", p.znear()));
                }
                let projection = ViewProjection::Perspective { vertical_fov: p.yfov() };
                (projection, p.aspect_ratio(), p.znear(), p.zfar())
            }
            Projection::Orthographic(o) => {
                // Half the width and height; negative ones, which would mirror the image, glTF advises against.
                let (width, height) = (2.0 * o.xmag().abs(), 2.0 * o.ymag().abs());
                if !world::Projection::HEIGHTS.contains(&height) {
                    return fail(format!("ymag {} must be between 5e-7 and 5e8 m", o.ymag()));
                }
                if !(o.znear() >= 0.0 && o.znear().is_finite()) {
                    return fail(format!("znear {} must be finite and not negative", o.znear()));
                }
                (ViewProjection::Orthographic { height }, Some(width / height), o.znear(), Some(o.zfar()))
            }
        };
        if far.is_some_and(|f| !(f > near && f.is_finite())) {
            return fail(format!("zfar {} must be finite and beyond znear {near}", far.unwrap_or(0.0)));
        }
        let aspect = aspect.filter(|a| a.is_finite() && *a > 0.0);
        cameras.push(GltfCamera { name: camera.name().unwrap_or("").to_string(), projection, near, far, aspect });
    }
    Ok(cameras)
}

fn lights(path: &Path, document: &Document) -> Result<Vec<GltfLight>, AssetError> {
    let mut lights = Vec::new();
    for light in document.lights().into_iter().flatten() {
        let place = format!("light {}", light.index());
        let fail = |problem: String| Err(AssetError::format(path, place.clone(), problem));
        let (color, intensity) = (Vec3::from(light.color()), light.intensity());
        if !(intensity >= 0.0 && intensity.is_finite() && color.is_finite() && color.min_element() >= 0.0) {
            return fail(format!("intensity {intensity} and colour {color} must be finite and not negative"));
        }
        let range = light.range();
        if range.is_some_and(|r| !(r > 0.0 && r.is_finite())) {
            return fail(format!("range {} must be positive and finite", range.unwrap_or(0.0)));
        }
        let kind = match light.kind() {
            Kind::Directional => LightKind::Directional,
            Kind::Point => LightKind::Point,
            Kind::Spot { inner_cone_angle: inner, outer_cone_angle: outer } => {
                if !(inner >= 0.0 && inner < outer && outer <= 0.5 * PI + 1e-6) {
                    return fail(format!("cone angles {inner} and {outer} must be 0 ≤ inner < outer ≤ π/2"));
                }
                LightKind::Spot { inner: inner.to_degrees(), outer: outer.to_degrees() }
            }
        };
        lights.push(GltfLight { name: light.name().unwrap_or("").to_string(), kind, color, intensity, range });
    }
    Ok(lights)
}
