//! Undo and redo: what was done, in pieces that can be taken back bit by bit.

use super::stage::Stage;
use anyhow::{Result, anyhow};
use lightwell::files::{SceneFile, describe_scene, edit_scene};
use lightwell::scene::SceneId;
use lightwell::world::{EntitySnapshot, GameWorld};

/// Most steps that are remembered.
const MOST: usize = 500;

/// Where an entity stands among others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Seat {
    /// Its parent.
    pub parent: Option<SceneId>,
    /// Its number among the parent's children.
    pub index: usize,
}

impl Seat {
    /// The seat of an entity.
    pub fn of(world: &GameWorld, id: SceneId) -> Self {
        let Some(entity) = world.entity(id) else { return Self { parent: None, index: 0 } };
        let parent = world.parent(entity);
        let siblings = parent.map_or_else(Vec::new, |parent| world.children(parent));
        let index = siblings.iter().position(|sibling| *sibling == entity).unwrap_or(0);
        Self { parent: parent.and_then(|parent| world.id(parent)), index }
    }
}

/// One change that can be made and taken back.
#[derive(Debug)]
pub enum Change {
    /// Components of an entity.
    Components {
        /// Whose.
        id: SceneId,
        /// Before.
        before: EntitySnapshot,
        /// After.
        after: EntitySnapshot,
    },
    /// An entity came, with all below it.
    Came(Existence),
    /// An entity went, with all below it.
    Went(Existence),
    /// An entity was given another parent.
    Moved {
        /// Which.
        id: SceneId,
        /// Before.
        before: Seat,
        /// After.
        after: Seat,
    },
    /// What belongs to the scene as a whole.
    Scene(Box<SceneFile>, Box<SceneFile>),
}

/// An entity that may be there or not.
#[derive(Clone, Copy, Debug)]
pub struct Existence {
    /// Which.
    pub id: SceneId,
    /// The entity with all below it.
    pub snapshot: EntitySnapshot,
    /// Where it stands.
    pub seat: Seat,
}

impl Existence {
    /// Of a living entity.
    ///
    /// # Errors
    /// If there is none.
    pub fn of(world: &mut GameWorld, id: SceneId) -> Result<Self> {
        let entity = world.entity(id).ok_or_else(|| anyhow!("the entity is gone"))?;
        Ok(Self { id, snapshot: world.snapshot(entity, true)?, seat: Seat::of(world, id) })
    }

    fn come(&self, world: &mut GameWorld) -> Result<()> {
        let parent = self.seat.parent.and_then(|id| world.entity(id));
        world.put_back(self.snapshot, parent, self.seat.index)?;
        Ok(())
    }

    fn go(&self, world: &mut GameWorld) {
        if let Some(entity) = world.entity(self.id) {
            world.ecs.despawn(entity);
        }
    }
}

impl Change {
    fn apply(&self, stage: &mut Stage, forth: bool) -> Result<()> {
        let world = &mut *stage.world;
        match self {
            Self::Components { id, before, after } => {
                let entity = world.entity(*id).ok_or_else(|| anyhow!("the entity is gone"))?;
                world.copy_from_snapshot(if forth { *after } else { *before }, entity)?;
            }
            Self::Came(existence) if forth => existence.come(world)?,
            Self::Went(existence) if !forth => existence.come(world)?,
            Self::Came(existence) | Self::Went(existence) => existence.go(world),
            Self::Moved { id, before, after } => seat(world, *id, if forth { after } else { before })?,
            Self::Scene(before, after) => {
                let wanted = if forth { after } else { before };
                edit_scene(stage.world, &mut stage.files.context(), wanted)?;
                stage.clock.follow(&wanted.settings);
            }
        }
        Ok(())
    }

    /// The change that brings back what this one is about to change; none where it finds nothing to change.
    ///
    /// # Errors
    /// If an entity of it is gone.
    fn inverse(&self, world: &mut GameWorld, forth: bool) -> Result<Option<Self>> {
        Ok(Some(match self {
            Self::Components { id, .. } => {
                let entity = world.entity(*id).ok_or_else(|| anyhow!("the entity is gone"))?;
                let now = world.snapshot(entity, false)?;
                Self::Components { id: *id, before: now, after: now }
            }
            Self::Came(existence) | Self::Went(existence) => {
                let comes = matches!(self, Self::Came(_)) == forth;
                match (comes, world.entity(existence.id)) {
                    // Taking it away again needs no copy of its own.
                    (true, _) => Self::Came(*existence),
                    (false, Some(_)) => Self::Went(Existence::of(world, existence.id)?),
                    (false, None) => return Ok(None),
                }
            }
            Self::Moved { id, .. } => {
                let now = Seat::of(world, *id);
                Self::Moved { id: *id, before: now, after: now }
            }
            Self::Scene(..) => {
                let now = Box::new(describe_scene(world));
                Self::Scene(now.clone(), now)
            }
        }))
    }

    /// Lets go of the copies that [`Change::inverse`] made.
    fn drop_inverse(&self, world: &mut GameWorld) {
        if !matches!(self, Self::Came(_)) {
            self.drop(world);
        }
    }

    fn drop(&self, world: &mut GameWorld) {
        match self {
            Self::Components { before, after, .. } => {
                world.drop_snapshot(*before);
                world.drop_snapshot(*after);
            }
            Self::Came(existence) | Self::Went(existence) => world.drop_snapshot(existence.snapshot),
            Self::Moved { .. } | Self::Scene(..) => {}
        }
    }
}

/// Puts an entity in a seat; its transform stays as it is.
///
/// # Errors
/// If the parent stands below the entity, or one of them is gone.
pub fn seat(world: &mut GameWorld, id: SceneId, seat: &Seat) -> Result<()> {
    let entity = world.entity(id).ok_or_else(|| anyhow!("the entity is gone"))?;
    let parent = seat.parent.and_then(|id| world.entity(id));
    world.set_parent(entity, parent)?;
    if let Some(parent) = parent {
        let index = seat.index.min(world.children(parent).len().saturating_sub(1));
        world.ecs.entity_mut(parent).insert_children(index, &[entity]);
    }
    Ok(())
}

/// A step of undo.
#[derive(Debug)]
struct Step {
    label: String,
    changes: Vec<Change>,
}

impl Step {
    /// Applies all changes, or takes them back.
    ///
    /// # Errors
    /// If one of them cannot be applied; those before it are taken back then.
    fn apply(&self, stage: &mut Stage, forth: bool) -> Result<()> {
        let mut inverses = Vec::new();
        let mut result = Ok(());
        for at in 0..self.changes.len() {
            let change = &self.changes[if forth { at } else { self.changes.len() - 1 - at }];
            let inverse = match change.inverse(stage.world, forth) {
                Ok(inverse) => inverse,
                Err(error) => {
                    result = Err(error);
                    break;
                }
            };
            result = change.apply(stage, forth);
            if result.is_err() {
                inverse.iter().for_each(|inverse| inverse.drop_inverse(stage.world));
                break;
            }
            inverses.extend(inverse);
        }
        let result = result.map_err(|error| self.roll_back(stage, &inverses, error));
        inverses.iter().for_each(|inverse| inverse.drop_inverse(stage.world));
        result
    }

    /// Takes back what was applied, the last first; gives the error to show.
    fn roll_back(&self, stage: &mut Stage, inverses: &[Change], error: anyhow::Error) -> anyhow::Error {
        for inverse in inverses.iter().rev() {
            if let Err(second) = inverse.apply(stage, false) {
                let what = format!("`{}` is half applied, since it could not be rolled back ({second:#})", self.label);
                return error.context(what);
            }
        }
        error.context(format!("`{}` changes nothing", self.label))
    }
}

/// An edit that goes on, such as a drag.
#[derive(Debug)]
struct Open {
    label: String,
    before: Vec<(SceneId, EntitySnapshot)>,
    scene: Option<Box<SceneFile>>,
}

/// What was done and what was undone.
#[derive(Debug, Default)]
pub struct History {
    done: Vec<Step>,
    undone: Vec<Step>,
    open: Option<Open>,
    /// Number of steps done when the scene was saved; none if that state cannot be reached any more.
    saved: Option<usize>,
    /// Changes with every edit.
    pub version: u64,
}

impl History {
    /// Of a scene as it was loaded.
    pub fn new() -> Self {
        Self { saved: Some(0), ..Self::default() }
    }

    /// Whether there is something that no file holds.
    pub fn is_dirty(&self) -> bool {
        self.open.is_some() || self.saved != Some(self.done.len())
    }

    /// The present state was saved.
    pub fn mark_saved(&mut self) {
        self.saved = Some(self.done.len());
    }

    /// What undo would take back.
    pub fn undo_label(&self) -> Option<&str> {
        self.done.last().map(|step| step.label.as_str())
    }

    /// What redo would do again.
    pub fn redo_label(&self) -> Option<&str> {
        self.undone.last().map(|step| step.label.as_str())
    }

    /// Whether an edit goes on.
    pub fn is_open(&self) -> bool {
        self.open.is_some()
    }

    /// Begins an edit of entities, or goes on with the one of that label; [`History::close`] ends it.
    ///
    /// # Errors
    /// If an entity is gone.
    pub fn open(&mut self, stage: &mut Stage, label: &str, ids: &[SceneId]) -> Result<()> {
        self.version += 1;
        let goes_on = self.open.as_ref().is_some_and(|open| open.label == label && open.scene.is_none());
        if !goes_on {
            self.close(stage.world)?;
        }
        let open = self.open.get_or_insert_with(|| Open { label: label.to_owned(), before: Vec::new(), scene: None });
        for id in ids.iter().filter(|id| !open.before.iter().any(|(known, _)| known == *id)).collect::<Vec<_>>() {
            let entity = stage.world.entity(*id).ok_or_else(|| anyhow!("the entity is gone"))?;
            open.before.push((*id, stage.world.snapshot(entity, false)?));
        }
        Ok(())
    }

    /// Begins an edit of the scene as a whole, or goes on with it.
    ///
    /// # Errors
    /// If the edit before cannot be ended.
    pub fn open_scene(&mut self, stage: &mut Stage, label: &str) -> Result<()> {
        self.version += 1;
        if self.open.as_ref().is_some_and(|open| open.label == label && open.scene.is_some()) {
            return Ok(());
        }
        self.close(stage.world)?;
        let scene = Some(Box::new(describe_scene(stage.world)));
        self.open = Some(Open { label: label.to_owned(), before: Vec::new(), scene });
        Ok(())
    }

    /// Ends the edit that goes on: it is one step from now on.
    ///
    /// # Errors
    /// If an entity of it is gone.
    pub fn close(&mut self, world: &mut GameWorld) -> Result<()> {
        let Some(open) = self.open.take() else { return Ok(()) };
        let mut changes = Vec::new();
        if let Some(before) = open.scene {
            let after = describe_scene(world);
            if *before != after {
                changes.push(Change::Scene(before, Box::new(after)));
            }
        }
        for (id, before) in open.before {
            let Some(entity) = world.entity(id) else { continue };
            let after = world.snapshot(entity, false)?;
            changes.push(Change::Components { id, before, after });
        }
        if !changes.is_empty() {
            self.push(world, &open.label, changes);
        }
        Ok(())
    }

    /// Adds what was done at once.
    pub fn push(&mut self, world: &mut GameWorld, label: &str, changes: Vec<Change>) {
        self.version += 1;
        for step in self.undone.drain(..) {
            step.changes.iter().for_each(|change| change.drop(world));
        }
        if self.saved.is_some_and(|saved| saved > self.done.len()) {
            self.saved = None;
        }
        self.done.push(Step { label: label.to_owned(), changes });
        if self.done.len() > MOST {
            let oldest = self.done.remove(0);
            oldest.changes.iter().for_each(|change| change.drop(world));
            self.saved = self.saved.and_then(|saved| saved.checked_sub(1));
        }
    }

    /// Goes on with the last step, as a drag does: entities that came by it come as they are now.
    pub fn go_on(&mut self, world: &mut GameWorld, changes: Vec<Change>) {
        self.version += 1;
        let Some(step) = self.done.last_mut() else { return };
        for change in changes {
            let known = step.changes.iter_mut().find_map(|known| match (known, &change) {
                (Change::Came(known), Change::Came(now)) if known.id == now.id => Some(known),
                _ => None,
            });
            match (known, change) {
                (Some(known), Change::Came(now)) => world.drop_snapshot(std::mem::replace(known, now).snapshot),
                // What went by the step went at its begin.
                (_, change) => change.drop(world),
            }
        }
    }

    /// Calls `work` with each description of the scene as a whole that undo or redo brings back.
    pub fn for_each_scene(&mut self, work: &mut impl FnMut(&mut SceneFile) -> Result<()>) -> Result<()> {
        let steps = self.done.iter_mut().chain(&mut self.undone);
        for change in steps.flat_map(|step| &mut step.changes) {
            if let Change::Scene(before, after) = change {
                work(before)?;
                work(after)?;
            }
        }
        match self.open.as_mut().and_then(|open| open.scene.as_mut()) {
            Some(scene) => work(scene),
            None => Ok(()),
        }
    }

    /// Takes the last step back; says which.
    ///
    /// # Errors
    /// If a change of it cannot be taken back; world and history stay as they are then.
    pub fn undo(&mut self, stage: &mut Stage) -> Result<Option<String>> {
        self.close(stage.world)?;
        let Some(step) = self.done.last() else { return Ok(None) };
        step.apply(stage, false)?;
        let label = step.label.clone();
        self.undone.extend(self.done.pop());
        self.version += 1;
        Ok(Some(label))
    }

    /// Does the last step again that was taken back; says which.
    ///
    /// # Errors
    /// If a change of it cannot be done; world and history stay as they are then.
    pub fn redo(&mut self, stage: &mut Stage) -> Result<Option<String>> {
        self.close(stage.world)?;
        let Some(step) = self.undone.last() else { return Ok(None) };
        step.apply(stage, true)?;
        let label = step.label.clone();
        self.done.extend(self.undone.pop());
        self.version += 1;
        Ok(Some(label))
    }
}
