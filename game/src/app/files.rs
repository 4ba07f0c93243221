//! The files that a game loads: what `lightwell pack` asks for.

use super::{App, GameArgs, Hud, Sounds};
use anyhow::{Context, Result, bail};
use lightwell::files::{self, EditContext};
use lightwell::game::{CurrentScene, Game, InputScript, Time};
use lightwell::world::Transform;
use lightwell_runtime::cli::Common;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Prints the files, a line each.
pub(super) fn print(app: App, args: &GameArgs, script: Option<InputScript>) -> Result<()> {
    let found = list(app, args.scene.as_deref(), &script.unwrap_or_default(), &args.also, &args.common)?;
    found.iter().for_each(|path| lightwell_runtime::say!("{}", path.display()));
    Ok(())
}

/// The files that a game has loaded once the script is through, its first scene first, with files that it would load
/// later and what those name.
pub(super) fn list(
    app: App,
    scene: Option<&str>,
    script: &InputScript,
    also: &[PathBuf],
    common: &Common,
) -> Result<Vec<PathBuf>> {
    let actions = app.actions_path()?;
    let mut game = app.start_with(scene, &[], common)?;
    let first = absolute(&game.world.ecs.resource::<CurrentScene>().path);
    let mut found: BTreeSet<PathBuf> = actions.iter().map(|path| absolute(path)).collect();
    note(&mut game, &mut found)?;
    for step in 1..=script.steps {
        let place = || format!("step {step}");
        game.step(&script.at(step)).with_context(place)?;
        let delta = 1.0 / game.world.ecs.resource::<Time>().rate as f32;
        Hud::pass(&mut game, None, |game| game.frame(delta)).0.with_context(place)?;
        note(&mut game, &mut found).with_context(place)?;
        if game.has_ended() {
            break;
        }
    }
    for path in also {
        load(&mut game, path).with_context(|| format!("{} cannot be included", path.display()))?;
        found.insert(absolute(path));
    }
    found.extend(game.files());
    found.remove(&first);
    Ok(std::iter::once(first).chain(found).collect())
}

fn absolute(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_owned())
}

/// Notes the present scene, and the sounds that were asked for.
fn note(game: &mut Game, found: &mut BTreeSet<PathBuf>) -> Result<()> {
    let scene = game.world.ecs.resource::<CurrentScene>().clone();
    found.insert(absolute(&scene.path));
    for (name, _) in game.world.ecs.resource_mut::<Sounds>().take() {
        let path = scene.beside(&name);
        if !path.is_file() {
            bail!(
                "in {} the game plays the sound `{name}`, and there is no file {}; put it there, or correct its name where \
                 a system plays it",
                scene.path.display(),
                path.display()
            );
        }
        found.insert(absolute(&path));
    }
    Ok(())
}

/// Loads a file that no scene names, with what it names itself.
fn load(game: &mut Game, path: &Path) -> Result<()> {
    let scene = game.world.ecs.resource::<CurrentScene>().path.clone();
    let name = path.to_string_lossy().to_lowercase();
    let (world, library, options) = game.parts();
    if name.ends_with(".scene.ron") {
        files::load_scene(path, library, options)?;
    } else if name.ends_with(".prefab.ron") {
        let entity = world.ecs.spawn_empty().id();
        let mut context = EditContext { library, options, path: &scene };
        files::spawn_prefab_onto(world, &mut context, entity, &absolute(path).to_string_lossy(), Transform::default())?;
    } else if name.ends_with(".gltf") || name.ends_with(".glb") {
        library.gltf(path)?;
    }
    Ok(())
}
