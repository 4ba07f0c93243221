//! What the panels ask of the player: saving, loading, pictures.

use super::player::Player;
use crate::editor::clock::PlayClock;
use crate::editor::{PlayRequest, Request};
use anyhow::{Context, Result};
use lightwell::scene::SceneId;
use lightwell::{gpu, measure};
use lightwell_runtime::say;
use lightwell_runtime::watch::SceneWatcher;
use std::path::{Path, PathBuf};

/// Whether a game that plays is ended for it.
fn needs_edited_world(request: &Request) -> bool {
    matches!(request, Request::Open(_) | Request::Reload | Request::Export(_))
}

impl Player {
    /// Does what the panels ask for.
    pub(super) fn answer(&mut self, request: Request) {
        self.stale = true;
        if self.play.is_some() && needs_edited_world(&request) {
            self.answer_play(PlayRequest::Stop);
            // The game ends once no picture is being drawn.
            if self.play.is_some() {
                return self.waiting.push(request);
            }
        }
        match request {
            Request::Save => self.save(),
            Request::SaveAs(path) => self.save_as(&path),
            Request::Reload => self.reload(),
            Request::Open(path) => self.open_scene(&path),
            Request::Quit => self.ended = true,
            Request::Screenshot => match self.save_screenshot() {
                Ok(path) => self.editor.tell(format!("saved {}", path.display()), false),
                Err(error) => self.editor.tell(format!("no screenshot: {error:#}"), true),
            },
            // Before the first picture there is nothing to click on yet.
            Request::Pick { .. } if self.picture.objects.is_none() && !self.render_thread.is_idle() => {
                self.waiting.push(request);
            }
            Request::Pick { pixel, add } => match self.seen_at(pixel) {
                Ok(id) => {
                    let exact = self.ui.context.input(|i| i.modifiers.alt);
                    let world = self.play.as_ref().map_or(self.session.world(), |play| &play.playing.game().world);
                    self.editor.picked(world, id, add, exact);
                }
                Err(error) => self.editor.tell(format!("{error:#}"), true),
            },
            Request::RebuildShaders => {
                let count = self.session.gpu.shaders.reload_all().len();
                self.editor.tell(format!("{count} shaders in use were read and compiled anew"), false);
            }
            // What is drawn lies with the thread that draws.
            Request::Target(_) if !self.render_thread.is_idle() => {
                self.waiting.retain(|other| !matches!(other, Request::Target(_)));
                self.waiting.push(request);
            }
            Request::Target(choice) => {
                let result = self.session.target(&choice.name, choice.mip, choice.layer);
                self.editor.set_target(result.map_err(|error| format!("{}: {error:#}", choice.name)));
            }
            Request::Export(export) => self.begin_export(export),
            Request::CancelExport => self.cancel_export(),
            Request::Play(request) => self.answer_play(request),
        }
    }

    fn save(&mut self) {
        let path = self.session.path().to_owned();
        if !path.to_string_lossy().ends_with(".scene.ron") {
            return self.editor.ask_save_as(&path);
        }
        match self.session.save(&path) {
            Ok(()) => {
                self.watcher.saved();
                self.editor.scene_history().mark_saved();
                self.editor.tell(format!("saved {}", path.display()), false);
            }
            Err(error) => self.editor.tell(format!("not saved: {error:#}"), true),
        }
        self.set_title();
    }

    fn save_as(&mut self, path: &Path) {
        let before = self.session.path().to_owned();
        match self.session.save_as(path) {
            Ok(()) => {
                self.note();
                let moved = self.editor.saved_as(&self.session.parts().files, &before);
                if let Err(error) = moved {
                    self.editor.tell(format!("{error:#}"), true);
                }
                self.watcher = SceneWatcher::new(path, &self.session.watched_files());
                self.editor.scene_history().mark_saved();
                self.memory.played(path);
                self.editor.recent.clone_from(&self.memory.recent);
                self.editor.tell(format!("saved {}", path.display()), false);
            }
            Err(error) => self.editor.tell(format!("not saved: {error:#}"), true),
        }
        self.set_title();
    }

    fn reload(&mut self) {
        self.scene_error = match self.read_anew() {
            Ok(()) => {
                self.clock.follow(&self.session.settings());
                self.watcher.follow(&self.session.watched_files());
                self.editor.tell("the scene was loaded anew", false);
                None
            }
            Err(error) => {
                // What it needed may come later.
                self.watcher.follow(&self.session.watched_files());
                self.watcher.failed();
                log::error!("{error:#}");
                Some(format!("{error:#}"))
            }
        };
    }

    fn read_anew(&mut self) -> Result<()> {
        let before = self.editor.before_reload(self.session.parts().world)?;
        let result = self.session.reload();
        let world = self.session.parts().world;
        match result {
            Ok(()) => self.editor.reloaded(world, before),
            Err(error) => {
                self.editor.not_reloaded(world, before);
                Err(error)
            }
        }
    }

    fn open_scene(&mut self, path: &Path) {
        self.note();
        match self.session.open_other(path) {
            Ok(()) => {
                lightwell::files::remove_leftovers(path);
                self.watcher = SceneWatcher::new(path, &self.session.watched_files());
                self.clock = PlayClock::new(&self.session.settings());
                self.editor.loaded();
                self.scene_error = None;
                self.opened();
            }
            Err(error) => self.editor.tell(format!("{error:#}"), true),
        }
    }

    pub(super) fn set_title(&self) {
        self.window.set_title(&format!("{} - Lightwell", self.session.name()));
    }

    /// What is seen at a pixel of the picture.
    fn seen_at(&self, pixel: [u32; 2]) -> Result<Option<SceneId>> {
        let objects = self.picture.objects.as_ref();
        let objects = objects.context("nothing is drawn here that tells what it shows; pick in a drawn picture")?;
        objects.seen_at(&self.session.gpu, self.session.scene(), pixel)
    }

    fn save_screenshot(&self) -> Result<PathBuf> {
        let folder = Path::new("out");
        std::fs::create_dir_all(folder).context("cannot make the folder out")?;
        let name = self.session.name();
        let files = (1..10_000).map(|number| folder.join(format!("{name}_screenshot_{number:04}.png")));
        let path = files.into_iter().find(|path| !path.exists()).context("the folder out is full of screenshots")?;
        let shown = self.picture.shown.as_ref().context("nothing is drawn yet")?;
        let bytes = gpu::read_texture(&self.session.gpu, shown, 0, 0)?;
        let rgb: Vec<u8> = bytes.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
        measure::write_png_rgb8(&path, [shown.width(), shown.height()], &rgb)?;
        say!("saved {}", path.display());
        Ok(path)
    }
}
