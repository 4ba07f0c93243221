//! The settings of instant radiosity.

use super::context::{Context, Part, name_or_id};
use crate::scene::Scene;
use crate::world::{Bounces, Identity, InstantRadiosity, Name};
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemState;

type Row = (Entity, &'static Identity, Option<&'static Name>, &'static InstantRadiosity);
type IsChanged = (With<InstantRadiosity>, Or<(Changed<InstantRadiosity>, Added<Identity>)>);
type Params = (
    Query<'static, 'static, (), IsChanged>,
    Query<'static, 'static, Row>,
    RemovedComponents<'static, 'static, InstantRadiosity>,
);

/// The state of the world's settings as of the last extraction. They are few: any change checks all.
pub(super) struct Vpls {
    state: SystemState<Params>,
}

impl Vpls {
    pub fn new(world: &mut World) -> Self {
        Self { state: SystemState::new(world) }
    }

    pub fn extract(&mut self, world: &mut World, scene: &mut Scene, context: &mut Context) {
        let Ok((changed, all, mut removed)) = self.state.get_mut(world) else { return };
        if changed.is_empty() && removed.read().count() == 0 && !context.is_late {
            return;
        }
        context.log.begin_all(Part::Vpl);
        let first = all.iter().min_by_key(|(_, identity, ..)| **identity);
        scene.settings_names.vpl = first.map_or_else(String::new, |(entity, _, name, _)| name_or_id(entity, name));
        scene.vpl = first.map(|(entity, _, name, vpl)| {
            let settings = sanitized(vpl);
            if settings != *vpl {
                let message = "has settings of virtual lights out of range; the nearest ones in range are used";
                context.log.warn(entity, Part::Vpl, name, message);
            }
            settings
        });
    }
}

/// Settings in the ranges that [`InstantRadiosity`] names; the default for numbers that are not finite.
fn sanitized(vpl: &InstantRadiosity) -> InstantRadiosity {
    let default = InstantRadiosity::default();
    let positive = |value: f32, default: f32| if value.is_finite() { value.clamp(0.0, 1e3) } else { default };
    InstantRadiosity {
        particles: vpl.particles.max(1),
        bounces: match vpl.bounces {
            Bounces::Converged => Bounces::Converged,
            Bounces::Count(count) => Bounces::Count(count.clamp(1, 32)),
        },
        near_bound: positive(vpl.near_bound, default.near_bound),
        candidates: vpl.candidates.clamp(1, 64),
        near_rays: vpl.near_rays.min(16),
        near_filter: vpl.near_filter.min(32),
        shadow_bias: positive(vpl.shadow_bias, default.shadow_bias),
        shadow_slope_bias: positive(vpl.shadow_slope_bias, default.shadow_slope_bias),
        shadow_samples: vpl.shadow_samples.clamp(1, 64),
        shadow_offset: positive(vpl.shadow_offset, default.shadow_offset),
        ..vpl.clone()
    }
}
