//! How a world is set up, and what an update of it runs.

use super::fields::{self, FieldTypes};
use super::game_world::{DespawnQueue, GameWorld, UpdateCount};
use super::identity::{Identities, Identity, RootOrder, identify};
use super::{
    Animation, Camera, Clock, Clpv, Fog, Light, MeshRenderer, Name, Particles, SceneSettings, StochasticLightCulling,
    Transform, animate, deform, descendants, hierarchy, propagate,
};
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::ScheduleLabel;
use bevy_ecs::system::ScheduleSystem;

#[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
struct Behaviours;

#[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
struct Frame;

impl Default for GameWorld {
    fn default() -> Self {
        Self::new()
    }
}

impl GameWorld {
    /// An empty world at time zero with default settings.
    pub fn new() -> Self {
        let mut ecs = World::new();
        // Registered now, so that worlds can be queried by shared reference.
        ecs.register_component::<Identity>();
        ecs.register_component::<RootOrder>();
        ecs.register_component::<Name>();
        ecs.register_component::<Transform>();
        ecs.register_component::<ChildOf>();
        ecs.register_component::<Children>();
        ecs.register_component::<MeshRenderer>();
        ecs.register_component::<Light>();
        ecs.register_component::<Camera>();
        ecs.register_component::<Clpv>();
        ecs.register_component::<StochasticLightCulling>();
        ecs.register_component::<Fog>();
        ecs.register_component::<Particles>();
        ecs.register_component::<Animation>();
        ecs.init_resource::<Identities>();
        ecs.init_resource::<DespawnQueue>();
        ecs.init_resource::<UpdateCount>();
        ecs.init_resource::<SceneSettings>();
        ecs.init_resource::<FieldTypes>();
        ecs.init_resource::<fields::Wanted>();
        ecs.insert_resource(Clock::at_tick(0, SceneSettings::default().frame_rate));
        ecs.add_observer(hierarchy::refuse_cycles);
        let mut frame = Schedule::new(Frame);
        frame.add_systems(
            (
                identify,
                descendants::bind,
                animate::put_to_rest,
                animate::animate,
                fields::drive,
                propagate::propagate,
                deform::deform,
                despawn_queued,
            )
                .chain(),
        );
        Self { ecs, behaviours: Schedule::new(Behaviours), frame }
    }

    /// Adds systems of the game. They run at the start of every update, before animation.
    pub fn add_systems<M>(&mut self, systems: impl IntoScheduleConfigs<ScheduleSystem, M>) -> &mut Self {
        self.behaviours.add_systems(systems);
        self
    }

    /// One frame: behaviours, animation at the clock's time, transform propagation, deferred despawn.
    pub fn update(&mut self) {
        self.ecs.clear_trackers();
        self.ecs.resource_mut::<UpdateCount>().0 += 1;
        self.behaviours.run(&mut self.ecs);
        self.frame.run(&mut self.ecs);
    }
}

fn despawn_queued(world: &mut World) {
    for entity in std::mem::take(&mut world.resource_mut::<DespawnQueue>().0) {
        hierarchy::despawn(world, entity);
    }
}
