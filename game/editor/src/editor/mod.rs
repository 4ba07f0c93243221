//! The editor of the window: panels around the view, edits with undo. It knows egui and the world, and neither the
//! device nor the window, so that tests click through it without either.

mod assets;
pub mod camera;
pub mod clock;
mod commands;
pub mod console;
mod custom_component;
mod dialogs;
mod docs;
mod fog;
mod gizmo;
mod hierarchy;
pub mod history;
mod inspector;
mod keys;
mod layout;
mod menu;
mod panels;
mod playing;
mod reload;
pub(crate) mod schema;
pub mod stage;
#[cfg(test)]
mod tests;
mod value;
mod view;
mod widgets;

pub use custom_component::CustomComponent;
pub use stage::{Export, Facts, PlayFacts, PlayRequest, Request, Stage, Tracing, Working};

use anyhow::Result;
use dialogs::Dialog;
use egui::Ui;
use history::History;
use lightwell::files::{SceneFile, edit_scene, rewrite_paths};
use lightwell::scene::SceneId;
use lightwell_runtime::session::Files;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// How long a message is shown.
const NOTICE: Duration = Duration::from_secs(6);

/// Adds signs that the usual font lacks from one that egui brings along.
pub fn set_fonts(context: &egui::Context) {
    let mut fonts = egui::FontDefinitions::default();
    let monospace = fonts.families.get(&egui::FontFamily::Monospace).cloned().unwrap_or_default();
    let proportional = fonts.families.entry(egui::FontFamily::Proportional).or_default();
    let missing: Vec<String> = monospace.into_iter().filter(|font| !proportional.contains(font)).collect();
    proportional.extend(missing);
    context.set_fonts(fonts);
}

/// Panels, selection and history of one window.
pub struct Editor {
    /// What is selected; the last one is the one that the inspector shows.
    pub selection: Vec<SceneId>,
    /// What was done.
    pub history: History,
    /// What the view shows.
    pub view: view::View,
    /// Whether the panels are hidden.
    pub hidden: bool,
    /// Files that were played last.
    pub recent: Vec<PathBuf>,
    kit: widgets::Kit,
    layout: layout::Layout,
    hierarchy: hierarchy::Hierarchy,
    panels: panels::State,
    dialog: Option<Dialog>,
    requests: Vec<Request>,
    notice: Option<(String, bool, Instant)>,
    /// Why the last change in the inspector was not made.
    problem: Option<String>,
    /// A drag goes on that makes entities anew.
    rebuilding: bool,
    /// What was done to the edited world, while `history` is that of the game that plays.
    resting: Option<History>,
}

impl Default for Editor {
    fn default() -> Self {
        Self {
            selection: Vec::new(),
            history: History::new(),
            view: view::View::default(),
            hidden: false,
            recent: Vec::new(),
            kit: widgets::Kit::default(),
            layout: layout::Layout::default(),
            hierarchy: hierarchy::Hierarchy::default(),
            panels: panels::State::default(),
            dialog: None,
            requests: Vec::new(),
            notice: None,
            problem: None,
            rebuilding: false,
            resting: None,
        }
    }
}

impl Editor {
    /// Sets the components of a game that are shown besides those of the engine.
    pub fn set_own(&mut self, own: Vec<CustomComponent>) {
        self.kit.add_own(own);
    }

    /// Shows everything; gives what the program is asked for.
    pub fn show(&mut self, ui: &mut Ui, stage: &mut Stage) -> Vec<Request> {
        self.prepare(stage);
        keys::take(ui, self, stage);
        if self.hidden {
            egui::CentralPanel::no_frame().show(ui, |ui| view::show(ui, self, stage));
        } else {
            menu::bar(ui, self, stage);
            menu::status(ui, self, stage);
            egui::CentralPanel::no_frame().show(ui, |ui| layout::show(ui, self, stage));
        }
        dialogs::show(ui.ctx(), self, stage);
        view::take_dropped_files(ui, self, stage);
        self.end_of_frame(ui, stage);
        std::mem::take(&mut self.requests)
    }

    fn prepare(&mut self, stage: &mut Stage) {
        self.selection.retain(|id| stage.world.entity(*id).is_some());
        let scene = lightwell::files::describe_scene(stage.world);
        self.kit.materials = scene.materials.into_keys().collect();
        let folder = commands::folder_of(stage.files.path).to_owned();
        self.kit.folders = stage.files.options.models.iter().cloned().chain([folder]).collect();
    }

    fn end_of_frame(&mut self, ui: &Ui, stage: &mut Stage) {
        let busy = ui.input(|i| i.pointer.any_down()) || ui.ctx().egui_wants_keyboard_input();
        self.rebuilding &= busy;
        if self.history.is_open() && !busy {
            let result = self.history.close(stage.world);
            self.told(result);
        }
        if let Some((_, _, since)) = &self.notice {
            match NOTICE.checked_sub(since.elapsed()) {
                Some(left) => ui.ctx().request_repaint_after(left),
                None => self.notice = None,
            }
        }
    }

    /// Selects one thing alone.
    pub fn select_only(&mut self, id: SceneId) {
        self.selection = vec![id];
        self.hierarchy.reveal = true;
    }

    /// Adds to the selection, or takes out of it.
    pub fn toggle(&mut self, id: SceneId) {
        match self.selection.iter().position(|known| *known == id) {
            Some(index) => drop(self.selection.remove(index)),
            None => self.selection.push(id),
        }
        self.hierarchy.reveal = true;
    }

    /// Shows what went well or wrong.
    pub fn tell(&mut self, text: impl Into<String>, is_error: bool) {
        let text = text.into();
        let level = if is_error { log::Level::Error } else { log::Level::Info };
        console::keep(level, "lightwell::editor", text.clone());
        self.notice = Some((text, is_error, Instant::now()));
    }

    /// Shows what went wrong, if something did.
    fn told(&mut self, result: Result<()>) {
        if let Err(error) = result {
            self.tell(format!("{error:#}"), true);
        }
    }

    /// Takes the last step back.
    pub fn undo(&mut self, stage: &mut Stage) {
        self.problem = None;
        match self.history.undo(stage) {
            Ok(Some(label)) => self.tell(format!("undone: {label}"), false),
            Ok(None) => self.tell("there is nothing to undo", false),
            Err(error) => self.tell(format!("cannot undo: {error:#}"), true),
        }
    }

    /// Does the last step again that was taken back.
    pub fn redo(&mut self, stage: &mut Stage) {
        self.problem = None;
        match self.history.redo(stage) {
            Ok(Some(label)) => self.tell(format!("done again: {label}"), false),
            Ok(None) => self.tell("there is nothing to do again", false),
            Err(error) => self.tell(format!("cannot do it again: {error:#}"), true),
        }
    }

    /// Changes what belongs to the scene as a whole.
    ///
    /// # Errors
    /// If a value is wrong; nothing changes then.
    pub fn edit_scene(&mut self, stage: &mut Stage, now: &SceneFile) -> Result<()> {
        self.history.open_scene(stage, "change the scene")?;
        edit_scene(stage.world, &mut stage.files.context(), now)?;
        stage.clock.follow(&now.settings);
        Ok(())
    }

    /// The scene was saved in another folder: what undo brings back is to find its files from there.
    ///
    /// # Errors
    /// If there is no way to one of them.
    pub fn saved_as(&mut self, files: &Files, before: &Path) -> Result<()> {
        let (now, options) = (files.path, files.options);
        self.scene_history().for_each_scene(&mut |scene| Ok(rewrite_paths(scene, before, now, options)?))
    }

    /// The scene is another one now.
    pub fn loaded(&mut self) {
        self.history = History::new();
        self.selection.clear();
        self.problem = None;
        self.view.drag = None;
    }

    /// Asks for something that loses edits; at once if there are none.
    pub fn ask(&mut self, request: Request) {
        match self.is_dirty() {
            true => self.dialog = Some(Dialog::Unsaved(request)),
            false => self.requests.push(request),
        }
    }

    /// The scene's file changed on disk, or the named part of it: asks if that would lose edits.
    pub fn file_changed(&mut self, part: Option<String>) -> Option<Request> {
        if self.is_dirty() {
            self.dialog = Some(Dialog::Changed(part));
            return None;
        }
        Some(Request::Reload)
    }

    /// Asks for a name to save under.
    pub fn ask_save_as(&mut self, path: &std::path::Path) {
        dialogs::ask_save_as(self, path);
    }

    /// What is remembered over runs.
    pub fn layout_text(&self) -> Option<String> {
        self.layout.text()
    }

    /// Takes over what an earlier run remembered; what cannot be read is passed over.
    pub fn restore_layout(&mut self, text: &str) {
        self.layout.restore(text);
    }
}
