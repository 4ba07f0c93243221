//! The context of edits of a loaded world: assets, the scene file, and a loader that borrows the world.

use crate::assets::AssetLibrary;
use crate::files::error::FileError;
use crate::files::format::canonical::Canonical;
use crate::files::load::loader::{Context, Loader};
use crate::files::load::options::LoadOptions;
use crate::files::load::source::SceneInfo;
use crate::files::ron::document::Document;
use crate::files::ron::steps::Fault;
use crate::files::ron::tree::Step;
use crate::world::GameWorld;
use std::path::Path;
use std::rc::Rc;

/// Where edits take their assets from, and the scene file that paths in them are relative to.
pub struct EditContext<'a> {
    /// Loaded assets.
    pub library: &'a mut AssetLibrary,
    /// Folder of models.
    pub options: &'a LoadOptions,
    /// The scene's file.
    pub path: &'a Path,
}

/// Reads components of a game.
pub(in crate::files) fn canonical(
    context: &EditContext,
    read: impl FnOnce(&Canonical) -> Result<(), Box<FileError>>,
) -> Result<(), FileError> {
    let document = Document::in_memory(context.path);
    read(&Canonical { types: &context.options.types, document: &document, is_quiet: false }).map_err(|error| *error)
}

/// Lends the world to a loader.
pub(in crate::files) fn with_loader<T>(
    world: &mut GameWorld,
    context: &mut EditContext,
    work: impl FnOnce(&mut Loader, &Rc<Context>) -> T,
) -> T {
    let info = world.ecs.remove_resource::<SceneInfo>().unwrap_or_default();
    let document = Document::in_memory(context.path);
    let file = Rc::new(Context { document, materials: info.materials.clone(), is_root: true });
    let lent = std::mem::take(world);
    let mut loader = Loader::new(context.library, context.options, lent, info, context.path);
    let result = work(&mut loader, &file);
    let Loader { world: lent, info, .. } = loader;
    *world = lent;
    world.ecs.insert_resource(info);
    result
}

pub(in crate::files) fn fault_error(path: &Path, fault: Fault) -> FileError {
    let words: Vec<String> = fault.path.iter().map(step_word).filter(|word| !word.is_empty()).collect();
    let place = if words.is_empty() { String::new() } else { format!("{}: ", words.join(".")) };
    let error = FileError::new(path, fault.kind, format!("{place}{}", fault.message));
    match fault.help.filter(|help| !help.is_empty()) {
        Some(help) => error.with_help(help),
        None => error,
    }
}

fn step_word(step: &Step) -> String {
    match step {
        Step::Key(key) => key.clone(),
        Step::Index(index) => index.to_string(),
    }
}
