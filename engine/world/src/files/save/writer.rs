//! Descriptions of entities, read out of a world.

use super::overridden::Overridden;
use super::paths::way_to;
use crate::files::error::{FileError, FileErrorKind as Kind};
use crate::files::format::custom_components::ComponentTypes;
use crate::files::format::scene_file::*;
use crate::files::load::source::{Origin, SceneInfo, Source};
use crate::files::ron::document::folder_of;
use crate::world::{
    Animation, Clpv, Fog, GameWorld, InstantRadiosity, MeshRenderer, Name, Particles, StochasticLightCulling, Transform,
};
use bevy_ecs::prelude::{Entity, World};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Everything of the scene file but its entities.
pub(in crate::files) fn scene_without_entities(world: &GameWorld) -> SceneFile {
    let default_info = SceneInfo::default();
    let info = world.ecs.get_resource::<SceneInfo>().unwrap_or(&default_info);
    SceneFile {
        version: info.version,
        description: info.description.clone(),
        gi: info.gi,
        presets: info.presets.clone(),
        settings: world.rest_settings(),
        materials: info.materials.clone(),
        entities: Vec::new(),
    }
}

/// Reads files' entities out of a world.
pub(in crate::files) struct Writer<'a> {
    pub world: &'a GameWorld,
    pub info: &'a SceneInfo,
    pub path: &'a Path,
    /// Values that are written otherwise than they are.
    pub overridden: Option<&'a Overridden>,
}

impl<'a> Writer<'a> {
    /// Reads what is to be saved: the file's values where others were set for this run.
    pub fn saving(world: &'a GameWorld, info: &'a SceneInfo, path: &'a Path) -> Self {
        Self { world, info, path, overridden: world.ecs.get_resource() }
    }

    fn ecs(&self) -> &World {
        &self.world.ecs
    }

    fn source(&self, entity: Entity) -> Option<&Source> {
        self.ecs().get::<Source>(entity)
    }

    fn name(&self, entity: Entity) -> String {
        self.ecs().get::<Name>(entity).map(|n| n.0.clone()).unwrap_or_default()
    }

    /// All that are to be written of these siblings.
    pub fn entities(&self, siblings: &[Entity]) -> Result<Vec<EntityFile>, FileError> {
        let written = siblings.iter().filter(|e| !self.is_from_model(**e) && !self.is_added(**e));
        written.map(|entity| self.entity(*entity)).collect()
    }

    /// Whether the entity is there for this run alone.
    fn is_added(&self, entity: Entity) -> bool {
        let Some(overridden) = self.overridden.filter(|_| self.world.children(entity).is_empty()) else { return false };
        self.components(entity).is_ok_and(|now| overridden.is_added(self.world.id(entity), &now))
    }

    /// Whether the entity was made from a model's node, and is not written.
    pub fn is_from_model(&self, entity: Entity) -> bool {
        self.source(entity).is_some_and(|s| matches!(s.origin, Origin::Model))
    }

    /// The entity with all below it.
    pub fn entity(&self, entity: Entity) -> Result<EntityFile, FileError> {
        let mut file = EntityFile::with_components(self.name(entity), self.components(entity)?);
        let mut children = self.world.children(entity);
        // An instance that was taken out of another prefab is written out in full.
        let instance = |s: &&Source| s.prefab.is_some() && matches!(s.origin, Origin::File);
        if let Some(source) = self.source(entity).filter(instance) {
            file.prefab = source.prefab.clone();
            file.repeat = source.repeat.clone();
            let mut found = BTreeSet::new();
            self.overrides(source, entity, "", &mut file.overrides, &mut found)?;
            let removed = source.overrides.iter().filter(|(path, patch)| patch.remove && !found.contains(*path));
            file.overrides.extend(removed.map(|(path, patch)| (path.clone(), patch.clone())));
            for member in source.members.iter().filter(|m| !found.contains(*m)) {
                // What lies below a removed entity goes with it.
                let above = member.rsplit_once('/').map(|(above, _)| above.to_owned());
                if above.is_none_or(|above| found.contains(&above)) {
                    let removed = || OverrideFile { remove: true, ..Default::default() };
                    file.overrides.entry(member.clone()).or_insert_with(removed);
                }
            }
            children.retain(|child| !self.is_member(*child, ""));
        }
        file.children = self.entities(&children)?;
        Ok(file)
    }

    /// Whether the entity still stands where its prefab put it: below `parent`, a path within the instance.
    fn is_member(&self, entity: Entity, parent: &str) -> bool {
        self.source(entity).is_some_and(
            |source| matches!(&source.origin, Origin::Prefab { path, .. } if *path == join(parent, &self.name(entity))),
        )
    }

    /// Differences of an instance from its prefab.
    fn overrides(
        &self,
        instance: &Source,
        entity: Entity,
        path: &str,
        overrides: &mut BTreeMap<String, OverrideFile>,
        found: &mut BTreeSet<String>,
    ) -> Result<(), FileError> {
        for child in self.world.children(entity) {
            if !self.is_member(child, path) {
                continue;
            }
            let Some(source) = self.source(child) else { continue };
            let Origin::Prefab { base, material_overridden, .. } = &source.origin else { continue };
            let path = join(path, &self.name(child));
            let now = self.components(child)?;
            let mut changes = now.changes_from(base);
            // A name may mean another material in the prefab's own file.
            if *material_overridden {
                changes.material = now.material.clone();
            }
            let mut added = self.world.children(child);
            added.retain(|grandchild| !self.is_member(*grandchild, &path));
            changes.children = self.entities(&added)?;
            let described = instance.overrides.get(&path);
            if let Some(described) = described {
                changes.keep(described, &now);
            }
            if changes != OverrideFile::default() || described == Some(&changes) {
                overrides.insert(path.clone(), changes);
            }
            found.insert(path.clone());
            self.overrides(instance, child, &path, overrides, found)?;
        }
        Ok(())
    }

    /// The entity's components: as described where nothing has changed.
    pub fn components(&self, entity: Entity) -> Result<OverrideFile, FileError> {
        let described = self.source(entity).map(|s| s.components.clone()).unwrap_or_default();
        let mut now = OverrideFile {
            transform: self.transform(entity, described.transform),
            light: self.world.rest_light(entity),
            camera: self.world.rest_camera(entity),
            clpv: self.world.rest_component::<Clpv>(entity, "clpv"),
            vpl: self.world.rest_component::<InstantRadiosity>(entity, "vpl"),
            slc: self.world.rest_component::<StochasticLightCulling>(entity, "slc"),
            fog: self.world.rest_component::<Fog>(entity, "fog"),
            particles: self.world.rest_component::<Particles>(entity, "particles"),
            animation: self.ecs().get::<Animation>(entity).cloned(),
            model: described.model.clone().map(|model| self.model(model)),
            ..Default::default()
        };
        let default_types = ComponentTypes::default();
        let types = self.ecs().get_resource::<ComponentTypes>().unwrap_or(&default_types);
        now.components = types
            .describe(self.ecs(), entity, &described.components)
            .map_err(|fault| FileError::new(self.path, Kind::Unsavable, format!("`{}`: {fault}", self.name(entity))))?;
        if let Some(renderer) = self.ecs().get::<MeshRenderer>(entity) {
            self.surface(entity, renderer, &described, &mut now)?;
        } else if described.model.is_some() {
            now.material = described.material;
            (now.casts_shadow, now.visible) = (described.casts_shadow, described.visible);
        }
        Ok(match self.overridden {
            Some(overridden) => overridden.saved(self.world.id(entity), now),
            None => now,
        })
    }

    /// A glTF file that was opened as a scene is named by its whole path: in a scene by the way to it, so that both can be moved
    /// together.
    fn model(&self, mut model: ModelFile) -> ModelFile {
        if self.info.file.is_some() {
            return model;
        }
        let (ModelFile::Path(path) | ModelFile::Detailed(ModelDetails { path, .. })) = &mut model;
        if let Some(way) = way_to(Path::new(path.as_str()), folder_of(self.path)).filter(|_| Path::new(path).has_root())
        {
            *path = way;
        }
        model
    }

    fn transform(&self, entity: Entity, described: Option<TransformFile>) -> Option<TransformFile> {
        let rest: Transform = self.world.rest_transform(entity);
        if Transform::from(described.unwrap_or_default()) == rest {
            return described;
        }
        // A part that has not changed stays as it was put: angles, say.
        let described = described.unwrap_or_default();
        let turned = TransformFile { translation: rest.translation, ..described };
        let mut now = TransformFile::from(rest);
        if Transform::from(turned).rotation == rest.rotation {
            (now.rotation, now.look_at) = (described.rotation, described.look_at);
        }
        if Transform::from(described).scale == rest.scale {
            now.scale = described.scale;
        }
        Some(now)
    }

    fn surface(
        &self,
        entity: Entity,
        renderer: &MeshRenderer,
        described: &OverrideFile,
        now: &mut OverrideFile,
    ) -> Result<(), FileError> {
        let Some(shape) = self.info.shapes.get(&renderer.mesh.id) else {
            let message =
                format!("`{}` has a mesh that comes from no file: `{}`", self.name(entity), renderer.mesh.name);
            let error = FileError::new(self.path, Kind::Unsavable, message);
            return Err(error.with_help("use a shape, or a model from a file"));
        };
        now.mesh = Some(shape.clone());
        now.material = self.material(entity, renderer, described)?;
        let flag =
            |now: bool, described: Option<bool>| if now == described.unwrap_or(true) { described } else { Some(now) };
        let casts_shadow = self.world.rest_casts_shadow(entity).unwrap_or(renderer.casts_shadow);
        now.casts_shadow = flag(casts_shadow, described.casts_shadow);
        let visible = self.world.rest_visible(entity).unwrap_or(renderer.visible);
        now.visible = flag(visible, described.visible);
        Ok(())
    }

    fn material(
        &self,
        entity: Entity,
        renderer: &MeshRenderer,
        described: &OverrideFile,
    ) -> Result<Option<MaterialRef>, FileError> {
        let material = self.world.rest_material(entity).unwrap_or_else(|| renderer.material.clone());
        let source = self.source(entity);
        let loaded = source.and_then(|s| s.material.as_ref());
        let in_place = match source.map(|s| &s.origin) {
            // Described in terms of the prefab: true only as long as the entity stands in it.
            Some(Origin::Prefab { .. }) => self.stands_in_prefab(entity),
            _ => true,
        };
        if in_place && loaded.is_some_and(|loaded| loaded.id == material.id) {
            return Ok(described.material.clone());
        }
        if material.id == self.info.default_material.id {
            return Ok(None);
        }
        if let Some(known) = self.info.materials_by_id.get(&material.id) {
            return Ok(Some(known.clone()));
        }
        let Some(file) = MaterialFile::describe(&material, self.info) else {
            let message = format!(
                "the material `{}` of `{}` has an image that comes from no file",
                material.name,
                self.name(entity)
            );
            return Err(FileError::new(self.path, Kind::Unsavable, message));
        };
        Ok(Some(MaterialRef::Inline(Box::new(file))))
    }

    fn stands_in_prefab(&self, entity: Entity) -> bool {
        let Some(Origin::Prefab { path, .. }) = self.source(entity).map(|s| &s.origin) else { return false };
        let mut node = Some(entity);
        for name in path.rsplit('/') {
            let Some(here) = node else { return false };
            if self.name(here) != name {
                return false;
            }
            node = self.world.parent(here);
        }
        node.and_then(|n| self.source(n)).is_some_and(|s| s.prefab.is_some())
    }
}

fn join(parent: &str, name: &str) -> String {
    if parent.is_empty() { name.to_owned() } else { format!("{parent}/{name}") }
}
