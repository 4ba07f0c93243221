//! What glTF files hold: nodes with meshes, skins, cameras and lights.

use crate::assets::{Material, Mesh};
use crate::core::{LightKind, Transform, ViewProjection};
use glam::{Affine3A, Vec3};
use std::sync::Arc;

/// Triangles with their surface.
pub type GltfPrimitive = (Arc<Mesh>, Arc<Material>);

/// A camera of a file, looking along −Z.
#[derive(Clone, Debug, PartialEq)]
pub struct GltfCamera {
    /// Name; empty if the file has none.
    pub name: String,
    /// Projection; a field of view is above 0 and below π.
    pub projection: ViewProjection,
    /// Near plane \[m\].
    pub near: f32,
    /// Far plane \[m\]; none: infinite.
    pub far: Option<f32>,
    /// Width over height that the author had in mind.
    pub aspect: Option<f32>,
}

/// A light of a file (`KHR_lights_punctual`) with the numbers of the file, shining along −Z where it has a direction.
/// [`LightConversion`](super::LightConversion) says what they stand for.
#[derive(Clone, Debug, PartialEq)]
pub struct GltfLight {
    /// Name; empty if the file has none.
    pub name: String,
    /// Kind; cone angles in degrees.
    pub kind: LightKind,
    /// Colour, linear RGB.
    pub color: Vec3,
    /// Irradiance \[W/m²\] of directional lights, radiant intensity \[W/sr\] of the others, once it is converted.
    pub intensity: f32,
    /// Distance beyond which there is no light \[m\].
    pub range: Option<f32>,
}

/// Joints that vertices follow.
#[derive(Clone, Debug, PartialEq)]
pub struct GltfSkin {
    /// Indices of the nodes.
    pub joints: Vec<usize>,
    /// For each joint, its own space from that of the mesh, as the mesh was modelled.
    pub inverse_bind: Vec<Affine3A>,
}

/// A node of the hierarchy.
#[derive(Clone, Debug, Default)]
pub struct GltfNode {
    /// Name; `node N` if the file has none. Names need not be unique.
    pub name: String,
    /// Index of the parent.
    pub parent: Option<usize>,
    /// Indices of the children.
    pub children: Vec<usize>,
    /// Place relative to the parent.
    pub local: Transform,
    /// Its primitives. Nodes with the same mesh share them.
    pub primitives: Vec<GltfPrimitive>,
    /// Index of the skin that poses the primitives; their place is then that of the joints alone.
    pub skin: Option<usize>,
    /// Where copies of the primitives stand, in the node's own space, in place of the one at its origin
    /// (`EXT_mesh_gpu_instancing`); none: there is just that one.
    pub instances: Vec<Transform>,
    /// Weights of the morph targets of the primitives, as many as these have.
    pub weights: Vec<f32>,
    /// Camera that stands there.
    pub camera: Option<GltfCamera>,
    /// Light that stands there.
    pub light: Option<GltfLight>,
}
