//! Skins, and what vertices have for them and for morph targets.

use super::accessor::{Buffers, place};
use super::primitive::{Job, Reader};
use super::{GltfNode, GltfSkin};
use crate::assets::{AssetError, Deform, Influences, MorphTarget};
use glam::{Affine3A, Mat4};
use gltf::Document;
use gltf::accessor::{Accessor, DataType, Dimensions};
use gltf::mesh::Semantic;
use std::sync::Arc;

/// Reads all skins.
pub(super) fn read(
    document: &Document,
    buffers: &Buffers,
    warnings: &mut Vec<String>,
) -> Result<Vec<Arc<GltfSkin>>, AssetError> {
    let mut skins = Vec::new();
    for skin in document.skins() {
        let at = format!("skin {}", skin.index());
        let joints: Vec<usize> = skin.joints().map(|joint| joint.index()).collect();
        if joints.is_empty() {
            return Err(AssetError::format(buffers.path, at, "has no joints"));
        }
        let mut inverse_bind = vec![Affine3A::IDENTITY; joints.len()];
        if let Some(accessor) = skin.inverse_bind_matrices() {
            let matrices = matrices(&accessor, buffers, &at, joints.len())?;
            let broken = matrices.iter().filter(|m| !m.is_finite()).count();
            if broken > 0 {
                warnings.push(format!("{at}: {broken} inverse bind matrices are not finite; taken for none"));
            }
            for (to, from) in inverse_bind.iter_mut().zip(matrices).filter(|(_, from)| from.is_finite()) {
                *to = Affine3A::from_mat4(from);
            }
        }
        skins.push(Arc::new(GltfSkin { joints, inverse_bind }));
    }
    Ok(skins)
}

fn matrices(accessor: &Accessor, buffers: &Buffers, at: &str, count: usize) -> Result<Vec<Mat4>, AssetError> {
    let fail = |problem: String| Err(AssetError::format(buffers.path, format!("{at}, {}", place(accessor)), problem));
    if accessor.data_type() != DataType::F32 || accessor.dimensions() != Dimensions::Mat4 {
        return fail("inverse bind matrices must be 4×4 matrices of floats".into());
    }
    if accessor.count() < count {
        return fail(format!("{} inverse bind matrices for {count} joints", accessor.count()));
    }
    Ok(buffers.vectors::<16>(accessor)?.iter().map(Mat4::from_cols_array).collect())
}

/// Checks that the joints that meshes refer to are there, for each node with a skin.
pub(super) fn check(
    buffers: &Buffers,
    nodes: &[GltfNode],
    skins: &[Arc<GltfSkin>],
    warnings: &mut Vec<String>,
) -> Result<(), AssetError> {
    for (i, node) in nodes.iter().enumerate() {
        let Some(skin) = node.skin.and_then(|skin| skins.get(skin)) else { continue };
        let at = format!("node {i} \"{}\"", node.name);
        for (mesh, _) in &node.primitives {
            let Some(influences) = mesh.deform.as_ref().and_then(|d| d.skin.as_ref()) else {
                warnings.push(format!("{at}: has a skin, but its mesh \"{}\" has no joints and weights", mesh.name));
                continue;
            };
            if influences.highest_joint() >= skin.joints.len() {
                let problem = format!(
                    "mesh \"{}\" refers to joint {}, but the skin has {}",
                    mesh.name,
                    influences.highest_joint(),
                    skin.joints.len()
                );
                return Err(AssetError::format(buffers.path, at, problem));
            }
        }
    }
    Ok(())
}

impl Reader<'_> {
    /// Data for posing the primitive's vertices; none if it is rigid.
    pub(super) fn deform(&self, job: &Job, count: usize) -> Result<Option<Deform>, AssetError> {
        let skin = self.influences(job, count)?;
        let targets = self.targets(job, count)?;
        if skin.is_none() && targets.is_empty() {
            return Ok(None);
        }
        Ok(Some(Deform { skin, targets, flat: false }))
    }

    fn influences(&self, job: &Job, count: usize) -> Result<Option<Influences>, AssetError> {
        let mut sets = Vec::new();
        for set in 0.. {
            let joints = self.counted(job, Semantic::Joints(set), count)?;
            let weights = self.counted(job, Semantic::Weights(set), count)?;
            let (joints, weights) = match (joints, weights) {
                (Some(joints), Some(weights)) => (joints, weights),
                (None, None) => break,
                _ => return Err(self.wrong(job, format!("JOINTS_{set} and WEIGHTS_{set} must be there together"))),
            };
            let unsigned = matches!(joints.data_type(), DataType::U8 | DataType::U16) && !joints.normalized();
            if !unsigned || joints.dimensions() != Dimensions::Vec4 {
                return Err(self.fail(job, &joints, "joints must be four unsigned bytes or shorts".into()));
            }
            let unit = weights.normalized() && matches!(weights.data_type(), DataType::U8 | DataType::U16);
            if weights.data_type() != DataType::F32 && !unit {
                return Err(self.fail(job, &weights, "weights must be floats or normalised bytes or shorts".into()));
            }
            sets.push((self.buffers.vectors::<4>(&joints)?, self.buffers.vectors::<4>(&weights)?));
        }
        if sets.is_empty() {
            return Ok(None);
        }
        let mut influences = Influences::default();
        for vertex in 0..count {
            influences.push(sets.iter().flat_map(|(joints, weights)| {
                joints[vertex].iter().zip(weights[vertex]).map(|(joint, weight)| (*joint as u16, weight))
            }));
        }
        Ok(Some(influences))
    }

    fn targets(&self, job: &Job, count: usize) -> Result<Vec<MorphTarget>, AssetError> {
        let read = |accessor: Option<Accessor>| -> Result<Vec<[f32; 3]>, AssetError> {
            let Some(a) = accessor else { return Ok(Vec::new()) };
            if a.count() != count {
                let problem = format!("{} elements of a morph target, but {count} positions", a.count());
                return Err(self.fail(job, &a, problem));
            }
            self.float_only(job, &a)?;
            let values = self.buffers.vectors(&a)?;
            self.finite(job, &a, &values)?;
            Ok(values)
        };
        let target = |t: gltf::mesh::MorphTarget| {
            Ok(MorphTarget {
                positions: read(t.positions())?,
                normals: read(t.normals())?,
                tangents: read(t.tangents())?,
            })
        };
        job.primitive.morph_targets().map(target).collect()
    }
}
