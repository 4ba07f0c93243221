//! Skins, and what vertices have for them and for morph targets.

use super::accessor::{Buffers, place};
use super::reader::{Job, Reader};
use super::remarks::Remarks;
use super::{GltfNode, GltfSkin, attribute};
use crate::assets::{AssetError, Deform, Influences, Mesh, MorphTarget};
use glam::{Affine3A, Mat4};
use gltf::Document;
use gltf::accessor::{Accessor, DataType, Dimensions};
use gltf::mesh::Semantic;
use std::collections::BTreeSet;
use std::sync::Arc;

/// Deviation of the sum of a vertex's weights from 1 beyond which they are taken for a fault.
const UNEVEN: f32 = 0.05;

/// Four joints and four weights of each vertex.
type JointsAndWeights = (Vec<[f32; 4]>, Vec<[f32; 4]>);

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

/// Checks that the joints that meshes refer to are there, for each node with a skin. Vertices lose those that are not. A node of
/// whose skin nothing is left is drawn as it stands.
pub(super) fn check(nodes: &mut [GltfNode], skins: &[Arc<GltfSkin>], remarks: &mut Remarks) {
    for (i, node) in nodes.iter_mut().enumerate() {
        let Some(skin) = node.skin.and_then(|skin| skins.get(skin)) else { continue };
        let at = format!("node {i} \"{}\"", node.name);
        for (mesh, _) in &mut node.primitives {
            let Some(influences) = mesh.deform.as_ref().and_then(|d| d.skin.as_ref()) else {
                remarks.push(format!("{at}: has a skin, but its mesh \"{}\" has no joints and weights", mesh.name));
                continue;
            };
            let (highest, count) = (influences.highest_joint(), skin.joints.len());
            if highest < count {
                continue;
            }
            let problem = format!("mesh \"{}\" refers to joint {highest}, but the skin has {count}", mesh.name);
            if count == 0 {
                remarks.fault(format!("{at}: {problem}; drawn without the skin"));
                node.skin = None;
                break;
            }
            remarks.fault(format!("{at}: {problem}; the weights of those that are not there are left out"));
            *mesh = Arc::new(within(mesh, count));
        }
    }
}

/// The mesh with the first `joints` joints alone.
fn within(mesh: &Mesh, joints: usize) -> Mesh {
    let mut limited = Mesh::new(mesh.name.clone(), mesh.vertices.clone(), mesh.indices.clone());
    limited.extras = mesh.extras.clone();
    let limit = |deform: &Arc<Deform>| {
        let skin = deform.skin.as_ref().map(|skin| skin.within(joints));
        Arc::new(Deform { skin, ..(**deform).clone() })
    };
    limited.deform = mesh.deform.as_ref().map(limit);
    limited
}

impl Reader<'_> {
    /// Data for posing the primitive's vertices; none if it is rigid.
    pub(super) fn deform(&self, job: &Job, count: usize, remarks: &mut Remarks) -> Result<Option<Deform>, AssetError> {
        let skin = self.influences(job, count, remarks);
        let skin = remarks.part(skin, "drawn without the skin")?.flatten();
        let targets = self.targets(job, count, remarks)?;
        if skin.is_none() && targets.is_empty() {
            return Ok(None);
        }
        Ok(Some(Deform { skin, targets, flat: false }))
    }

    fn influences(&self, job: &Job, count: usize, remarks: &mut Remarks) -> Result<Option<Influences>, AssetError> {
        let mut sets = Vec::new();
        let numbers = job.primitive.attributes().filter_map(|(semantic, _)| match semantic {
            Semantic::Joints(set) | Semantic::Weights(set) => Some(set),
            _ => None,
        });
        for set in numbers.collect::<BTreeSet<u32>>() {
            let set = self.influences_of(job, set, count, remarks);
            sets.extend(remarks.part(set, "left out")?);
        }
        if sets.is_empty() {
            return Ok(None);
        }
        let mut influences = Influences::default();
        let mut uneven = 0;
        for vertex in 0..count {
            let pairs = || {
                sets.iter().flat_map(|(joints, weights)| {
                    joints[vertex].iter().zip(weights[vertex]).map(|(joint, weight)| (*joint as u16, weight))
                })
            };
            let sum: f32 = pairs().map(|(_, weight)| weight).sum();
            uneven += usize::from((sum - 1.0).abs().is_nan() || (sum - 1.0).abs() > UNEVEN);
            influences.push(pairs());
        }
        if uneven > 0 {
            let problem = format!("the weights of {uneven} of {count} vertices do not sum to 1");
            remarks
                .fault(format!("{}: {problem}; made to, and a vertex without any follows its first joint", job.place));
        }
        Ok(Some(influences))
    }

    /// The joints and weights of one set.
    fn influences_of(
        &self,
        job: &Job,
        set: u32,
        count: usize,
        remarks: &mut Remarks,
    ) -> Result<JointsAndWeights, AssetError> {
        let joints = self.attribute(job, Semantic::Joints(set), count, &attribute::JOINTS, remarks)?;
        let weights = self.attribute(job, Semantic::Weights(set), count, &attribute::WEIGHTS, remarks)?;
        let (Some(joints), Some(weights)) = (joints, weights) else {
            return Err(self.wrong(job, format!("JOINTS_{set} and WEIGHTS_{set} must be there together")));
        };
        let is_joint = |joint: &f32| joint.fract() == 0.0 && (0.0..=f32::from(u16::MAX)).contains(joint);
        match joints.as_flattened().iter().find(|joint| !is_joint(joint)) {
            Some(joint) => Err(self.wrong(job, format!("JOINTS_{set}: {joint} is the number of no joint"))),
            None => Ok((joints, weights)),
        }
    }

    /// Morph targets; attributes of them that are broken move nothing.
    fn targets(&self, job: &Job, count: usize, remarks: &mut Remarks) -> Result<Vec<MorphTarget>, AssetError> {
        let mut targets = Vec::new();
        for target in job.primitive.morph_targets() {
            let mut offsets = [target.positions(), target.normals(), target.tangents()].into_iter().map(|accessor| {
                let Some(accessor) = accessor else { return Ok(Vec::new()) };
                let offsets = self.formatted(job, &accessor, count, &attribute::OFFSET, remarks);
                Ok::<_, AssetError>(remarks.part(offsets, "it moves nothing")?.unwrap_or_default())
            });
            let mut next = || offsets.next().unwrap_or_else(|| Ok(Vec::new()));
            targets.push(MorphTarget { positions: next()?, normals: next()?, tangents: next()? });
        }
        Ok(targets)
    }
}
