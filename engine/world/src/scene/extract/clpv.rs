//! The settings of the light propagation volumes.

use super::context::{Context, Part, name_or_id};
use crate::scene::{Scene, SceneClpv};
use crate::world::{Bounces, CellSize, Clpv, ClpvPlacement, GatherRays, GlobalTransform, Identity, Name};
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemState;

type Row = (Entity, &'static Identity, Option<&'static Name>, &'static GlobalTransform, &'static Clpv);
type IsChanged = (With<Clpv>, Or<(Changed<GlobalTransform>, Changed<Clpv>, Added<Identity>)>);
type Params = (
    Query<'static, 'static, (), IsChanged>,
    Query<'static, 'static, Row>,
    RemovedComponents<'static, 'static, Clpv>,
    RemovedComponents<'static, 'static, GlobalTransform>,
);

/// The state of the world's volumes as of the last extraction. They are few: any change checks all.
pub(super) struct Clpvs {
    state: SystemState<Params>,
}

impl Clpvs {
    pub fn new(world: &mut World) -> Self {
        Self { state: SystemState::new(world) }
    }

    pub fn extract(&mut self, world: &mut World, scene: &mut Scene, context: &mut Context) {
        let Ok((changed, all, mut no_clpv, mut no_place)) = self.state.get_mut(world) else { return };
        let is_removed = no_clpv.read().chain(no_place.read()).count() > 0;
        if changed.is_empty() && !is_removed && !context.is_late {
            return;
        }
        context.log.begin_all(Part::Clpv);
        let mut rows: Vec<_> = all.iter().collect();
        rows.sort_unstable_by_key(|(_, identity, ..)| **identity);
        let first = rows.into_iter().find(|(entity, _, name, place, _)| {
            if !place.0.is_finite() {
                context.log.warn(
                    *entity,
                    Part::Clpv,
                    *name,
                    "holds volumes that are not used: its place in the world is not finite",
                );
            }
            place.0.is_finite()
        });
        scene.settings_names.clpv = first.map_or_else(String::new, |(entity, _, name, ..)| name_or_id(entity, name));
        let clpv = first.map(|(entity, _, name, place, clpv)| {
            let settings = sanitized(clpv);
            if settings != *clpv {
                let message = "has volume settings out of range; the nearest ones in range are used";
                context.log.warn(entity, Part::Clpv, name, message);
            }
            SceneClpv { settings, center: place.relative_to(scene.origin).translation.into() }
        });
        if clpv != scene.clpv {
            scene.clpv = clpv;
            scene.revisions.clpv = context.revisions.next();
        }
    }
}

fn at_most_sixteen(rays: GatherRays) -> GatherRays {
    match rays {
        GatherRays::Auto => GatherRays::Auto,
        GatherRays::Count(count) => GatherRays::Count(count.min(16)),
        GatherRays::Paths(count) => GatherRays::Paths(count.clamp(1, 16)),
    }
}

fn without_paths(rays: GatherRays) -> GatherRays {
    match at_most_sixteen(rays) {
        GatherRays::Paths(_) => GatherRays::Auto,
        rays => rays,
    }
}

/// Settings in the ranges that [`Clpv`] names; the default for numbers that are not finite.
fn sanitized(clpv: &Clpv) -> Clpv {
    let default = Clpv::default();
    let positive = |value: f32, default: f32| if value.is_finite() { value.max(0.0) } else { default };
    Clpv {
        placement: match clpv.placement {
            ClpvPlacement::Fixed => ClpvPlacement::Fixed,
            ClpvPlacement::Camera { ahead } => ClpvPlacement::Camera { ahead: positive(ahead, 0.0).min(1.0) },
        },
        cascades: clpv.cascades.clamp(1, 4),
        gather_rays: at_most_sixteen(clpv.gather_rays),
        gather_points: without_paths(clpv.gather_points),
        mirror_rays: without_paths(clpv.mirror_rays),
        gather_filter: clpv.gather_filter.min(32),
        cells: clpv.cells.map(|n| n.clamp(1, 128)),
        cell_size: match clpv.cell_size {
            CellSize::Meters(size) if size.is_finite() && size > 0.0 => clpv.cell_size,
            _ => CellSize::Auto,
        },
        bounces: match clpv.bounces {
            Bounces::Converged => Bounces::Converged,
            Bounces::Count(count) => Bounces::Count(count.clamp(1, 32)),
        },
        steps: clpv.steps.min(1024),
        blocker_scale: positive(clpv.blocker_scale, default.blocker_scale),
        gain: positive(clpv.gain, default.gain),
        border_fade: positive(clpv.border_fade, default.border_fade),
        outside_fade: positive(clpv.outside_fade, default.outside_fade),
        gradient_damping: positive(clpv.gradient_damping, default.gradient_damping).min(1e6),
        ambient_occlusion: positive(clpv.ambient_occlusion, default.ambient_occlusion).min(1e6),
        rsm_samples: clpv.rsm_samples.min(65_536),
        ..clpv.clone()
    }
}
