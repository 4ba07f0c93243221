//! The settings of stochastic light culling.

use super::context::{Context, Part, name_or_id};
use crate::scene::Scene;
use crate::world::{Identity, Name, StochasticLightCulling};
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemState;

type Row = (Entity, &'static Identity, Option<&'static Name>, &'static StochasticLightCulling);

/// Looks for the settings in every frame: there are few.
pub(super) struct LightCullings {
    state: SystemState<Query<'static, 'static, Row>>,
}

impl LightCullings {
    pub fn new(world: &mut World) -> Self {
        Self { state: SystemState::new(world) }
    }

    pub fn extract(&mut self, world: &mut World, scene: &mut Scene, context: &mut Context) {
        let Ok(all) = self.state.get_mut(world) else { return };
        context.log.begin_all(Part::Slc);
        let first = all.iter().min_by_key(|(_, identity, ..)| **identity);
        scene.settings_names.slc = first.map_or_else(String::new, |(entity, _, name, _)| name_or_id(entity, name));
        scene.slc = first.map(|(entity, _, name, settings)| {
            let sanitized = settings.sanitized();
            if sanitized != *settings {
                let message = "has light culling settings out of range; the nearest ones in range are used";
                context.log.warn(entity, Part::Slc, name, message);
            }
            sanitized
        });
    }
}
