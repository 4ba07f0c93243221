//! Custom components of files in the form in which the game writes them.

use super::custom_components::{ComponentTypes, CustomComponents};
use super::scene_file::{EntityFile, OverrideFile};
use crate::core::GiMethod;
use crate::files::error::{FileError, FileErrorKind as Kind};
use crate::files::ron::document::Document;
use crate::files::ron::renamed::RENAMED;
use crate::files::ron::suggest::suggestion;
use crate::files::ron::tree::Step;

/// Reads the components of a game in a file's entities once, and leaves them as the game writes them: equal values are
/// equal texts from then on.
pub(in crate::files) struct Canonical<'a> {
    pub types: &'a ComponentTypes,
    pub document: &'a Document,
    /// Nothing is logged: the file was read before.
    pub is_quiet: bool,
}

type Checked = Result<(), Box<FileError>>;

impl Canonical<'_> {
    /// Refuses a method of indirect light that is not registered.
    pub fn method(&self, gi: GiMethod) -> Checked {
        if self.types.methods().any(|known| known == gi) {
            return Ok(());
        }
        let at = [Step::Key("gi".into())];
        let message = format!("unknown variant `{}` of Gi: there is no such method of indirect light", gi.variant());
        let error = self.document.error(&at, Kind::UnknownVariant, message);
        let help = suggestion(gi.variant(), self.types.methods().map(GiMethod::variant));
        Err(Box::new(help.map_or(error.clone(), |help| error.with_help(help))))
    }

    /// All entities of a list.
    pub fn entities(&self, entities: &mut [EntityFile], at: &[Step]) -> Checked {
        for (index, entity) in entities.iter_mut().enumerate() {
            self.entity(entity, &with(at, Step::Index(index)))?;
        }
        Ok(())
    }

    /// An entity with all below it.
    pub fn entity(&self, entity: &mut EntityFile, at: &[Step]) -> Checked {
        self.components(&mut entity.components, at)?;
        for (path, patch) in &mut entity.overrides {
            let at = with(&with(at, Step::Key("overrides".into())), Step::Key(path.clone()));
            self.patch(patch, &at)?;
        }
        self.entities(&mut entity.children, &with(at, Step::Key("children".into())))
    }

    /// The overrides of an instance.
    pub fn patch(&self, patch: &mut OverrideFile, at: &[Step]) -> Checked {
        self.components(&mut patch.components, at)?;
        self.entities(&mut patch.children, &with(at, Step::Key("children".into())))
    }

    fn components(&self, components: &mut CustomComponents, at: &[Step]) -> Checked {
        let at = with(at, Step::Key("components".into()));
        self.rename(components);
        for (name, value) in components {
            let at = with(&at, Step::Key(name.clone()));
            match self.types.get(name) {
                Some(known) => match (known.canonical)(value.text()) {
                    Ok(text) => value.0 = text,
                    Err(error) => return Err(Box::new(self.document.inner_error(&at, value.text(), error))),
                },
                None if self.types.is_complete => return Err(Box::new(self.unknown(name, &at))),
                None if self.is_quiet => {}
                None => log::warn!("`{name}` is no component that this program knows; it is kept as it is written"),
            }
        }
        Ok(())
    }

    /// Gives components of older files the names that they have now; where a game's own types are not known, any of them
    /// may have the old name.
    fn rename(&self, components: &mut CustomComponents) {
        let is_old = |(old, new): &(&str, &str)| self.types.get(old).is_none() && self.types.get(new).is_some();
        for (old, new) in RENAMED.into_iter().filter(|pair| self.types.is_complete && is_old(pair)) {
            if let Some(value) = components.remove(old) {
                if !self.is_quiet {
                    log::info!("the component `{old}` is called `{new}` now");
                }
                components.entry(new.to_owned()).or_insert(value);
            }
        }
    }

    fn unknown(&self, name: &str, at: &[Step]) -> FileError {
        let message = format!("the game has no component `{name}`");
        let register = format!("register it before the scene is loaded: `.component::<{name}>()`");
        let near = suggestion(name, self.types.iter().map(|known| known.name));
        let help = near.map_or(register.clone(), |near| format!("{near} Or {register}"));
        self.document.error(at, Kind::UnknownName, message).with_help(help)
    }
}

fn with(at: &[Step], step: Step) -> Vec<Step> {
    at.iter().cloned().chain([step]).collect()
}
