//! A file's new text out of the one that is there.

use super::text::Defaults;
use crate::files::format::canonical::Canonical;
use crate::files::format::custom_components::ComponentTypes;
use crate::files::format::scene_file::{EntityFile, PrefabFile, SceneFile};
use crate::files::ron::document::{Document, ron_options};
use crate::files::ron::preserve::edited;
use crate::files::ron::steps::key;
use crate::files::ron::tree::Node;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::path::Path;

/// The contents of a file of entities.
pub(in crate::files) trait Root: Serialize + DeserializeOwned + Clone {
    fn entities(&mut self) -> &mut Vec<EntityFile>;
}

impl Root for SceneFile {
    fn entities(&mut self) -> &mut Vec<EntityFile> {
        &mut self.entities
    }
}

impl Root for PrefabFile {
    fn entities(&mut self) -> &mut Vec<EntityFile> {
        &mut self.entities
    }
}

/// The text of a file that says what is wanted: `base` with what differs. None if that does not read as such a file, or
/// cannot be made to say it.
pub(in crate::files) fn rewritten<T: Root>(
    base: &str,
    path: &Path,
    wanted: &T,
    types: &ComponentTypes,
) -> Option<String> {
    let (_, before) = meaning::<T>(base, path, types)?;
    let wanted = said(wanted.clone(), &Document::in_memory(path), types)?;
    if before == wanted {
        return Some(base.to_owned());
    }
    let defaults = Defaults::new(Some(types)).ok()?;
    let print = |holder: &str, own: &str, node: &Node| defaults.printed(holder, own, node);
    let text = edited(base, &Node::parse(&before), &Node::parse(&wanted), &print);
    let means_it = meaning::<T>(&text, path, types).is_some_and(|(_, now)| now == wanted);
    if !means_it {
        log::warn!("{}: the file is written anew, without its comments and its layout", path.display());
    }
    means_it.then_some(text)
}

/// The contents of a text, and the text that its writer would write for them, defaults included.
pub(in crate::files) fn meaning<T: Root>(text: &str, path: &Path, types: &ComponentTypes) -> Option<(T, String)> {
    let (document, file) = Document::parse::<T>(path, text.to_owned()).ok()?;
    Some((file.clone(), said(file, &document, types)?))
}

fn said<T: Root>(mut file: T, document: &Document, types: &ComponentTypes) -> Option<String> {
    let canonical = Canonical { types, document, is_quiet: true };
    canonical.entities(file.entities(), &[key("entities")]).ok()?;
    ron_options().to_string(&file).ok()
}
