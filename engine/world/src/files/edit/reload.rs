//! A scene's file that changes while its world runs: what differs between two versions of the file is changed in the
//! world, and leaves all else as it is.

use super::context::EditContext;
use super::entity::{edit_entity, spawn_entity};
use super::scene::edit_scene;
use crate::files::error::{FileError, FileErrorKind as Kind};
use crate::files::format::scene_file::{EntityFile, OverrideFile, SceneFile};
use crate::files::format::validate::Validator;
use crate::files::load::loader::canonical_scene;
use crate::files::load::options::LoadOptions;
use crate::files::ron::document::{Document, ron_options};
use crate::files::ron::merge::merged;
use crate::files::ron::steps::fault_error;
use crate::files::ron::tree::Node;
use crate::files::save::describe::{describe_entity, describe_scene};
use crate::world::GameWorld;
use bevy_ecs::prelude::Entity;
use std::path::Path;

/// The contents of a scene file, with custom components as the game would write them.
///
/// # Errors
/// When there is no such file, or it is wrong in itself. Assets are not looked at.
pub fn read_scene(path: &Path, options: &LoadOptions) -> Result<SceneFile, FileError> {
    let (document, mut file) = Document::read::<SceneFile>(path)?;
    Validator::scene(&file).map_err(|fault| fault_error(&document, *fault))?;
    canonical_scene(&document, &mut file, &options.types)?;
    Ok(file)
}

/// Makes in a world what changed between two versions of its scene file. Entities are told by their paths. Fields of
/// components that the file changed get the file's values; those that it did not keep what they have become. Entities
/// that the world has lost since are not brought back.
///
/// # Errors
/// When the world or the file holds what cannot be described, before anything changes; or when an asset is missing or
/// faulty, and what was changed before stays changed then.
pub fn follow_scene(
    world: &mut GameWorld,
    context: &mut EditContext,
    before: &SceneFile,
    now: &SceneFile,
) -> Result<(), FileError> {
    let mut plan = Plan { world, path: context.path, steps: Vec::new() };
    plan.siblings(None, &before.entities, &now.entities)?;
    let steps = plan.steps;
    let present = describe_scene(world);
    let settings = if now.settings == before.settings { present.settings } else { now.settings.clone() };
    edit_scene(world, context, &SceneFile { settings, entities: Vec::new(), ..now.clone() })?;
    steps.into_iter().try_for_each(|step| step.apply(world, context))
}

/// A change of the world that the file asks for.
enum Change<'a> {
    Despawn(Entity),
    Spawn { parent: Option<Entity>, file: &'a EntityFile },
    Edit(Entity, Box<OverrideFile>),
}

impl Change<'_> {
    fn apply(self, world: &mut GameWorld, context: &mut EditContext) -> Result<(), FileError> {
        match self {
            Self::Despawn(entity) => {
                crate::world::despawn(&mut world.ecs, entity);
                Ok(())
            }
            Self::Spawn { parent, file } => spawn_entity(world, context, parent, file).map(drop),
            Self::Edit(entity, wanted) => edit_entity(world, context, entity, &wanted),
        }
    }
}

/// Everything that is to change, in order.
struct Plan<'w, 'f> {
    world: &'w GameWorld,
    path: &'w Path,
    steps: Vec<Change<'f>>,
}

impl<'f> Plan<'_, 'f> {
    fn siblings(
        &mut self,
        parent: Option<Entity>,
        before: &[EntityFile],
        now: &'f [EntityFile],
    ) -> Result<(), FileError> {
        for gone in before.iter().filter(|old| named(now, &old.name).is_none()) {
            self.steps.extend(self.child(parent, &gone.name).map(Change::Despawn));
        }
        for new in now {
            match (named(before, &new.name), self.child(parent, &new.name)) {
                (Some(old), Some(entity)) if old != new => self.entity(parent, entity, old, new)?,
                (None, None) => self.steps.push(Change::Spawn { parent, file: new }),
                // The same as before; or despawned or made by the game, whose word counts then.
                _ => {}
            }
        }
        Ok(())
    }

    fn child(&self, parent: Option<Entity>, name: &str) -> Option<Entity> {
        let siblings = parent.map_or_else(|| self.world.roots(), |parent| self.world.children(parent));
        siblings.into_iter().find(|entity| self.world.name(*entity) == name)
    }

    fn entity(
        &mut self,
        parent: Option<Entity>,
        entity: Entity,
        old: &EntityFile,
        new: &'f EntityFile,
    ) -> Result<(), FileError> {
        let instance = |file: &EntityFile| (file.prefab.clone(), file.repeat.clone(), file.overrides.clone());
        if instance(old) != instance(new) {
            // Another prefab, or another form of it, is another thing.
            self.steps.extend([Change::Despawn(entity), Change::Spawn { parent, file: new }]);
            return Ok(());
        }
        let (before, now) = (old.components(), new.components());
        if before != now {
            let present = describe_entity(self.world, entity, self.path)?;
            self.steps.push(Change::Edit(entity, Box::new(self.merged(&before, &now, &present)?)));
        }
        self.siblings(Some(entity), &old.children, &new.children)
    }

    fn merged(
        &self,
        before: &OverrideFile,
        now: &OverrideFile,
        present: &OverrideFile,
    ) -> Result<OverrideFile, FileError> {
        let fault = |what: String| FileError::new(self.path, Kind::BadValue, what);
        let node = |components: &OverrideFile| {
            ron_options().to_string(components).map(|text| Node::parse(&text)).map_err(|error| fault(error.to_string()))
        };
        let text = merged(&node(before)?, &node(now)?, &node(present)?).compact();
        ron_options().from_str(&text).map_err(|error| fault(error.code.to_string()))
    }
}

fn named<'a>(entities: &'a [EntityFile], name: &str) -> Option<&'a EntityFile> {
    entities.iter().find(|entity| entity.name == name)
}
