//! Merging of all primitives of one material.

use super::super::{Gltf, GltfNode};
use crate::assets::{AssetId, Material, Mesh, Vertex};
use crate::world::Transform;
use glam::{Affine3A, Mat3, Vec3};
use std::collections::HashMap;
use std::sync::Arc;

#[derive(Default)]
struct Merged {
    vertices: Vec<Vertex>,
    indices: Vec<u32>,
}

/// Puts all that the model draws into one node at its top, one primitive a material. The other nodes keep their
/// lights and cameras.
pub(super) fn merge(model: &mut Gltf) {
    let mut order: Vec<Arc<Material>> = Vec::new();
    let mut merged: HashMap<AssetId, Merged> = HashMap::new();
    let mut open: Vec<(usize, Affine3A)> = model.roots.iter().rev().map(|root| (*root, Affine3A::IDENTITY)).collect();
    while let Some((index, parent)) = open.pop() {
        let node = &mut model.nodes[index];
        let place = parent * node.local.matrix();
        for (mesh, material) in std::mem::take(&mut node.primitives) {
            let target = merged.entry(material.id).or_insert_with(|| {
                order.push(material.clone());
                Merged::default()
            });
            target.add(&mesh, &place);
        }
        open.extend(node.children.iter().rev().map(|child| (*child, place)));
    }
    let mesh = |material: &Arc<Material>| {
        let Merged { vertices, indices } = merged.remove(&material.id).unwrap_or_default();
        (Arc::new(Mesh::new(material.name.clone(), vertices, indices)), material.clone())
    };
    let primitives = order.iter().map(mesh).collect();
    model.roots.push(model.nodes.len());
    model.nodes.push(GltfNode {
        name: "merged".into(),
        parent: None,
        children: Vec::new(),
        local: Transform::default(),
        primitives,
        camera: None,
        light: None,
    });
}

impl Merged {
    fn add(&mut self, mesh: &Mesh, place: &Affine3A) {
        let first = self.vertices.len() as u32;
        let linear = Mat3::from(place.matrix3);
        // Normals keep at right angles to the surface: the cofactors, which exist for flat scales too.
        let cofactors = Mat3::from_cols(
            linear.y_axis.cross(linear.z_axis),
            linear.z_axis.cross(linear.x_axis),
            linear.x_axis.cross(linear.y_axis),
        );
        let is_mirrored = linear.determinant() < 0.0;
        let sign = if is_mirrored { -1.0 } else { 1.0 };
        let moved = |v: &Vertex| {
            let [x, y, z, w] = v.tangent;
            let tangent = (linear * Vec3::new(x, y, z)).normalize_or(Vec3::X);
            Vertex {
                position: place.transform_point3(Vec3::from(v.position)).to_array(),
                normal: (sign * (cofactors * Vec3::from(v.normal))).normalize_or_zero().to_array(),
                tangent: tangent.extend(sign * w).to_array(),
                uv: v.uv,
            }
        };
        self.vertices.extend(mesh.vertices.iter().map(moved));
        for triangle in mesh.indices.chunks_exact(3) {
            let [a, b, c] = [0, 1, 2].map(|i| first + triangle[i]);
            self.indices.extend(if is_mirrored { [a, c, b] } else { [a, b, c] });
        }
    }
}
