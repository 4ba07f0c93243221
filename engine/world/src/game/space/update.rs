//! The space follows the world.

use super::{Instance, SpatialQuery};
use crate::bvh::Bvh;
use crate::files::SceneData;
use crate::scene::Aabb;
use crate::world::{GlobalTransform, Identity, MeshRenderer};
use bevy_ecs::prelude::*;

/// Marks an entity that is visible but not solid: rays and moving bodies of a game pass through it.
#[derive(Component, SceneData, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NonSolid;

type Row = (Entity, &'static Identity, &'static GlobalTransform, &'static MeshRenderer, Has<NonSolid>);
type IsChanged = (With<MeshRenderer>, Or<(Changed<GlobalTransform>, Changed<MeshRenderer>, Added<NonSolid>)>);

/// Updates the space, if anything in it changed.
pub fn update(
    mut space: ResMut<SpatialQuery>,
    all: Query<Row>,
    changed: Query<(), IsChanged>,
    mut gone: RemovedComponents<MeshRenderer>,
    mut solid: RemovedComponents<NonSolid>,
) {
    let removed = gone.read().count() + solid.read().count();
    if changed.is_empty() && removed == 0 {
        return;
    }
    let mut rows: Vec<_> = all.iter().filter(|(.., renderer, _)| renderer.visible).collect();
    rows.sort_unstable_by_key(|(_, identity, ..)| **identity);
    space.follow(rows.into_iter().map(|(entity, _, place, renderer, is_ghost)| (entity, place, renderer, is_ghost)));
}

impl SpatialQuery {
    fn follow<'a>(&mut self, rows: impl Iterator<Item = (Entity, &'a GlobalTransform, &'a MeshRenderer, bool)>) {
        let before: Vec<Entity> = self.instances.iter().map(|instance| instance.entity).collect();
        self.instances.clear();
        self.boxes.clear();
        for (entity, place, renderer, is_ghost) in rows {
            let mesh = &renderer.mesh;
            let world_from_object = place.0;
            let object_from_world = world_from_object.inverse();
            // A flattened object has no inside to ask in; it is met by nothing.
            let is_usable = world_from_object.is_finite() && object_from_world.is_finite();
            self.boxes.push(if is_usable { mesh.bounds.transformed(&world_from_object) } else { Aabb::EMPTY });
            self.instances.push(Instance {
                entity,
                world_from_object,
                object_from_world,
                is_ghost,
                casts_shadow: renderer.casts_shadow,
                mesh: mesh.clone(),
            });
        }
        let same = before.iter().copied().eq(self.instances.iter().map(|instance| instance.entity));
        let placed = self.boxes.iter().filter(|bounds| !bounds.is_empty()).count();
        match same && placed == self.top.order.len() && self.boxes.len() == before.len() {
            true => self.top.refit(&self.boxes),
            false => self.top = Bvh::new(&self.boxes, 2),
        }
    }
}
