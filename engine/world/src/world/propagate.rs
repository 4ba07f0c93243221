//! Transform propagation: from places relative to parents to places in the world.

use super::{GlobalTransform, Orientation, Transform};
use bevy_ecs::entity::EntityHashSet;
use bevy_ecs::prelude::*;
use glam::{Affine3A, Mat3A, Vec3, Vec3A};

type Moved = Or<(Changed<Transform>, Changed<ChildOf>)>;
type Node = (&'static mut GlobalTransform, &'static mut Orientation);

/// A place in the world without the entity itself.
#[derive(Clone, Copy)]
pub(super) struct Frame {
    world_from_local: GlobalTransform,
    orientation: Mat3A,
}

impl Frame {
    const WORLD: Self =
        Self { world_from_local: GlobalTransform(Affine3A::IDENTITY, Vec3::ZERO), orientation: Mat3A::IDENTITY };

    /// The frame of a child. Multiplied out from parent to child, so that the bits do not depend on what moved.
    fn child(&self, transform: Option<&Transform>) -> Self {
        let Some(transform) = transform else { return *self };
        let rotation = Mat3A::from_quat(transform.unit_rotation());
        let (matrix, local) = (self.world_from_local.0.matrix3, transform.matrix());
        let translation = matrix.as_dmat3() * Vec3::from(local.translation).as_dvec3();
        Self {
            world_from_local: GlobalTransform::new(
                matrix * local.matrix3,
                self.world_from_local.translation() + translation,
            ),
            orientation: orthonormal(matrix * rotation).unwrap_or_else(|| self.orientation * rotation),
        }
    }

    /// Writes only what differs. Compared by bits: −0 and 0 differ, a NaN equals itself.
    fn write(&self, mut global: Mut<GlobalTransform>, mut orientation: Mut<Orientation>) {
        if bits(&global) != bits(&self.world_from_local) {
            *global = self.world_from_local;
        }
        if orientation.0.to_cols_array().map(f32::to_bits) != self.orientation.to_cols_array().map(f32::to_bits) {
            orientation.0 = self.orientation;
        }
    }
}

fn bits(place: &GlobalTransform) -> ([u32; 12], [u32; 3]) {
    (place.0.to_cols_array().map(f32::to_bits), place.1.to_array().map(f32::to_bits))
}

/// The right-handed orthonormal axes whose −Z is that of `m`, with +Y as close to that of `m` as it can be. None where
/// an axis vanishes or is not finite.
fn orthonormal(m: Mat3A) -> Option<Mat3A> {
    let z = m.z_axis.try_normalize()?;
    let x = m.y_axis.try_normalize()?.cross(z).try_normalize()?;
    Some(Mat3A::from_cols(x, z.cross(x), z))
}

/// Updates [`GlobalTransform`] and [`Orientation`] below everything that moved or changed its parent.
#[allow(clippy::too_many_arguments)]
pub(super) fn propagate(
    moved: Query<Entity, Moved>,
    mut orphaned: RemovedComponents<ChildOf>,
    mut without_transform: RemovedComponents<Transform>,
    parents: Query<&ChildOf>,
    children: Query<&Children>,
    transforms: Query<&Transform>,
    mut nodes: Query<Node>,
    mut dirty: Local<EntityHashSet>,
    mut pending: Local<Vec<(Entity, Frame)>>,
) {
    dirty.clear();
    dirty.extend(moved.iter());
    dirty.extend(orphaned.read().chain(without_transform.read()));
    for entity in dirty.iter() {
        // Whoever stands below another that moved is reached from there.
        if ancestors(&parents, *entity).any(|a| dirty.contains(&a)) {
            continue;
        }
        let frame = parent_frame(&parents, &nodes, *entity);
        pending.push((*entity, frame));
        while let Some((entity, frame)) = pending.pop() {
            let frame = frame.child(transforms.get(entity).ok());
            if let Ok((global, orientation)) = nodes.get_mut(entity) {
                frame.write(global, orientation);
            }
            pending.extend(children.get(entity).into_iter().flatten().map(|child| (*child, frame)));
        }
    }
}

fn ancestors<'a>(parents: &'a Query<&ChildOf>, entity: Entity) -> impl Iterator<Item = Entity> + 'a {
    std::iter::successors(parents.get(entity).ok().map(ChildOf::parent), |e| parents.get(*e).ok().map(ChildOf::parent))
}

/// The frame of the nearest ancestor that has a place.
fn parent_frame(parents: &Query<&ChildOf>, nodes: &Query<Node>, entity: Entity) -> Frame {
    let place = ancestors(parents, entity).find_map(|a| nodes.get(a).ok());
    place.map_or(Frame::WORLD, |(global, orientation)| Frame { world_from_local: *global, orientation: orientation.0 })
}

/// The direction along −Z of an orientation.
pub(crate) fn forward(orientation: &Orientation) -> Vec3A {
    -orientation.0.z_axis
}

/// The direction along X of an orientation.
pub(crate) fn right(orientation: &Orientation) -> Vec3A {
    orientation.0.x_axis
}
