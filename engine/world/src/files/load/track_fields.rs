//! Fields that tracks change by their paths: whether they are there, and whether the keys fit them.

use crate::files::error::FileErrorKind as Kind;
use crate::files::format::custom_components::ComponentTypes;
use crate::files::format::scene_file::{OverrideFile, SceneFile};
use crate::files::format::validate::Validator;
use crate::files::ron::suggest::suggestion;
use crate::files::ron::tree::Step;
use crate::world::animation::{KeyValue, Target};
use crate::world::fields::{CLOCK_FIELDS, FieldTypes, SCENE, rest_text, ron_options, split, text, written};
use crate::world::{Camera, Environment, GameWorld, Light, MeshRenderer};
use bevy_ecs::prelude::Entity;
use serde::de::DeserializeOwned;

/// The fault of a track.
pub(in crate::files) struct Wrong {
    /// Where in the track.
    pub at: Vec<Step>,
    pub kind: Kind,
    pub message: String,
    pub help: Option<String>,
}

impl Wrong {
    pub fn at(field: &str, kind: Kind, message: String, help: Option<String>) -> Self {
        Self { at: vec![Step::Key(field.to_owned())], kind, message, help }
    }

    fn target(message: String, help: impl Into<Option<String>>) -> Self {
        Self::at("target", Kind::UnknownName, message, help.into())
    }
}

/// The track that is checked: whose fields it changes, and how.
pub(in crate::files) struct FieldTrack<'a> {
    pub world: &'a GameWorld,
    /// The entity whose field it is.
    pub entity: Entity,
    /// The node that the track names, if any.
    pub node: &'a str,
    pub path: &'a str,
    pub keys: &'a [(f64, KeyValue)],
}

impl FieldTrack<'_> {
    /// The first thing that is wrong.
    pub fn fault(&self) -> Option<Wrong> {
        self.check().err()
    }

    fn check(&self) -> Result<(), Wrong> {
        let (component, steps) = split(self.path);
        let is_text = Target::Field(self.path.to_owned()).text_path().is_some();
        if is_text && let Some(whole) = Target::whole_of(self.path) {
            let message = format!("`{}` is a part of `{whole}`, which is keyed as a whole", self.path);
            return Err(Wrong::target(message, format!("use Field(\"{whole}\") with all its numbers")));
        }
        if component == SCENE {
            return self.check_setting(&steps);
        }
        let kinds = self.world.ecs.get_resource::<FieldTypes>().cloned().unwrap_or_default();
        let known = Target::fields_without_text(component);
        if !is_text || !known.is_empty() {
            self.check_surface(component)?;
            return match is_text {
                true => Err(self.no_field(component, &steps.join("."), &known)),
                false => Ok(()),
            };
        }
        let shown = kinds.get(component).and_then(|kind| kind.text(&self.world.ecs, self.entity));
        let Some(shown) = shown else { return Err(self.no_component(component)) };
        let own = rest_text(&self.world.ecs, self.entity, component, shown);
        self.check_keys(&own, &steps, |text| self.component_fault(component, text))
    }

    fn check_setting(&self, steps: &[&str]) -> Result<(), Wrong> {
        if !self.node.is_empty() {
            let message = format!("`{}` belongs to the scene and not to `{}`", self.path, self.node);
            return Err(Wrong::at("node", Kind::BadValue, message, Some("leave `node` out".into())));
        }
        if let Some(field) = steps.first().filter(|field| CLOCK_FIELDS.contains(field)) {
            let message = format!("`{SCENE}.{field}` cannot be keyed: the time of all tracks follows from it");
            return Err(Wrong::target(message, "use another speed or wrap for the track instead".to_owned()));
        }
        let settings = self.world.rest_settings();
        if let (["environment", "intensity"], Some(Environment::Image { intensity: 0.0, .. })) =
            (steps, &settings.environment)
        {
            let message = format!("`{}` is 0 without the track, and keys brighten what is there", self.path);
            return Err(Wrong::target(message, "give the environment an intensity above zero".to_owned()));
        }
        let own = ron_options().to_string(&settings).unwrap_or_default();
        self.check_keys(&own, steps, |text| {
            let settings = parsed(text)?;
            Validator::scene(&SceneFile { settings, ..SceneFile::default() }).map_err(|fault| fault.message)
        })
    }

    /// Whether there is a field, and values that are right by themselves and in the whole.
    fn check_keys(
        &self,
        own: &str,
        steps: &[&str],
        is_valid: impl Fn(&str) -> Result<(), String>,
    ) -> Result<(), Wrong> {
        for (i, step) in steps.iter().enumerate() {
            if text::get(own, &steps[..=i]).is_err() {
                let above = text::get(own, &steps[..i]).unwrap_or_default();
                let owner = std::iter::once(split(self.path).0).chain(steps[..i].iter().copied());
                let known = text::fields(above);
                let known: Vec<&str> = known.iter().map(String::as_str).collect();
                return Err(self.no_field(&owner.collect::<Vec<_>>().join("."), step, &known));
            }
        }
        let present = text::get(own, steps).unwrap_or_default();
        for (key, (_, value)) in self.keys.iter().enumerate() {
            let at = vec![Step::Key("keys".into()), Step::Index(key), Step::Index(1)];
            let text = written(present, &value.numbers()[..value.count()]).map_err(|wanted| Wrong {
                at: at.clone(),
                kind: Kind::WrongType,
                message: format!("key {key}: `{}` wants {wanted}", self.path),
                help: Some(format!("it is {present} without the track")),
            })?;
            let whole = text::replace(own, steps, &text).unwrap_or_default();
            is_valid(&whole).map_err(|fault| Wrong {
                at,
                kind: Kind::BadValue,
                message: format!("key {key}: `{}` cannot be {text}: {fault}", self.path),
                help: None,
            })?;
        }
        Ok(())
    }

    /// Whether a component with the text is one that files may have.
    fn component_fault(&self, name: &str, text: &str) -> Result<(), String> {
        let mut file = OverrideFile::default();
        match name {
            "light" => file.light = Some(parsed(text)?),
            "camera" => file.camera = Some(parsed(text)?),
            "clpv" => file.clpv = Some(parsed(text)?),
            "vpl" => file.vpl = Some(parsed(text)?),
            "slc" => file.slc = Some(parsed(text)?),
            "fog" => file.fog = Some(parsed(text)?),
            "particles" => file.particles = Some(parsed(text)?),
            own => {
                let types = self.world.ecs.get_resource::<ComponentTypes>();
                let known = types.and_then(|types| types.get(own));
                return known.map_or(Ok(()), |known| known.check(text).map_err(|fault| fault.code.to_string()));
            }
        }
        Validator::lone_components(&file, Vec::new()).map_err(|fault| fault.message)
    }

    /// Whether the entity has what a path without text is about.
    fn check_surface(&self, component: &str) -> Result<(), Wrong> {
        let ecs = &self.world.ecs;
        let has = match component {
            "light" => ecs.get::<Light>(self.entity).is_some(),
            "camera" => ecs.get::<Camera>(self.entity).is_some(),
            "transform" => true,
            _ => ecs.get::<MeshRenderer>(self.entity).is_some(),
        };
        if has { Ok(()) } else { Err(self.no_component(component)) }
    }

    fn no_component(&self, component: &str) -> Wrong {
        let kinds = self.world.ecs.get_resource::<FieldTypes>().cloned().unwrap_or_default();
        let mut known = kinds.of(&self.world.ecs, self.entity);
        if self.world.ecs.get::<MeshRenderer>(self.entity).is_some() {
            known.extend(["material", "mesh"]);
        }
        known.extend([SCENE, "transform"]);
        let message = format!("`{}` has no `{component}` whose fields a track could change", self.name());
        Wrong::target(message, suggestion(component, known))
    }

    fn no_field(&self, owner: &str, field: &str, known: &[&str]) -> Wrong {
        let message = match (known.is_empty(), field.is_empty()) {
            (true, _) => format!("`{owner}` has no fields, so no `{field}`"),
            (_, true) => format!("`{owner}` is no field: name one of its fields"),
            _ => format!("`{owner}` of `{}` has no field `{field}`", self.name()),
        };
        Wrong::target(message, suggestion(field, known.iter().copied()))
    }

    fn name(&self) -> &str {
        if split(self.path).0 == SCENE { SCENE } else { self.world.name(self.entity) }
    }
}

fn parsed<T: DeserializeOwned>(text: &str) -> Result<T, String> {
    ron_options().from_str(text).map_err(|fault| fault.code.to_string())
}
