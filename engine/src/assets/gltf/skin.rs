//! Skins, and what vertices have for them and for morph targets.

use super::accessor::{Buffers, place};
use super::primitive::{Job, Reader};
use super::remarks::Remarks;
use super::{GltfNode, GltfSkin};
use crate::assets::{AssetError, Deform, Influences, MorphTarget};
use glam::{Affine3A, Mat4};
use gltf::Document;
use gltf::accessor::{Accessor, DataType, Dimensions};
use gltf::mesh::Semantic;
use std::sync::Arc;

/// Reads all skins. One that is broken has no joints.
pub(super) fn read(
    document: &Document,
    buffers: &Buffers,
    remarks: &mut Remarks,
) -> Result<Vec<Arc<GltfSkin>>, AssetError> {
    let mut skins = Vec::new();
    for skin in document.skins() {
        let at = format!("skin {}", skin.index());
        let joints: Vec<usize> = skin.joints().map(|joint| joint.index()).collect();
        let mut inverse_bind = vec![Affine3A::IDENTITY; joints.len()];
        if let Some(accessor) = skin.inverse_bind_matrices() {
            let matrices = matrices(&accessor, buffers, &at);
            let matrices = remarks.part(matrices, "its inverse bind matrices are taken for none")?;
            if let Some(found) = matrices.as_ref().map(Vec::len).filter(|found| *found < joints.len()) {
                remarks.fault(format!(
                    "{at}: has {found} inverse bind matrices for {} joints; the others have none",
                    joints.len()
                ));
            }
            let matrices = matrices.unwrap_or_default();
            let broken = matrices.iter().filter(|m| !m.is_finite()).count();
            if broken > 0 {
                remarks.fault(format!("{at}: {broken} inverse bind matrices are not finite; taken for none"));
            }
            let projects = |m: &&Mat4| m.is_finite() && !m.row(3).abs_diff_eq(glam::Vec4::W, 1e-4);
            let projecting = matrices.iter().filter(projects).count();
            if projecting > 0 {
                remarks.fault(format!("{at}: {projecting} inverse bind matrices project; only what is affine is kept"));
            }
            for (to, from) in inverse_bind.iter_mut().zip(&matrices).filter(|(_, from)| from.is_finite()) {
                *to = Affine3A::from_mat4(*from);
            }
        }
        skins.push(Arc::new(GltfSkin { joints, inverse_bind }));
    }
    Ok(skins)
}

fn matrices(accessor: &Accessor, buffers: &Buffers, at: &str) -> Result<Vec<Mat4>, AssetError> {
    if accessor.data_type() != DataType::F32 || accessor.dimensions() != Dimensions::Mat4 {
        let problem = "inverse bind matrices must be 4×4 matrices of floats";
        return Err(AssetError::format(buffers.path, format!("{at}, {}", place(accessor)), problem));
    }
    Ok(buffers.vectors::<16>(accessor)?.iter().map(Mat4::from_cols_array).collect())
}

/// Checks that the joints that meshes refer to are there, for each node with a skin. A node without them is drawn as it stands.
pub(super) fn check(nodes: &mut [GltfNode], skins: &[Arc<GltfSkin>], remarks: &mut Remarks) {
    for (i, node) in nodes.iter_mut().enumerate() {
        let Some(skin) = node.skin.and_then(|skin| skins.get(skin)) else { continue };
        let at = format!("node {i} \"{}\"", node.name);
        for (mesh, _) in &node.primitives {
            let Some(influences) = mesh.deform.as_ref().and_then(|d| d.skin.as_ref()) else {
                remarks.push(format!("{at}: has a skin, but its mesh \"{}\" has no joints and weights", mesh.name));
                continue;
            };
            let (highest, count) = (influences.highest_joint(), skin.joints.len());
            if highest >= count {
                let problem = format!("mesh \"{}\" refers to joint {highest}, but the skin has {count}", mesh.name);
                remarks.fault(format!("{at}: {problem}; drawn without the skin"));
                node.skin = None;
                break;
            }
        }
    }
}

impl Reader<'_> {
    /// Data for posing the primitive's vertices; none if it is rigid.
    pub(super) fn deform(&self, job: &Job, count: usize, remarks: &mut Remarks) -> Result<Option<Deform>, AssetError> {
        let skin = remarks.part(self.influences(job, count), "drawn without the skin")?.flatten();
        let targets = self.targets(job, count, remarks)?;
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

    /// Morph targets; attributes of them that are broken move nothing.
    fn targets(&self, job: &Job, count: usize, remarks: &mut Remarks) -> Result<Vec<MorphTarget>, AssetError> {
        let mut targets = Vec::new();
        for target in job.primitive.morph_targets() {
            let mut offsets = [target.positions(), target.normals(), target.tangents()].into_iter().map(|accessor| {
                let offsets = self.offsets(job, accessor, count);
                Ok::<_, AssetError>(remarks.part(offsets, "it moves nothing")?.unwrap_or_default())
            });
            let mut next = || offsets.next().unwrap_or_else(|| Ok(Vec::new()));
            targets.push(MorphTarget { positions: next()?, normals: next()?, tangents: next()? });
        }
        Ok(targets)
    }

    fn offsets(&self, job: &Job, accessor: Option<Accessor>, count: usize) -> Result<Vec<[f32; 3]>, AssetError> {
        let Some(a) = accessor else { return Ok(Vec::new()) };
        if a.count() != count {
            let problem = format!("{} elements of a morph target, but {count} positions", a.count());
            return Err(self.fail(job, &a, problem));
        }
        let values = self.buffers.vectors(&a)?;
        self.finite(job, &a, &values)?;
        Ok(values)
    }
}
