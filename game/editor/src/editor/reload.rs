//! The scene's file read anew: a step of the history like any other, so that what was done before can still be undone,
//! and what the file took away can be brought back.

use super::Editor;
use super::history::{Change, Existence};
use anyhow::Result;
use lightwell::files::{SceneFile, describe_scene};
use lightwell::world::GameWorld;

/// The scene before its file was read anew.
pub struct Before {
    roots: Vec<Existence>,
    scene: Box<SceneFile>,
}

impl Editor {
    /// Keeps what the scene is, before its file is read anew.
    ///
    /// # Errors
    /// If an entity cannot be copied.
    pub fn before_reload(&mut self, world: &mut GameWorld) -> Result<Before> {
        self.history.close(world)?;
        Ok(Before { roots: existences(world)?, scene: Box::new(describe_scene(world)) })
    }

    /// The file was read anew into the same world, and entities kept their identities.
    ///
    /// # Errors
    /// If an entity cannot be copied.
    pub fn reloaded(&mut self, world: &mut GameWorld, before: Before) -> Result<()> {
        let mut changes: Vec<Change> = before.roots.into_iter().map(Change::Went).collect();
        changes.push(Change::Scene(before.scene, Box::new(describe_scene(world))));
        changes.extend(existences(world)?.into_iter().map(Change::Came));
        self.history.push(world, "load the file", changes);
        self.history.mark_saved();
        self.problem = None;
        self.view.drag = None;
        Ok(())
    }

    /// The file could not be read: all is as it was.
    pub fn not_reloaded(&mut self, world: &mut GameWorld, before: Before) {
        before.roots.iter().for_each(|root| world.drop_snapshot(root.snapshot));
    }
}

fn existences(world: &mut GameWorld) -> Result<Vec<Existence>> {
    let roots = world.roots();
    let ids: Vec<_> = roots.into_iter().filter_map(|root| world.id(root)).collect();
    ids.into_iter().map(|id| Existence::of(world, id)).collect()
}
