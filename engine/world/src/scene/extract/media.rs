//! Participating media.

use super::context::{Context, Part, name_or_id};
use crate::scene::{MAX_MEDIA, MediumShape, Scene, SceneMedium};
use crate::world::{Fog, FogShape, GlobalTransform, Identity, Name, Orientation};
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemState;
use glam::{Affine3A, DAffine3, Vec3};
use std::ops::RangeInclusive;

type Row =
    (Entity, &'static Identity, Option<&'static Name>, &'static GlobalTransform, &'static Orientation, &'static Fog);
type RowItem<'a> = (Entity, &'a Identity, Option<&'a Name>, &'a GlobalTransform, &'a Orientation, &'a Fog);
type IsChanged =
    (With<Fog>, Or<(Changed<GlobalTransform>, Changed<Orientation>, Changed<Fog>, Changed<Name>, Added<Identity>)>);
type Params = (
    Query<'static, 'static, (), IsChanged>,
    Query<'static, 'static, Row>,
    RemovedComponents<'static, 'static, Fog>,
    RemovedComponents<'static, 'static, GlobalTransform>,
);

/// Said of those beyond [`MAX_MEDIA`].
const TOO_MANY: &str = "holds fog that is not drawn: a scene has at most 16";

/// The state of the world's media as of the last extraction. They are few: any change checks all.
pub(super) struct Media {
    state: SystemState<Params>,
}

impl Media {
    pub fn new(world: &mut World) -> Self {
        Self { state: SystemState::new(world) }
    }

    pub fn extract(&mut self, world: &mut World, scene: &mut Scene, context: &mut Context) {
        let Ok((changed, all, mut no_fog, mut no_place)) = self.state.get_mut(world) else { return };
        let is_removed = no_fog.read().chain(no_place.read()).count() > 0;
        if changed.is_empty() && !is_removed && !context.is_late {
            return;
        }
        context.log.begin_all(Part::Medium);
        let mut rows: Vec<RowItem> = all.iter().collect();
        rows.sort_unstable_by_key(|(_, identity, ..)| **identity);
        let mut media = Vec::new();
        for row in rows {
            let (entity, name) = (row.0, row.2);
            let Some(medium) = medium(row, scene, |message| context.log.warn(entity, Part::Medium, name, message))
            else {
                continue;
            };
            if media.len() < MAX_MEDIA {
                media.push(medium);
            } else {
                context.log.warn(entity, Part::Medium, name, TOO_MANY);
            }
        }
        // A new name is no new medium.
        for (old, new) in scene.media.iter_mut().zip(&media) {
            old.name.clone_from(&new.name);
        }
        if media != scene.media {
            scene.media = media;
            scene.revisions.media = context.revisions.next();
        }
    }
}

/// The medium of a fog; none if it has no effect. Warns of what had to be changed.
fn medium(
    (entity, identity, name, place, orientation, fog): RowItem,
    scene: &Scene,
    mut warn: impl FnMut(&'static str),
) -> Option<SceneMedium> {
    let (fog, is_valid) = sanitized(fog);
    if !is_valid {
        warn("has fog settings out of range; the nearest ones in range are used");
    }
    if fog.extinction == 0.0 {
        return None;
    }
    let (shape, half_size) = match fog.shape {
        FogShape::Everywhere => (MediumShape::Everywhere, Vec3::ONE),
        FogShape::Box { size } => (MediumShape::Box, 0.5 * size),
        FogShape::Sphere { radius } => (MediumShape::Sphere, Vec3::splat(radius)),
    };
    let place = place.relative_to(scene.origin);
    if !place.is_finite() {
        warn("holds fog that is not drawn: its place in the world is not finite");
        return None;
    }
    let local_from_world = match shape {
        MediumShape::Everywhere => Affine3A::IDENTITY,
        // In double precision: products of three small or large edges leave the range of single numbers.
        _ => (place.as_daffine3() * DAffine3::from_scale(half_size.as_dvec3())).inverse().as_affine3a(),
    };
    if !local_from_world.is_finite() {
        warn("holds fog that is not drawn: it is scaled to nothing");
        return None;
    }
    Some(SceneMedium {
        id: identity.id(),
        name: name_or_id(entity, name),
        shape,
        local_from_world,
        base: place.translation.into(),
        up: orientation.0.y_axis.into(),
        extinction: fog.extinction,
        albedo: fog.albedo,
        anisotropy: fog.anisotropy,
        falloff: fog.falloff,
    })
}

/// Settings in the ranges that [`Fog`] names, and whether they all were.
fn sanitized(fog: &Fog) -> (Fog, bool) {
    // Not a number is the least one of the range.
    let within = |value: f32, range: RangeInclusive<f32>| value.max(*range.start()).min(*range.end());
    let size = |value: f32| within(value, Fog::SIZES);
    let sane = Fog {
        shape: match fog.shape {
            FogShape::Everywhere => FogShape::Everywhere,
            FogShape::Box { size: edges } => FogShape::Box { size: edges.to_array().map(size).into() },
            FogShape::Sphere { radius } => FogShape::Sphere { radius: size(radius) },
        },
        extinction: within(fog.extinction, Fog::EXTINCTIONS),
        albedo: fog.albedo.to_array().map(|share| within(share, 0.0..=1.0)).into(),
        anisotropy: within(fog.anisotropy, Fog::ANISOTROPIES),
        falloff: within(fog.falloff, Fog::FALLOFFS),
    };
    (sane, sane == *fog)
}
