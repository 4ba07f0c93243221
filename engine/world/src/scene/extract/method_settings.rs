//! The settings of a game's methods of indirect light.

use super::context::Context;
use crate::scene::Scene;
use crate::world::{MethodSettingsTypes, SettingsReader};
use bevy_ecs::prelude::World;

/// Readers of the settings that the world knows. They are few: each is compared in every frame.
#[derive(Default)]
pub(super) struct MethodSettingsReaders {
    readers: Vec<Box<dyn SettingsReader>>,
}

impl MethodSettingsReaders {
    pub fn extract(&mut self, world: &mut World, scene: &mut Scene, context: &mut Context) {
        let Some(types) = world.get_resource::<MethodSettingsTypes>().filter(|types| !types.is_empty()) else { return };
        if types.count() != self.readers.len() {
            self.readers = types.clone().readers(world);
        }
        let mut has_changed = false;
        for reader in &mut self.readers {
            has_changed |= reader.update(world, &mut scene.method_settings);
        }
        if has_changed {
            scene.revisions.methods = context.revisions.next();
        }
    }
}
