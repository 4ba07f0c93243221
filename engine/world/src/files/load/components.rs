//! The components of a loaded entity, with the meshes, materials and images that they name.

use super::loader::{Context, Loader, Resolved};
use crate::assets::{CubeTable, Material, Mesh, Texture};
use crate::files::error::{FileError, FileErrorKind as Kind};
use crate::files::format::scene_file::*;
use crate::files::ron::steps::{extended, key};
use crate::files::ron::tree::Step;
use crate::world::animation::Track;
use crate::world::{Camera, GradingTable, MeshRenderer, Transform};
use bevy_ecs::prelude::Entity;
use std::sync::Arc;

impl Loader<'_> {
    /// Puts the components on the entity; gives the material of its shape.
    pub(in crate::files) fn insert_components(
        &mut self,
        entity: Entity,
        r: &Resolved,
    ) -> Result<Option<Arc<Material>>, FileError> {
        let c = &r.components;
        let transform = c.transform.map(Transform::from).unwrap_or_default();
        self.world.ecs.entity_mut(entity).insert(transform);
        let mut material = None;
        if c.material.is_some() || c.mesh.is_some() {
            material = self.material_of(r)?;
        }
        if let Some(shape) = &c.mesh {
            let mesh = self.library.shape(shape).map_err(|e| {
                r.surface.0.document.asset_error(&extended(&r.surface.1, &[key("mesh")]), Kind::BadValue, &e)
            })?;
            self.info.shapes.insert(mesh.id, shape.clone());
            let material = material.get_or_insert_with(|| self.info.default_material.clone()).clone();
            self.world.ecs.entity_mut(entity).insert(renderer(c, mesh, material));
        }
        if let Some(model) = &c.model {
            let at = extended(&r.surface.1, &[key("model")]);
            self.model(entity, model, material.as_ref(), c, &r.surface.0.clone(), &at)?;
        }
        let plays = c.animation.iter().flat_map(|a| &a.tracks).any(|track| matches!(track, Track::Clip { .. }));
        if plays && c.model.is_none() {
            let at = extended(&r.surface.1, &[key("animation")]);
            let message = "the animation plays a clip, but the entity has no model that could have one";
            let error = r.surface.0.document.error(&at, Kind::BadValue, message);
            return Err(error.with_help("give the clip to the entity that has the `model`"));
        }
        if let Some(camera) = &c.camera {
            let (context, at) = &r.camera;
            self.grading(entity, camera, context, &extended(at, &[key("camera"), key("lens"), key("grading")]))?;
        }
        let mut target = self.world.ecs.entity_mut(entity);
        if let Some(light) = &c.light {
            target.insert(light.clone());
        }
        if let Some(camera) = &c.camera {
            target.insert(camera.clone());
        }
        if let Some(clpv) = &c.clpv {
            target.insert(clpv.clone());
        }
        if let Some(slc) = &c.slc {
            target.insert(slc.clone());
        }
        if let Some(vpl) = &c.vpl {
            target.insert(vpl.clone());
        }
        if let Some(fog) = c.fog {
            target.insert(fog);
        }
        if let Some(particles) = c.particles {
            target.insert(particles);
        }
        if let Some(animation) = &c.animation {
            target.insert(animation.clone());
        }
        // They were read before, and only what the world does with them could fail.
        self.options.types.put(&c.components, &mut self.world.ecs, entity).map_err(|fault| {
            r.surface.0.document.error(&extended(&r.surface.1, &[key("components")]), Kind::BadValue, fault)
        })?;
        Ok(material)
    }

    /// Loads the colour table that a camera asks for, and puts it on its entity.
    pub(in crate::files) fn grading(
        &mut self,
        entity: Entity,
        camera: &Camera,
        context: &Context,
        at: &[Step],
    ) -> Result<(), FileError> {
        let Some(written) = camera.lens.grading.as_ref().filter(|written| !written.is_empty()) else { return Ok(()) };
        if self.world.ecs.get::<GradingTable>(entity).is_some_and(|known| known.file == *written) {
            return Ok(());
        }
        let Some(path) = self.find("colour table", written, &context.document, at)? else {
            let error = context.document.error(at, Kind::MissingFile, format!("there is no colour table `{written}`"));
            return Err(error.with_help("name a .cube file; paths start at the folder of this file"));
        };
        self.library.note(&path);
        let table = CubeTable::load(&path).map_err(|fault| context.document.asset_error(at, Kind::Asset, &fault))?;
        self.world.ecs.entity_mut(entity).insert(GradingTable { file: written.clone(), table: Arc::new(table) });
        Ok(())
    }

    /// The material that the components name.
    pub(in crate::files) fn material_of(&mut self, r: &Resolved) -> Result<Option<Arc<Material>>, FileError> {
        let (context, at) = &r.material;
        let at = extended(at, &[key("material")]);
        match &r.components.material {
            None => Ok(None),
            Some(MaterialRef::Inline(file)) => self.material("", file, context, &at).map(Some),
            Some(MaterialRef::Named(name)) => {
                let identity = (context.document.path.clone(), name.clone());
                if let Some(known) = self.named.get(&identity) {
                    return Ok(Some(known.clone()));
                }
                let Some(file) = context.materials.get(name) else {
                    let error =
                        context.document.error(&at, Kind::UnknownName, format!("there is no material `{name}`"));
                    return Err(error);
                };
                let material = self.material(name, file, context, &[key("materials"), key(name)])?;
                self.named.insert(identity, material.clone());
                Ok(Some(material))
            }
        }
    }

    /// The material that a file describes.
    pub(in crate::files) fn material(
        &mut self,
        name: &str,
        file: &MaterialFile,
        context: &Context,
        at: &[Step],
    ) -> Result<Arc<Material>, FileError> {
        let mut load = |field: &str, texture: &Option<TextureFile>, srgb: bool| {
            let Some(texture) = texture else { return Ok(None) };
            self.texture(texture, srgb, context, &extended(at, &[key(field)])).map(Some)
        };
        let mut material = file.material(name);
        material.base_color_texture = load("color_texture", &file.color_texture, true)?;
        material.metallic_roughness_texture =
            load("metallic_roughness_texture", &file.metallic_roughness_texture, false)?;
        material.normal_texture = load("normal_texture", &file.normal_texture, false)?;
        material.emissive_texture = load("emissive_texture", &file.emissive_texture, true)?;
        material.transmission_texture = load("transmission_texture", &file.transmission_texture, false)?;
        let material = Arc::new(material);
        let described = match context.is_root && !name.is_empty() {
            true => MaterialRef::Named(name.to_owned()),
            false => MaterialRef::Inline(Box::new(file.clone().rebased(context))),
        };
        self.info.materials_by_id.insert(material.id, described);
        Ok(material)
    }

    fn texture(
        &mut self,
        file: &TextureFile,
        srgb: bool,
        context: &Context,
        at: &[Step],
    ) -> Result<Arc<Texture>, FileError> {
        let written = file.path();
        let Some(path) = self.find("image", written, &context.document, at)? else {
            let error = context.document.error(at, Kind::MissingFile, format!("there is no image `{written}`"));
            return Err(error.with_help("paths start at the folder of this file, or at the one given by --models"));
        };
        let texture = self
            .library
            .texture(&path, srgb, file.sampling())
            .map_err(|e| context.document.asset_error(at, Kind::Asset, &e))?;
        self.info.textures_by_id.insert(texture.id, file.clone().rebased(context));
        Ok(texture)
    }
}

/// A renderer as the components say.
pub(in crate::files) fn renderer(c: &OverrideFile, mesh: Arc<Mesh>, material: Arc<Material>) -> MeshRenderer {
    let (casts_shadow, visible) = (c.casts_shadow.unwrap_or(true), c.visible.unwrap_or(true));
    MeshRenderer { mesh, material, casts_shadow, visible }
}
