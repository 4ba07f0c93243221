//! Files that change while a game runs in its window.

use anyhow::{Context, Result};
use lightwell::game::{Actions, CurrentScene, Game};
use lightwell_runtime::watch::{Change, SceneWatcher};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// How often parts are looked for that came since, such as prefabs.
const FOLLOW: Duration = Duration::from_secs(1);

/// Watches the scene that is played, what it was made from, and the table of actions.
pub struct Reloader {
    watcher: SceneWatcher,
    scene: PathBuf,
    actions: Option<PathBuf>,
    followed: Instant,
}

impl Reloader {
    /// For a game that was started, with the file of its table of actions.
    pub fn new(game: &Game, actions: Option<PathBuf>) -> Self {
        let actions = actions.map(|path| path.canonicalize().unwrap_or(path));
        let (watcher, scene) = watch(game, actions.as_deref());
        Self { watcher, scene, actions, followed: Instant::now() }
    }

    /// Takes up what changed since the last time; none if nothing did. A change of the scene's file alone goes into the
    /// scene as it stands; if prefabs, models or images changed, it restarts.
    pub fn poll(&mut self, game: &mut Game) -> Option<Result<()>> {
        if game.world.ecs.resource::<CurrentScene>().path != self.scene {
            (self.watcher, self.scene) = watch(game, self.actions.as_deref());
        } else if self.followed.elapsed() > FOLLOW {
            self.watcher.follow(&game.watched_files());
            self.followed = Instant::now();
        }
        let changes = self.watcher.changes();
        if changes.is_empty() {
            return None;
        }
        let is_actions = |change: &Change| matches!(change, Change::Part(path) if Some(path) == self.actions.as_ref());
        let actions = match &self.actions {
            Some(path) if changes.iter().any(is_actions) => read_actions(game, path),
            _ => Ok(()),
        };
        let has_part = changes.iter().any(|change| matches!(change, Change::Part(_)) && !is_actions(change));
        let scene = if has_part {
            game.reload_all()
        } else if changes.contains(&Change::Scene) {
            game.reload()
        } else {
            Ok(())
        };
        let result = actions.and(scene.map_err(Into::into));
        self.watcher.follow(&game.watched_files());
        if result.is_err() {
            // What it needed may come later.
            self.watcher.failed();
        } else {
            log::info!("the files of the game were read anew");
        }
        Some(result)
    }
}

fn read_actions(game: &mut Game, path: &Path) -> Result<()> {
    game.set_actions(Actions::read(path).context("the table of actions stays as it was")?);
    Ok(())
}

fn watch(game: &Game, actions: Option<&Path>) -> (SceneWatcher, PathBuf) {
    let scene = game.world.ecs.resource::<CurrentScene>().path.clone();
    let mut parts = game.watched_files();
    parts.extend(actions.map(Path::to_owned));
    (SceneWatcher::new(&scene, &parts), scene)
}
