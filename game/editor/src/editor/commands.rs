//! Edits of the tree of entities, each one step of undo.

use super::Editor;
use super::history::{Change, Existence, Seat, seat};
use super::stage::Stage;
use anyhow::{Context, Result, anyhow};
use bevy_ecs::prelude::Entity;
use lightwell::files::{self, EntityFile, describe_entity, edit_entity, spawn_entity};
use lightwell::scene::SceneId;
use lightwell::world::{GameWorld, GlobalTransform, Name, Transform};
use std::path::Path;

/// What can be added by name: an entity as scene files write it.
pub const TEMPLATES: [(&str, &str); 19] = [
    ("Empty", "()"),
    ("Box", "(mesh:Box())"),
    ("Sphere", "(mesh:Sphere())"),
    ("Plane", "(mesh:Plane())"),
    ("Cylinder", "(mesh:Cylinder())"),
    ("Cone", "(mesh:Cone())"),
    ("Torus", "(mesh:Torus())"),
    ("Point light", "(light:(kind:Point,intensity:10.0))"),
    ("Spot light", "(light:(kind:Spot(inner:20.0,outer:30.0),intensity:20.0))"),
    ("Directional light", "(light:(kind:Directional,intensity:3.0))"),
    ("Sun", "(light:(kind:Sun(angle:0.53),intensity:3.0))"),
    ("Sphere light", "(light:(kind:Sphere(radius:0.1),intensity:10.0))"),
    ("Disc light", "(light:(kind:Disc(radius:0.3),intensity:10.0))"),
    ("Rectangle light", "(light:(kind:Rectangle(width:1.0,height:0.6),intensity:10.0))"),
    ("Tube light", "(light:(kind:Tube(length:1.2,radius:0.02),intensity:10.0))"),
    ("Camera", "(camera:())"),
    ("Light volume", "(clpv:())"),
    ("Fog", "(fog:(shape:Box(size:(4.0,2.0,4.0)),extinction:0.2))"),
    ("Particles", "(particles:())"),
];

impl Editor {
    /// The living entities that are selected.
    pub fn selected(&self, world: &GameWorld) -> Vec<(SceneId, Entity)> {
        self.selection.iter().filter_map(|id| Some((*id, world.entity(*id)?))).collect()
    }

    /// Those of the selection that stand below no other of it.
    fn selected_tops(&self, world: &GameWorld) -> Vec<(SceneId, Entity)> {
        let all = self.selected(world);
        let above = |e: Entity| std::iter::successors(world.parent(e), |e| world.parent(*e));
        let is_top = |e: Entity| !above(e).any(|parent| all.iter().any(|(_, other)| *other == parent));
        all.iter().copied().filter(|(_, e)| is_top(*e)).collect()
    }

    /// Adds an entity that a file describes below a parent, and selects it.
    ///
    /// # Errors
    /// If a value is wrong or an asset is missing.
    pub fn add(&mut self, stage: &mut Stage, parent: Option<SceneId>, mut file: EntityFile) -> Result<SceneId> {
        self.history.close(stage.world)?;
        let parent = parent.and_then(|id| stage.world.entity(id));
        file.name = stage.world.unique_name(parent, &file.name);
        let entity = spawn_entity(stage.world, &mut stage.files.context(), parent, &file)?;
        let id = stage.world.id(entity).context("the entity has no identity")?;
        let came = Change::Came(Existence::of(stage.world, id)?);
        self.history.push(stage.world, &format!("add {}", file.name), vec![came]);
        self.select_only(id);
        Ok(id)
    }

    /// Adds one of the templates before the camera.
    ///
    /// # Errors
    /// If it cannot be made.
    pub fn add_template(&mut self, stage: &mut Stage, parent: Option<SceneId>, name: &str, text: &str) -> Result<()> {
        let components: files::OverrideFile = files::ron_options().from_str(text)?;
        let mut file = EntityFile::with_components(name.to_owned(), components);
        if parent.is_none() {
            file.transform = Some(files::TransformFile { translation: self.place_ahead(stage), ..Default::default() });
        }
        self.add(stage, parent, file)?;
        Ok(())
    }

    /// Adds a model, or an instance of a prefab, from a file.
    ///
    /// # Errors
    /// If the file is neither, or cannot be loaded.
    pub fn add_file(&mut self, stage: &mut Stage, path: &Path) -> Result<()> {
        let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        let stem = name.split('.').next().unwrap_or("thing").replace(['_', '/'], " ");
        let written = relative_to(path, stage.files.path);
        let transform = Some(files::TransformFile { translation: self.place_ahead(stage), ..Default::default() });
        let mut file = EntityFile { name: stem, transform, ..Default::default() };
        let lower = name.to_lowercase();
        if lower.ends_with(".prefab.ron") {
            file.prefab = Some(written);
        } else if lower.ends_with(".gltf") || lower.ends_with(".glb") {
            file.model = Some(files::ModelFile::Path(written));
        } else {
            return Err(anyhow!("`{name}` is no .glb, .gltf or .prefab.ron file"));
        }
        self.add(stage, None, file)?;
        Ok(())
    }

    /// Takes the selection away, with all below it.
    ///
    /// # Errors
    /// If something of it is part of a model, which only its file can change.
    pub fn delete(&mut self, stage: &mut Stage) -> Result<()> {
        self.history.close(stage.world)?;
        let tops = self.selected_tops(stage.world);
        self.refuse_model_parts(stage.world, &tops)?;
        let mut changes = Vec::new();
        for (id, entity) in &tops {
            changes.push(Change::Went(Existence::of(stage.world, *id)?));
            stage.world.ecs.despawn(*entity);
        }
        self.selection.clear();
        if !changes.is_empty() {
            let label = format!("delete {}", counted(changes.len(), "entity", "entities"));
            self.history.push(stage.world, &label, changes);
        }
        Ok(())
    }

    /// Copies the selection, with all below it, beside itself; selects the copies.
    ///
    /// # Errors
    /// If something of it is part of a model.
    pub fn duplicate(&mut self, stage: &mut Stage) -> Result<()> {
        self.history.close(stage.world)?;
        let tops = self.selected_tops(stage.world);
        self.refuse_model_parts(stage.world, &tops)?;
        let (mut changes, mut copies) = (Vec::new(), Vec::new());
        for (_, entity) in tops {
            let copy = stage.world.clone_subtree(entity)?;
            let id = stage.world.id(copy).context("the copy has no identity")?;
            changes.push(Change::Came(Existence::of(stage.world, id)?));
            copies.push(id);
        }
        if !changes.is_empty() {
            let label = format!("duplicate {}", counted(changes.len(), "entity", "entities"));
            self.history.push(stage.world, &label, changes);
            self.selection = copies;
        }
        Ok(())
    }

    /// Gives entities another parent; they stay where they are in the world.
    ///
    /// # Errors
    /// If the parent stands below one of them.
    pub fn reparent(&mut self, stage: &mut Stage, ids: &[SceneId], parent: Option<SceneId>) -> Result<()> {
        self.history.close(stage.world)?;
        let parts: Vec<_> = ids.iter().filter_map(|id| Some((*id, stage.world.entity(*id)?))).collect();
        self.refuse_model_parts(stage.world, &parts)?;
        let mut changes = Vec::new();
        for (id, entity) in parts {
            let before = Seat::of(stage.world, id);
            if before.parent == parent || parent == Some(id) {
                continue;
            }
            let kept = stage.world.snapshot(entity, false)?;
            let place = stage.world.ecs.get::<GlobalTransform>(entity).copied().unwrap_or_default();
            let count = parent.and_then(|p| stage.world.entity(p)).map_or(0, |p| stage.world.children(p).len());
            let after = Seat { parent, index: count };
            if let Err(error) = seat(stage.world, id, &after) {
                stage.world.drop_snapshot(kept);
                return Err(error);
            }
            stand_at(stage.world, entity, &place);
            let new = stage.world.snapshot(entity, false)?;
            changes.push(Change::Moved { id, before, after });
            changes.push(Change::Components { id, before: kept, after: new });
        }
        if !changes.is_empty() {
            self.history.push(stage.world, "give another parent", changes);
        }
        Ok(())
    }

    /// Gives an entity another name; a number is added if a sibling has it.
    ///
    /// # Errors
    /// If the name cannot be one.
    pub fn rename(&mut self, stage: &mut Stage, id: SceneId, name: &str) -> Result<()> {
        let name = name.trim();
        if name.is_empty() || name.contains('/') {
            return Err(anyhow!("a name is not empty and holds no `/`"));
        }
        let entity = stage.world.entity(id).context("the entity is gone")?;
        if stage.world.name(entity) == name {
            return Ok(());
        }
        self.refuse_model_parts(stage.world, &[(id, entity)])?;
        self.history.open(stage, "rename", &[id])?;
        let name = stage.world.unique_name(stage.world.parent(entity), name);
        stage.world.ecs.entity_mut(entity).insert(Name(name));
        self.history.close(stage.world)
    }

    /// Changes components of entities; a drag goes on as one step as long as the label is the same.
    ///
    /// # Errors
    /// If a value is wrong; nothing changes then.
    pub fn edit_components(
        &mut self,
        stage: &mut Stage,
        label: &str,
        edits: &[(SceneId, files::OverrideFile)],
    ) -> Result<()> {
        let ids: Vec<SceneId> = edits.iter().map(|(id, _)| *id).collect();
        let is_model = |id: &SceneId, now: &files::OverrideFile| {
            let entity = stage.world.entity(*id)?;
            let before = describe_entity(stage.world, entity, stage.files.path).ok()?;
            let surface = |c: &files::OverrideFile| {
                (c.mesh.clone(), c.model.clone(), c.material.clone(), c.casts_shadow, c.visible)
            };
            let is_model = before.model.is_some() || now.model.is_some();
            (is_model && surface(&before) != surface(now)).then_some(())
        };
        // A model brings entities of its own: with its surface the whole subtree changes.
        let rebuilds = edits.iter().any(|(id, now)| is_model(id, now).is_some());
        if rebuilds {
            return self.rebuild(stage, label, edits);
        }
        self.history.open(stage, label, &ids)?;
        for (id, now) in edits {
            let entity = stage.world.entity(*id).context("the entity is gone")?;
            edit_entity(stage.world, &mut stage.files.context(), entity, now)?;
        }
        Ok(())
    }

    fn rebuild(&mut self, stage: &mut Stage, label: &str, edits: &[(SceneId, files::OverrideFile)]) -> Result<()> {
        self.history.close(stage.world)?;
        let mut changes = Vec::new();
        for (id, now) in edits {
            let before = Existence::of(stage.world, *id)?;
            let entity = stage.world.entity(*id).context("the entity is gone")?;
            if let Err(error) = edit_entity(stage.world, &mut stage.files.context(), entity, now) {
                stage.world.drop_snapshot(before.snapshot);
                return Err(error.into());
            }
            changes.push(Change::Went(before));
            changes.push(Change::Came(Existence::of(stage.world, *id)?));
        }
        match std::mem::replace(&mut self.rebuilding, true) && self.history.undo_label() == Some(label) {
            true => self.history.go_on(stage.world, changes),
            false => self.history.push(stage.world, label, changes),
        }
        Ok(())
    }

    /// Writes the selected entity as a prefab, and makes it an instance of that.
    ///
    /// # Errors
    /// If something of it has no form in a file, or the file cannot be written.
    pub fn make_prefab(&mut self, stage: &mut Stage, path: &Path) -> Result<()> {
        self.history.close(stage.world)?;
        let (id, entity) = self.selected(stage.world).pop().context("nothing is selected")?;
        files::save_prefab(stage.world, entity, stage.files.path, path)?;
        let described = describe_entity(stage.world, entity, stage.files.path)?;
        let instance = EntityFile {
            name: stage.world.name(entity).to_owned(),
            transform: described.transform,
            prefab: Some(relative_to(path, stage.files.path)),
            ..Default::default()
        };
        let went = Change::Went(Existence::of(stage.world, id)?);
        let parent = stage.world.parent(entity);
        let Change::Went(before) = &went else { return Ok(()) };
        stage.world.ecs.despawn(entity);
        let new = match spawn_entity(stage.world, &mut stage.files.context(), parent, &instance) {
            Ok(new) => new,
            Err(error) => {
                stage.world.put_back(before.snapshot, parent, before.seat.index)?;
                return Err(error.into());
            }
        };
        let new = stage.world.id(new).context("the instance has no identity")?;
        let came = Change::Came(Existence::of(stage.world, new)?);
        self.history.push(stage.world, "make a prefab", vec![went, came]);
        self.select_only(new);
        Ok(())
    }

    /// Makes the selected instance of a prefab plain entities.
    ///
    /// # Errors
    /// If nothing is selected.
    pub fn break_prefab(&mut self, stage: &mut Stage) -> Result<()> {
        self.history.close(stage.world)?;
        let (id, entity) = self.selected(stage.world).pop().context("nothing is selected")?;
        let ids: Vec<SceneId> = stage.world.subtree(entity).iter().filter_map(|e| stage.world.id(*e)).collect();
        self.history.open(stage, "break the prefab", &ids)?;
        files::break_prefab(stage.world, entity);
        self.history.close(stage.world)?;
        self.select_only(id);
        Ok(())
    }

    /// Writes what the selected instance has become into its prefab's file. Other instances follow when the scene is
    /// loaded anew.
    ///
    /// # Errors
    /// If the selected entity is no instance, or the file cannot be written.
    pub fn apply_prefab(&mut self, stage: &mut Stage) -> Result<std::path::PathBuf> {
        self.history.close(stage.world)?;
        let (_, entity) = self.selected(stage.world).pop().context("nothing is selected")?;
        let written =
            files::prefab_of(stage.world, entity).context("the selected entity is no instance of a prefab")?;
        let path = folder_of(stage.files.path).join(written);
        if files::is_repeated(stage.world, entity) {
            anyhow::bail!("the selected entity makes several copies of its prefab: apply an instance that makes one");
        }
        files::apply_to_prefab(stage.world, entity, stage.files.path, &path)?;
        Ok(path)
    }

    fn refuse_model_parts(&self, world: &GameWorld, parts: &[(SceneId, Entity)]) -> Result<()> {
        let part = parts.iter().find(|(_, entity)| files::is_from_model(world, *entity));
        match part {
            Some((_, entity)) => Err(anyhow!(
                "`{}` is part of a model, which only the model's file can change; select the entity that holds the model",
                world.name(*entity)
            )),
            None => Ok(()),
        }
    }
}

/// Gives the entity the local transform that puts it at a place in the world.
fn stand_at(world: &mut GameWorld, entity: Entity, place: &GlobalTransform) {
    let parent = world.parent(entity).and_then(|p| world.ecs.get::<GlobalTransform>(p)).copied().unwrap_or_default();
    let origin = parent.translation();
    let local = parent.relative_to(origin).inverse() * place.relative_to(origin);
    if local.is_finite() {
        let (scale, rotation, translation) = local.to_scale_rotation_translation();
        world.set_rest_transform(entity, Transform { translation, rotation, scale });
    }
}

/// The path as a scene file names it: relative to the file's folder where it can be.
pub fn relative_to(path: &Path, scene: &Path) -> String {
    let absolute = |p: &Path| p.canonicalize().unwrap_or_else(|_| p.to_owned());
    let (path, folder) = (absolute(path), absolute(folder_of(scene)));
    let mut up = String::new();
    for above in folder.ancestors().take(3) {
        if let Ok(rest) = path.strip_prefix(above) {
            return format!("{up}{}", rest.display());
        }
        up += "../";
    }
    path.display().to_string()
}

/// The folder of a file; `.` for a bare name.
pub fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

fn counted(count: usize, one: &str, many: &str) -> String {
    if count == 1 { format!("1 {one}") } else { format!("{count} {many}") }
}
