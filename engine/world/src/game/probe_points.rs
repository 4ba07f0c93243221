//! Where a game has light measured, and what was found there.

use super::light::LightProbe;
use super::running::Game;
use crate::scene::ProbePoint;
use crate::world::{GameWorld, GlobalTransform, Identity};
use bevy_ecs::prelude::*;
use glam::{DVec3, Vec3};

impl Game {
    /// The points whose indirect light the renderer is to look up, in an order that stays, from the
    /// [origin](crate::scene::Scene::origin) of the scene that it draws.
    pub fn probe_points(&self, origin: DVec3) -> Vec<ProbePoint> {
        let found = probes(&self.world).into_iter();
        found
            .map(|(_, _, probe, place)| ProbePoint {
                position: Vec3::from(place.relative_to(origin).translation) + probe.offset,
                normal: probe.normal,
            })
            .collect()
    }

    /// Takes what the renderer found at [`Game::probe_points`](Self::probe_points) of the frame before.
    pub fn set_probe_light(&mut self, light: &[Vec3]) {
        self.set_probe_light_of(&self.probe_entities(), light);
    }

    /// The probes in the order of [`Game::probe_points`](Self::probe_points).
    pub fn probe_entities(&self) -> Vec<Entity> {
        probes(&self.world).into_iter().map(|(entity, ..)| entity).collect()
    }

    /// Takes the light of those probes, as of some frame before. Probes that are gone since then are passed over.
    pub fn set_probe_light_of(&mut self, entities: &[Entity], light: &[Vec3]) {
        for (&entity, light) in entities.iter().zip(light) {
            if let Some(mut probe) = self.world.ecs.get_mut::<LightProbe>(entity)
                && probe.indirect != *light
            {
                probe.indirect = *light;
            }
        }
    }
}

fn probes(world: &GameWorld) -> Vec<(Entity, Identity, LightProbe, GlobalTransform)> {
    let Some(mut query) = world.ecs.try_query::<(Entity, &Identity, &LightProbe, &GlobalTransform)>() else {
        return Vec::new();
    };
    let mut found: Vec<_> = query.iter(&world.ecs).map(|(e, id, probe, place)| (e, *id, *probe, *place)).collect();
    found.sort_unstable_by_key(|(_, id, ..)| *id);
    found
}
