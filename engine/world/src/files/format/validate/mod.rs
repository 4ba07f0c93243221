//! Validation of files: ranges, finite numbers, unique names.

mod components;

use super::scene_file::*;
use crate::assets::AssetError;
use crate::assets::atmosphere::MAX_ALTITUDE;
use crate::files::error::FileErrorKind as Kind;
use crate::files::ron::steps::Fault;
use crate::files::ron::suggest::suggestion;
use crate::files::ron::tree::Step;
use crate::world::{Environment, SceneSettings};
use glam::Vec3;
use std::collections::{BTreeMap, HashSet};

type Checked = Result<(), Box<Fault>>;

/// Walks a file's values and keeps the path.
#[derive(Default)]
pub struct Validator {
    path: Vec<Step>,
    materials: Vec<String>,
}

impl Validator {
    /// Checks a scene file.
    pub fn scene(file: &SceneFile) -> Checked {
        let mut v = Self { path: Vec::new(), materials: file.materials.keys().cloned().collect() };
        v.field("settings", |v| v.settings(&file.settings))?;
        v.field("presets", |v| v.presets(&file.presets))?;
        v.field("materials", |v| v.materials(&file.materials))?;
        v.field("entities", |v| v.siblings(&file.entities))
    }

    /// Checks a prefab file.
    pub fn prefab(file: &PrefabFile) -> Checked {
        let mut v = Self { path: Vec::new(), materials: file.materials.keys().cloned().collect() };
        v.field("materials", |v| v.materials(&file.materials))?;
        v.field("entities", |v| v.siblings(&file.entities))
    }

    /// Checks an entity with all below it, as part of a file with materials of those names.
    pub fn lone_entity(file: &EntityFile, materials: Vec<String>) -> Checked {
        let mut v = Self { path: Vec::new(), materials };
        v.name(&file.name)?;
        v.entity(file)
    }

    /// Checks components, as part of a file with materials of those names.
    pub fn lone_components(components: &OverrideFile, materials: Vec<String>) -> Checked {
        Self { path: Vec::new(), materials }.components(components)
    }

    fn field(&mut self, name: &str, check: impl FnOnce(&mut Self) -> Checked) -> Checked {
        self.step(Step::Key(name.to_owned()), check)
    }

    fn step(&mut self, step: Step, check: impl FnOnce(&mut Self) -> Checked) -> Checked {
        self.path.push(step);
        let result = check(self);
        self.path.pop();
        result
    }

    fn fault(&self, field: &str, kind: Kind, message: impl Into<String>, help: impl Into<String>) -> Box<Fault> {
        let mut path = self.path.clone();
        if !field.is_empty() {
            path.push(Step::Key(field.to_owned()));
        }
        Box::new(Fault { path, kind, message: message.into(), help: Some(help.into()).filter(|h| !h.is_empty()) })
    }

    fn require(&self, ok: bool, field: &str, message: impl Into<String>, help: &str) -> Checked {
        if ok { Ok(()) } else { Err(self.fault(field, Kind::BadValue, message, help)) }
    }

    fn number(&self, field: &str, value: f32, low: f32, high: f32) -> Checked {
        let ok = value.is_finite() && value >= low && value <= high;
        self.require(ok, field, format!("`{field}` is {value}"), &range_help(low, high))
    }

    fn color(&self, field: &str, value: Vec3, high: f32) -> Checked {
        let ok = value.is_finite() && value.min_element() >= 0.0 && value.max_element() <= high;
        self.require(ok, field, format!("`{field}` is ({}, {}, {})", value.x, value.y, value.z), &range_help(0.0, high))
    }

    fn finite(&self, field: &str, value: &[f32]) -> Checked {
        let ok = value.iter().all(|v| v.is_finite());
        self.require(ok, field, format!("`{field}` is not finite: {value:?}"), "use finite numbers")
    }

    fn settings(&mut self, s: &SceneSettings) -> Checked {
        self.color("sky", s.sky, f32::MAX)?;
        self.environment(s.environment.as_ref())?;
        self.number("exposure", s.exposure, -100.0, 100.0)?;
        self.number("move_speed", s.move_speed, 0.0, f32::MAX)?;
        if let Some(duration) = s.duration {
            self.require(
                duration.is_finite() && duration > 0.0,
                "duration",
                format!("`duration` is {duration}"),
                "use a time above zero [s], or leave it out for no loop",
            )?;
        }
        self.require(
            (1..=1000).contains(&s.frame_rate),
            "frame_rate",
            format!("`frame_rate` is {}", s.frame_rate),
            "use 1 to 1000 frames a second",
        )
    }

    fn environment(&self, environment: Option<&Environment>) -> Checked {
        let field = "environment";
        match environment {
            None => Ok(()),
            Some(Environment::Gradient { zenith, horizon, ground }) => {
                [zenith, horizon, ground].into_iter().try_for_each(|color| self.color(field, *color, 1e30))
            }
            Some(Environment::Image { rotation, intensity, .. }) => {
                self.number(field, *rotation, -1e6, 1e6)?;
                self.number(field, *intensity, 0.0, 1e12)
            }
            Some(Environment::Physical { haze, ground, altitude, sun: _ }) => {
                self.number(field, *haze, 0.0, 100.0)?;
                self.color(field, *ground, 1.0)?;
                self.number(field, *altitude, 0.0, MAX_ALTITUDE)
            }
        }
    }

    fn presets(&mut self, presets: &BTreeMap<String, Vec<String>>) -> Checked {
        for (name, changes) in presets {
            for (i, change) in changes.iter().enumerate() {
                let ok = change.split_once('=').is_some_and(|(path, value)| !path.is_empty() && !value.is_empty());
                let message = format!("`{change}` is no change");
                let help = "write PATH=VALUE as for --set, for instance \"clpv.steps=32\"";
                self.field(name, |v| v.step(Step::Index(i), |v| v.require(ok, "", message, help)))?;
            }
        }
        Ok(())
    }

    fn materials(&mut self, materials: &BTreeMap<String, MaterialFile>) -> Checked {
        for (name, material) in materials {
            self.field(name, |v| v.material(material))?;
        }
        Ok(())
    }

    fn material(&mut self, m: &MaterialFile) -> Checked {
        self.color("color", m.color, 1.0)?;
        self.number("alpha", m.alpha, 0.0, 1.0)?;
        if let AlphaModeFile::Mask(cutoff) = m.alpha_mode {
            self.require(
                (0.0..=1.0).contains(&cutoff),
                "alpha_mode",
                format!("the cutoff is {cutoff}"),
                "use a cutoff from 0 to 1",
            )?;
        }
        self.number("metallic", m.metallic, 0.0, 1.0)?;
        self.number("roughness", m.roughness, 0.0, 1.0)?;
        self.number("specular", m.specular, 0.0, 1.0)?;
        self.color("specular_color", m.specular_color, f32::MAX)?;
        self.number("transmission", m.transmission, 0.0, 1.0)?;
        self.number("ior", m.ior, 1.0, 10.0)?;
        if let Some(volume) = &m.volume {
            self.field("volume", |v| {
                v.color("color", volume.color, 1.0)?;
                v.number("distance", volume.distance, 1e-6, f32::MAX)
            })?;
        }
        self.layers(m)?;
        self.color("emissive", m.emissive, f32::MAX)?;
        self.finite("normal_scale", &[m.normal_scale])
    }

    fn layers(&mut self, m: &MaterialFile) -> Checked {
        self.number("dispersion", m.dispersion, 0.0, 100.0)?;
        if let Some(coat) = &m.clearcoat {
            self.field("clearcoat", |v| {
                v.number("factor", coat.factor, 0.0, 1.0)?;
                v.number("roughness", coat.roughness, 0.0, 1.0)
            })?;
        }
        if let Some(sheen) = &m.sheen {
            self.field("sheen", |v| {
                v.color("color", sheen.color, 1.0)?;
                v.number("roughness", sheen.roughness, 0.0, 1.0)
            })?;
        }
        if let Some(anisotropy) = &m.anisotropy {
            self.field("anisotropy", |v| {
                v.number("strength", anisotropy.strength, 0.0, 1.0)?;
                v.finite("rotation", &[anisotropy.rotation])
            })?;
        }
        let Some(film) = &m.iridescence else { return Ok(()) };
        self.field("iridescence", |v| {
            v.number("factor", film.factor, 0.0, 1.0)?;
            v.number("ior", film.ior, 1.0, 10.0)?;
            v.number("thickness", film.thickness, 0.0, 100_000.0)
        })
    }

    fn siblings(&mut self, entities: &[EntityFile]) -> Checked {
        let mut names = HashSet::new();
        for (i, entity) in entities.iter().enumerate() {
            self.step(Step::Index(i), |v| {
                v.name(&entity.name)?;
                if !names.insert(entity.name.as_str()) {
                    let message = format!("two siblings are named `{}`", entity.name);
                    return Err(v.fault(
                        "name",
                        Kind::DuplicateName,
                        message,
                        "give each child of one parent its own name",
                    ));
                }
                v.entity(entity)
            })?;
        }
        Ok(())
    }

    fn name(&self, name: &str) -> Checked {
        self.require(!name.trim().is_empty(), "name", "the name is empty", "name every entity")?;
        self.require(
            !name.contains('/'),
            "name",
            format!("the name `{name}` holds a `/`"),
            "`/` divides the names of a path; use another sign",
        )
    }

    fn entity(&mut self, e: &EntityFile) -> Checked {
        self.components(&e.components())?;
        if e.mesh.is_some() && e.model.is_some() {
            return Err(self.fault(
                "model",
                Kind::BadValue,
                "an entity has either a mesh or a model",
                "put the model on a child",
            ));
        }
        if let Some(path) = &e.prefab {
            self.require(!path.is_empty(), "prefab", "the path is empty", "name the prefab's file")?;
        } else if !e.overrides.is_empty() {
            return Err(self.fault(
                "overrides",
                Kind::BadValue,
                "overrides without a prefab",
                "say `prefab: \"….prefab.ron\"` too",
            ));
        }
        if let Some(repeat) = &e.repeat {
            if e.prefab.is_none() {
                let help = "say `prefab: \"….prefab.ron\"` too; only prefabs are repeated";
                return Err(self.fault("repeat", Kind::BadValue, "repeats without a prefab", help));
            }
            if let Some((field, message, help)) = repeat.fault() {
                return self.field("repeat", |v| Err(v.fault(field, Kind::BadValue, message, help)));
            }
        }
        for (path, patch) in &e.overrides {
            self.field("overrides", |v| {
                v.field(path, |v| {
                    v.components(patch)?;
                    v.field("children", |v| v.siblings(&patch.children))
                })
            })?;
        }
        self.field("children", |v| v.siblings(&e.children))
    }

    fn components(&mut self, c: &OverrideFile) -> Checked {
        if let Some(t) = &c.transform {
            self.field("transform", |v| v.transform(t))?;
        }
        if let Some(shape) = &c.mesh {
            self.field("mesh", |v| {
                shape.validate().map_err(|e| match &e {
                    AssetError::Shape { field, .. } => v.fault(field, Kind::BadValue, e.to_string(), ""),
                    _ => v.fault("", Kind::BadValue, e.to_string(), ""),
                })
            })?;
        }
        if let Some(ModelFile::Detailed(ModelDetails { import: Some(settings), .. })) = &c.model {
            self.field("model", |v| v.field("import", |v| v.import(settings)))?;
        }
        match &c.material {
            Some(MaterialRef::Inline(material)) => self.field("material", |v| v.material(material))?,
            Some(MaterialRef::Named(name)) if !self.materials.contains(name) => {
                let help = suggestion(name, self.materials.iter().map(String::as_str));
                let help = help.unwrap_or_else(|| "this file has no `materials: { … }`; add one".into());
                return Err(self.fault(
                    "material",
                    Kind::UnknownName,
                    format!("there is no material `{name}` in this file"),
                    help,
                ));
            }
            _ => {}
        }
        if let Some(light) = &c.light {
            self.field("light", |v| v.light(light))?;
        }
        if let Some(camera) = &c.camera {
            self.field("camera", |v| v.camera(camera))?;
        }
        if let Some(clpv) = &c.clpv {
            self.field("clpv", |v| v.clpv(clpv))?;
        }
        if let Some(vpl) = &c.vpl {
            self.field("vpl", |v| v.vpl(vpl))?;
        }
        if let Some(slc) = &c.slc {
            self.field("slc", |v| v.slc(slc))?;
        }
        if let Some(fog) = &c.fog {
            self.field("fog", |v| v.fog(fog))?;
        }
        if let Some(particles) = &c.particles {
            self.field("particles", |v| v.particles(particles))?;
        }
        if let Some(animation) = &c.animation {
            self.field("animation", |v| v.animation(animation))?;
        }
        Ok(())
    }

    fn import(&mut self, settings: &ImportSettings) -> Checked {
        settings.validate().map_err(|wrong| {
            let mut fault = self.fault(wrong.field, Kind::BadValue, wrong.message, "");
            fault.path.extend(wrong.index.map(Step::Index));
            fault
        })
    }
}

fn range_help(low: f32, high: f32) -> String {
    match (low, high) {
        (0.0, f32::MAX) => "use finite numbers from zero up".into(),
        _ => format!("use {low} to {high}"),
    }
}
