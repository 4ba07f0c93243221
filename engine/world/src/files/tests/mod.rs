//! Tests of scene and prefab files.
#![allow(clippy::unwrap_used)]

mod bad;
mod clips;
mod fields;
mod former_variants;
mod grading;
mod hostile;
mod instances;
mod models;
mod preserved;
mod preserved_random;
mod repeats;
mod round_trip;
mod tracks;

use super::*;
use crate::assets::AssetLibrary;
use crate::world::{GameWorld, Name};
use bevy_ecs::prelude::Entity;
use std::path::{Path, PathBuf};

/// A folder of files made of texts.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new(files: &[(&str, &str)]) -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        for (name, text) in files {
            folder.write(name, text.as_bytes());
        }
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, bytes: &[u8]) {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }

    fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap()
    }

    fn load(&self, name: &str) -> Result<GameWorld, FileError> {
        load_scene(&self.path(name), &mut AssetLibrary::new(), &LoadOptions::default())
    }
}

/// The entity at a path of names.
fn at(world: &GameWorld, path: &str) -> Option<Entity> {
    let mut names = path.split('/');
    let first = names.next()?;
    let root = world.roots().into_iter().find(|e| world.ecs.get::<Name>(*e).is_some_and(|n| n.0 == first))?;
    names.try_fold(root, |parent, name| world.child(parent, name))
}

fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(name)
}
