//! Merging of all primitives of one material.

use super::super::{Gltf, GltfNode, GltfPrimitive};
use crate::assets::{AssetId, Material, Mesh, Vertex, VertexExtra};
use glam::{Affine3A, Mat3, Vec3};
use std::collections::HashMap;
use std::sync::Arc;

#[derive(Default)]
struct Merged {
    vertices: Vec<Vertex>,
    indices: Vec<u32>,
    extras: Vec<VertexExtra>,
    has_extras: bool,
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
        // What is posed stays where its joints and weights are.
        let (posed, rigid) = std::mem::take(&mut node.primitives).into_iter().partition(|(m, _)| m.deform.is_some());
        node.primitives = posed;
        for (mesh, material) in rigid as Vec<GltfPrimitive> {
            let target = merged.entry(material.id).or_insert_with(|| {
                order.push(material.clone());
                Merged::default()
            });
            if node.instances.is_empty() {
                target.add(&mesh, &place);
            }
            for instance in &node.instances {
                target.add(&mesh, &(place * instance.matrix()));
            }
        }
        open.extend(node.children.iter().rev().map(|child| (*child, place)));
    }
    let mesh = |material: &Arc<Material>| {
        let Merged { vertices, indices, extras, has_extras } = merged.remove(&material.id).unwrap_or_default();
        let mut mesh = Mesh::new(material.name.clone(), vertices, indices);
        mesh.extras = has_extras.then(|| Arc::new(extras));
        (Arc::new(mesh), material.clone())
    };
    let primitives = order.iter().map(mesh).collect();
    model.roots.push(model.nodes.len());
    model.nodes.push(GltfNode { name: "merged".into(), primitives, ..GltfNode::default() });
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
        self.has_extras |= mesh.extras.is_some();
        self.extras.extend((0..mesh.vertices.len()).map(|vertex| mesh.extra(vertex)));
        self.vertices.extend(mesh.vertices.iter().map(moved));
        for triangle in mesh.indices.chunks_exact(3) {
            let [a, b, c] = [0, 1, 2].map(|i| first + triangle[i]);
            self.indices.extend(if is_mirrored { [a, c, b] } else { [a, b, c] });
        }
    }
}
