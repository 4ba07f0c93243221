//! Primitives: places, meshes and materials.

use super::context::{Context, Part};
use super::motion::{Drivers, Motion, is_driven};
use super::sorted::Elements;
use crate::scene::{Primitive, Scene};
use crate::world::{GlobalTransform, Identity, MeshRenderer, Name};
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemState;
use glam::Affine3A;
use std::sync::Arc;

type Row = (Entity, &'static Identity, Option<&'static Name>, &'static GlobalTransform, &'static MeshRenderer);
type IsChanged = Or<(Changed<GlobalTransform>, Changed<MeshRenderer>, Added<Identity>)>;
type Params = (
    Query<'static, 'static, Row, IsChanged>,
    Query<'static, 'static, (), (With<MeshRenderer>, With<GlobalTransform>)>,
    RemovedComponents<'static, 'static, MeshRenderer>,
    RemovedComponents<'static, 'static, GlobalTransform>,
    Query<'static, 'static, Drivers>,
);

/// The state of the world's primitives as of the last extraction.
pub(super) struct Primitives {
    state: SystemState<Params>,
    elements: Elements<Primitive>,
    motion: Motion,
}

impl Primitives {
    pub fn new(world: &mut World) -> Self {
        Self { state: SystemState::new(world), elements: Elements::default(), motion: Motion::default() }
    }

    pub fn extract(&mut self, world: &mut World, scene: &mut Scene, context: &mut Context) {
        let Ok((changed, living, mut no_mesh, mut no_place, drivers)) = self.state.get_mut(world) else { return };
        let (elements, motion) = (&mut self.elements, &mut self.motion);
        motion.begin();
        let mut has_begun_to_move = false;
        let mut gone: Vec<Entity> = no_mesh.read().chain(no_place.read()).filter(|e| !living.contains(*e)).collect();
        if context.is_late {
            gone.extend(elements.entities().filter(|e| !living.contains(*e)));
        }
        for entity in gone {
            elements.remove(entity);
            context.log.forget(entity, Part::Primitive);
        }
        for (entity, identity, name, place, renderer) in &changed {
            let place = &place.relative_to(scene.origin);
            context.log.begin(entity, Part::Primitive);
            let is_finite = place.is_finite();
            if !is_finite {
                context.log.warn(entity, Part::Primitive, name, "is not drawn: its place in the world is not finite");
            }
            if !is_finite || !renderer.visible {
                elements.remove(entity);
            } else if let Some(primitive) = elements.get(&mut scene.primitives, entity) {
                let revisions = &mut scene.revisions;
                let before = (primitive.geometry_revision, primitive.material_revision);
                if change_geometry(primitive, place, renderer) {
                    primitive.geometry_revision = context.revisions.next();
                    revisions.geometry = primitive.geometry_revision;
                }
                if !Arc::ptr_eq(&primitive.material, &renderer.material) {
                    primitive.material = renderer.material.clone();
                    primitive.material_revision = context.revisions.next();
                    revisions.materials = primitive.material_revision;
                }
                if before != (primitive.geometry_revision, primitive.material_revision) {
                    has_begun_to_move |= motion.touch(primitive);
                }
            } else {
                let revision = context.revisions.next();
                let mut new = primitive(identity, place, renderer, revision);
                if is_driven(entity, &drivers) {
                    motion.drive(&mut new);
                }
                elements.add(entity, new);
                scene.revisions.materials = revision;
            }
        }
        let are_others = elements.apply(&mut scene.primitives);
        if are_others {
            scene.revisions.geometry = context.revisions.next();
        }
        if are_others || has_begun_to_move {
            motion.settle(&mut scene.primitives);
            scene.revisions.statics = context.revisions.next();
        }
    }
}

fn primitive(identity: &Identity, place: &Affine3A, renderer: &MeshRenderer, revision: u64) -> Primitive {
    Primitive {
        id: identity.id(),
        mesh: renderer.mesh.clone(),
        material: renderer.material.clone(),
        world_from_object: *place,
        bounds: renderer.mesh.bounds.transformed(place),
        casts_shadow: renderer.casts_shadow,
        moving: false,
        geometry_revision: revision,
        material_revision: revision,
    }
}

/// True if place, mesh or shadow casting differ.
fn change_geometry(primitive: &mut Primitive, place: &Affine3A, renderer: &MeshRenderer) -> bool {
    let bits = |m: &glam::Affine3A| m.to_cols_array().map(f32::to_bits);
    if bits(&primitive.world_from_object) == bits(place)
        && Arc::ptr_eq(&primitive.mesh, &renderer.mesh)
        && primitive.casts_shadow == renderer.casts_shadow
    {
        return false;
    }
    primitive.world_from_object = *place;
    primitive.mesh = renderer.mesh.clone();
    primitive.bounds = renderer.mesh.bounds.transformed(place);
    primitive.casts_shadow = renderer.casts_shadow;
    true
}
