//! The system that poses meshes with skins and morph targets, on the CPU.
//!
//! A posed mesh is a mesh like any other, of a new identity for each new pose: drawing, shadow maps, the hierarchy for
//! rays, surfels and bounds all see the same triangles. A pose depends on the joints' transforms and the weights of
//! the frame alone; one that has not changed costs its look-up.

use super::clips::MorphWeights;
use super::{GlobalTransform, MeshRenderer, Transform};
use crate::assets::{Mesh, Pose, pose_all};
use bevy_ecs::prelude::*;
use glam::Affine3A;
use std::collections::HashMap;
use std::sync::Arc;

/// Poses the mesh of the entity's [`MeshRenderer`].
#[derive(Component, Clone, Debug)]
pub struct Posed {
    /// The mesh as modelled.
    pub rest: Arc<Mesh>,
    /// The entity with the [`MorphWeights`].
    #[entities]
    pub weights: Option<Entity>,
    /// The entity in whose space the skin poses the mesh; this one stands at the same place. None: no skin.
    #[entities]
    pub root: Option<Entity>,
    /// The joints of the skin.
    #[entities]
    pub joints: Vec<Entity>,
    /// Of each joint, its space from that of the mesh as modelled.
    pub inverse_bind: Arc<Vec<Affine3A>>,
    /// The pose that the renderer has now.
    shown: Option<Vec<u32>>,
}

impl Posed {
    /// A mesh with morph targets but without a skin.
    pub fn new(rest: Arc<Mesh>, weights: Option<Entity>) -> Self {
        Self { rest, weights, root: None, joints: Vec::new(), inverse_bind: Arc::default(), shown: None }
    }

    /// With a skin.
    pub fn with_skin(self, root: Entity, joints: Vec<Entity>, inverse_bind: Arc<Vec<Affine3A>>) -> Self {
        Self { root: Some(root), joints, inverse_bind, ..self }
    }
}

type Places<'w, 's> = Query<'w, 's, (Option<&'static Transform>, Option<&'static ChildOf>, &'static GlobalTransform)>;

/// Updates all posed meshes.
pub(super) fn deform(
    mut posed: Query<(Entity, &mut Posed, &mut MeshRenderer)>,
    places: Places,
    weights: Query<&MorphWeights>,
) {
    let mut known = HashMap::new();
    let (mut entities, mut work) = (Vec::new(), Vec::new());
    for (entity, posed, _) in &posed {
        let pose = pose(posed, &places, &weights, &mut known);
        let bits = pose.bits();
        if posed.shown.as_ref() != Some(&bits) {
            entities.push((entity, bits));
            work.push((posed.rest.clone(), pose));
        }
    }
    for ((entity, bits), mesh) in entities.into_iter().zip(pose_all(&work)) {
        let Ok((_, mut posed, mut renderer)) = posed.get_mut(entity) else { continue };
        posed.shown = Some(bits);
        renderer.mesh = mesh;
    }
}

/// Joints' places below their root that were found already in this frame.
type Known = HashMap<(Entity, Entity), Affine3A>;

fn pose(posed: &Posed, places: &Places, weights: &Query<&MorphWeights>, known: &mut Known) -> Pose {
    let weights = posed.weights.and_then(|e| weights.get(e).ok()).map_or(Vec::new(), |w| w.0.clone());
    let Some(root) = posed.root else { return Pose { weights, palette: Vec::new() } };
    let matrix = |(joint, inverse_bind): (&Entity, &Affine3A)| {
        let matrix = root_from_joint(root, *joint, places, known) * *inverse_bind;
        if matrix.is_finite() { matrix } else { Affine3A::IDENTITY }
    };
    Pose { weights, palette: posed.joints.iter().zip(posed.inverse_bind.iter()).map(matrix).collect() }
}

/// Multiplied out from the root down, so that the root's own place plays no part: a model that moves as a whole keeps
/// its pose to the bit.
fn root_from_joint(root: Entity, joint: Entity, places: &Places, known: &mut Known) -> Affine3A {
    let mut open = Vec::new();
    let mut at = joint;
    let mut place = loop {
        if at == root {
            break Affine3A::IDENTITY;
        }
        if let Some(place) = known.get(&(root, at)) {
            break *place;
        }
        let Ok((transform, parent, _)) = places.get(at) else { return Affine3A::IDENTITY };
        open.push((at, transform.map_or(Affine3A::IDENTITY, Transform::matrix)));
        let Some(parent) = parent else { return around(root, joint, places) };
        at = parent.parent();
    };
    for (entity, local) in open.into_iter().rev() {
        place *= local;
        known.insert((root, entity), place);
    }
    place
}

/// A joint that does not stand below the root.
fn around(root: Entity, joint: Entity, places: &Places) -> Affine3A {
    let world = |entity: Entity| places.get(entity).map_or(Affine3A::IDENTITY, |(_, _, global)| global.0);
    let place = world(root).inverse() * world(joint);
    if place.is_finite() { place } else { Affine3A::IDENTITY }
}
