//! Import settings of models: beside the model in `NAME.import.ron`, or in the scene that uses it.

mod merge;
mod normals;
mod split;
#[cfg(test)]
mod tests;

use super::{Gltf, GltfNode, GltfPrimitive, LightUnits, tangents};
use crate::assets::{AssetId, Material, Mesh, Vertex};
use crate::core::ViewProjection;
use glam::{Mat3, Quat, Vec3};
use serde::{Deserialize, Serialize};
use std::collections::{HashMap, HashSet};
use std::sync::Arc;
use wildmatch::WildMatch;

/// Changes to a model as it is imported, in this order: what is ignored, the winding, merging, the normals, splitting;
/// axes and scale act on the model's top nodes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default, rename = "Import")]
pub struct ImportSettings {
    /// Multiplies all lengths.
    pub scale: f32,
    /// The axis of the file that points up.
    pub up: UpAxis,
    /// Names of nodes (with all below them), meshes and materials that are left out; `*` stands for any text and `?`
    /// for any character.
    pub ignore: Vec<String>,
    /// Turns all triangles round. Normals that are kept stay as they are.
    pub flip_winding: bool,
    /// Where normals come from.
    pub normals: Normals,
    /// How primitives are merged.
    pub parts: Parts,
    /// Units of the intensities of lights. They act where the model is put into a scene.
    pub light_units: LightUnits,
}

impl Default for ImportSettings {
    fn default() -> Self {
        Self {
            scale: 1.0,
            up: UpAxis::Y,
            ignore: Vec::new(),
            flip_winding: false,
            normals: Normals::Keep,
            parts: Parts::Keep,
            light_units: LightUnits::Auto,
        }
    }
}

/// The axis that points up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum UpAxis {
    /// +X.
    X,
    /// +Y, as glTF has it.
    #[default]
    Y,
    /// +Z.
    Z,
}

/// Where normals come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Normals {
    /// The file; flat where it has none.
    #[default]
    Keep,
    /// Each triangle has its own.
    Flat,
    /// The mean over the triangles around a vertex, weighted by their angle there, up to sharp edges.
    Smooth {
        /// Triangles that meet at a larger angle than this between their normals \[degrees\] have a sharp edge.
        #[serde(default = "usual_crease")]
        crease: f32,
    },
}

fn usual_crease() -> f32 {
    40.0
}

/// How primitives are merged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Parts {
    /// They stay.
    #[default]
    Keep,
    /// Each is split into the parts whose triangles share corners: more to draw, and less of it outside the view.
    Split {
        /// Parts of more triangles than this are halved until they have no more; none: they stay whole.
        #[serde(default)]
        most: Option<u32>,
    },
    /// All of one material become one.
    Merge,
}

/// A fault of import settings, or one that does not fit the model.
#[derive(Debug)]
pub struct ImportFault {
    /// The field.
    pub field: &'static str,
    /// The place in it, if it is a list.
    pub index: Option<usize>,
    /// The fault and help.
    pub message: String,
}

impl ImportSettings {
    /// Checks the values.
    ///
    /// # Errors
    /// A scale or an angle out of range, an empty pattern.
    pub fn validate(&self) -> Result<(), ImportFault> {
        let fault = |field, index, message| Err(ImportFault { field, index, message });
        if !(1e-9..=1e9).contains(&self.scale) {
            return fault("scale", None, format!("`scale` is {}; use a number above zero, 1e-9 to 1e9", self.scale));
        }
        if let Normals::Smooth { crease } = self.normals
            && !(0.0..=180.0).contains(&crease)
        {
            return fault("normals", None, format!("`crease` is {crease}; use an angle of 0 to 180 degrees"));
        }
        if self.parts == (Parts::Split { most: Some(0) }) {
            return fault("parts", None, "`most` is 0; use at least one triangle, or leave it out".into());
        }
        match self.ignore.iter().position(String::is_empty) {
            Some(index) => fault("ignore", Some(index), "the pattern is empty; name what to leave out".into()),
            None => Ok(()),
        }
    }

    /// The model as the settings want it.
    ///
    /// # Errors
    /// Those of [`ImportSettings::validate`], and a pattern that fits nothing in the model.
    pub fn apply(&self, mut model: Gltf) -> Result<Gltf, ImportFault> {
        self.validate()?;
        for (index, pattern) in self.ignore.iter().enumerate() {
            if !ignore(&mut model, pattern) {
                let message = format!("no node, mesh or material of the model fits the pattern `{pattern}`");
                return Err(ImportFault { field: "ignore", index: Some(index), message });
            }
        }
        if self.parts == Parts::Merge {
            merge::merge(&mut model);
        }
        self.change_meshes(&mut model);
        self.place(&mut model);
        Ok(model)
    }

    /// Winding, normals and parts of all meshes. A mesh that several nodes share stays shared.
    fn change_meshes(&self, model: &mut Gltf) {
        if !self.flip_winding && self.normals == Normals::Keep && !matches!(self.parts, Parts::Split { .. }) {
            return;
        }
        let mut changed: HashMap<(AssetId, bool), Vec<Arc<Mesh>>> = HashMap::new();
        for node in &mut model.nodes {
            let primitives = std::mem::take(&mut node.primitives);
            for (mesh, material) in primitives {
                let has_normal_map = material.normal_texture.is_some();
                let parts = changed.entry((mesh.id, has_normal_map)).or_insert_with(|| self.change(&mesh, &material));
                node.primitives.extend(parts.iter().map(|part| (part.clone(), material.clone())));
            }
        }
    }

    fn change(&self, mesh: &Mesh, material: &Material) -> Vec<Arc<Mesh>> {
        let (mut vertices, mut indices) = (mesh.vertices.clone(), mesh.indices.clone());
        if self.flip_winding {
            indices.chunks_exact_mut(3).for_each(|triangle| triangle.swap(1, 2));
        }
        let mut origins: Vec<u32> = match self.normals {
            Normals::Keep => (0..vertices.len() as u32).collect(),
            Normals::Flat => normals::flat(&mut vertices, &mut indices),
            Normals::Smooth { crease } => normals::smooth(&mut vertices, &mut indices, crease.to_radians()),
        };
        if self.normals != Normals::Keep {
            match material.normal_texture {
                Some(_) => {
                    let uv = |(v, origin): (&Vertex, &u32)| {
                        material.uv.normal.apply([v.uv, mesh.extra(*origin as usize).uv])
                    };
                    let uvs = vertices.iter().zip(&origins).map(uv).collect();
                    let copies = tangents::generate(&mut vertices, &mut indices, uvs);
                    origins.extend(copies.iter().map(|copy| origins[*copy as usize]).collect::<Vec<_>>());
                }
                None => vertices.iter_mut().for_each(|v| v.tangent = tangents::sound(v.normal, v.tangent)),
            }
        }
        let mut changed = Mesh::new(mesh.name.clone(), vertices, indices);
        changed.carry(mesh, &origins);
        match self.parts {
            Parts::Split { most } => split::split(&changed, most).into_iter().map(Arc::new).collect(),
            Parts::Keep | Parts::Merge => vec![Arc::new(changed)],
        }
    }

    /// Turns and scales the model about its origin.
    fn place(&self, model: &mut Gltf) {
        let turn = match self.up {
            UpAxis::X => Quat::from_mat3(&Mat3::from_cols(Vec3::Y, Vec3::NEG_X, Vec3::Z)),
            UpAxis::Y => Quat::IDENTITY,
            UpAxis::Z => Quat::from_mat3(&Mat3::from_cols(Vec3::X, Vec3::NEG_Z, Vec3::Y)),
        };
        if self.scale == 1.0 && self.up == UpAxis::Y {
            return;
        }
        if model.clips.iter().any(|clip| model.roots.iter().any(|root| clip.moves(*root))) {
            add_top(model);
        }
        for &root in &model.roots {
            let local = &mut model.nodes[root].local;
            local.translation = turn * (self.scale * local.translation);
            local.rotation = turn * local.unit_rotation();
            local.scale *= self.scale;
        }
        for node in &mut model.nodes {
            if let Some(camera) = &mut node.camera {
                camera.near *= self.scale;
                camera.far = camera.far.map(|far| far * self.scale);
                if let ViewProjection::Orthographic { height } = &mut camera.projection {
                    *height *= self.scale;
                }
            }
            if let Some(light) = &mut node.light {
                light.range = light.range.map(|range| range * self.scale);
            }
        }
    }
}

/// A node above all others: clips say where the roots are, and would undo what is done to them.
fn add_top(model: &mut Gltf) {
    let top = model.nodes.len();
    let children = std::mem::replace(&mut model.roots, vec![top]);
    children.iter().for_each(|child| model.nodes[*child].parent = Some(top));
    model.nodes.push(GltfNode { name: "import".into(), children, ..GltfNode::default() });
}

/// Leaves out what the pattern fits; false if that is nothing.
fn ignore(model: &mut Gltf, pattern: &str) -> bool {
    let pattern = WildMatch::new(pattern);
    let gone: HashSet<usize> = (0..model.nodes.len()).filter(|i| pattern.matches(&model.nodes[*i].name)).collect();
    model.roots.retain(|root| !gone.contains(root));
    let fits = |(mesh, material): &GltfPrimitive| pattern.matches(&mesh.name) || pattern.matches(&material.name);
    let mut found = !gone.is_empty();
    for node in &mut model.nodes {
        let before = node.primitives.len();
        node.children.retain(|child| !gone.contains(child));
        node.primitives.retain(|primitive| !fits(primitive));
        found |= node.primitives.len() < before;
    }
    // The nodes stay in the list, where others refer to them by index, but nothing leads there any more.
    for index in gone {
        model.nodes[index].primitives.clear();
    }
    found
}
