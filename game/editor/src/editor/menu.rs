//! The bar of menus and of play, and the line of state.

use super::Editor;
use super::gizmo::Mode;
use super::keys::{Action, act, text_of};
use super::layout::{ERROR, PANES};
use super::stage::{PlayFacts, Request, Stage, Working};
use egui::containers::menu::{MenuButton, MenuConfig};
use egui::{Button, DragValue, Panel, PopupCloseBehavior, RichText, Ui};
use lightwell::render::debug::DebugView;
use std::time::Duration;

/// The bar on top.
pub fn bar(ui: &mut Ui, editor: &mut Editor, stage: &mut Stage) {
    Panel::top("bar").show(ui, |ui| {
        ui.horizontal_wrapped(|ui| {
            ui.menu_button("File", |ui| file(ui, editor, stage));
            ui.menu_button("Edit", |ui| edit(ui, editor, stage));
            ui.menu_button("Add", |ui| super::hierarchy::add_menu(ui, editor, stage, None));
            // Several things are switched at a time here.
            let stays = MenuConfig::new().close_behavior(PopupCloseBehavior::CloseOnClickOutside);
            ui.menu_button("Game", |ui| game_menu(ui, editor, stage));
            MenuButton::new("Panels").config(stays.clone()).ui(ui, |ui| panels(ui, editor));
            MenuButton::new("Debug").config(stays).ui(ui, |ui| debug(ui, stage));
            ui.separator();
            game(ui, editor, stage);
            ui.separator();
            if stage.facts.playing.is_none() {
                preview(ui, editor, stage);
                ui.separator();
            }
            gizmos(ui, editor);
        });
    });
}

/// An entry of a menu with its key.
fn entry(ui: &mut Ui, editor: &mut Editor, stage: &mut Stage, text: &str, action: Action, enabled: bool) {
    let button = Button::new(text).shortcut_text(text_of(action));
    if ui.add_enabled(enabled, button).clicked() {
        act(editor, stage, action);
        ui.close();
    }
}

fn file(ui: &mut Ui, editor: &mut Editor, stage: &mut Stage) {
    entry(ui, editor, stage, "Save", Action::Save, true);
    entry(ui, editor, stage, "Save as…", Action::SaveAs, true);
    if ui.add_enabled(editor.is_dirty(), Button::new("Revert")).clicked() {
        editor.ask(Request::Reload);
        ui.close();
    }
    ui.separator();
    entry(ui, editor, stage, "Open…", Action::Open, true);
    ui.menu_button("Open recent", |ui| {
        for path in editor.recent.clone() {
            if ui.button(path.display().to_string()).clicked() {
                editor.ask(Request::Open(path));
                ui.close();
            }
        }
    });
    ui.separator();
    if ui.button("Export the animation…").clicked() {
        super::dialogs::ask_export(editor, stage);
        ui.close();
    }
    entry(ui, editor, stage, "Screenshot", Action::Screenshot, true);
    if ui.button("Rebuild shaders").on_hover_text("read and compile all shaders anew").clicked() {
        editor.requests.push(Request::RebuildShaders);
        ui.close();
    }
    ui.separator();
    entry(ui, editor, stage, "Quit", Action::Quit, true);
}

fn edit(ui: &mut Ui, editor: &mut Editor, stage: &mut Stage) {
    let undo = editor.history.undo_label().map(str::to_owned);
    let redo = editor.history.redo_label().map(str::to_owned);
    let text = |word: &str, label: &Option<String>| match label {
        Some(label) => format!("{word}: {label}"),
        None => word.to_owned(),
    };
    entry(ui, editor, stage, &text("Undo", &undo), Action::Undo, undo.is_some());
    entry(ui, editor, stage, &text("Redo", &redo), Action::Redo, redo.is_some());
    ui.separator();
    edit_entries(ui, editor, stage);
}

/// What can be done with the selection.
pub fn edit_entries(ui: &mut Ui, editor: &mut Editor, stage: &mut Stage) {
    let any = !editor.selection.is_empty();
    entry(ui, editor, stage, "Duplicate", Action::Duplicate, any);
    entry(ui, editor, stage, "Delete", Action::Delete, any);
    entry(ui, editor, stage, "Focus", Action::Focus, any);
    ui.separator();
    let instance = editor.selected(stage.world).last().copied();
    let is_instance = instance.is_some_and(|(_, e)| lightwell::files::prefab_of(stage.world, e).is_some());
    if ui.add_enabled(any, Button::new("Make a prefab…")).clicked() {
        super::dialogs::ask_prefab(editor, stage);
        ui.close();
    }
    let apply = Button::new("Apply to the prefab");
    let help = "writes what this instance has become into the prefab's file";
    if ui.add_enabled(is_instance, apply).on_hover_text(help).clicked() {
        match editor.apply_prefab(stage) {
            Ok(path) => editor.tell(format!("wrote {}", path.display()), false),
            Err(error) => editor.tell(format!("{error:#}"), true),
        }
        ui.close();
    }
    let help = "makes this instance plain entities of the scene";
    if ui.add_enabled(is_instance, Button::new("Break the prefab")).on_hover_text(help).clicked() {
        let result = editor.break_prefab(stage);
        editor.told(result);
        ui.close();
    }
}

/// What is drawn over the picture.
fn debug(ui: &mut Ui, stage: &mut Stage) {
    let debug = &mut stage.look.debug;
    for view in DebugView::ALL {
        let mut on = debug.views.contains(&view);
        let response = ui.checkbox(&mut on, view.name().replace('-', " ")).on_hover_text(view.help());
        if response.changed() {
            debug.views.retain(|known| *known != view);
            debug.views.extend(on.then_some(view));
        }
    }
    ui.separator();
    ui.horizontal(|ui| {
        ui.add(DragValue::new(&mut debug.cascade).range(0..=3).prefix("light volume "))
            .on_hover_text("whose cells light, blockers and voxels show; 0 is the finest");
        ui.add(DragValue::new(&mut debug.bvh_level).range(0..=48).prefix("bvh level "));
    });
    if ui.button("None").clicked() {
        debug.views.clear();
        debug.targets.clear();
        ui.close();
    }
}

fn panels(ui: &mut Ui, editor: &mut Editor) {
    for pane in PANES {
        let mut on = editor.layout.has(pane);
        if ui.checkbox(&mut on, pane.title()).changed() {
            editor.layout.toggle(pane);
        }
    }
    ui.separator();
    if ui.button("Usual layout").clicked() {
        editor.layout.reset();
        ui.close();
    }
    let mut zoom = ui.ctx().zoom_factor();
    ui.horizontal(|ui| {
        ui.label("Scale");
        for factor in [0.8, 1.0, 1.5, 2.0] {
            if ui.selectable_label(zoom == factor, format!("{factor}×")).clicked() {
                zoom = factor;
            }
        }
    });
    ui.ctx().set_zoom_factor(zoom);
    ui.weak("H hides all panels");
}

/// The colours of a game that plays, and of one that stands still.
pub const PLAYS: egui::Color32 = egui::Color32::from_rgb(70, 190, 110);
const PAUSED: egui::Color32 = egui::Color32::from_rgb(240, 190, 60);

impl PlayFacts<'_> {
    /// What it does, and the colour of that.
    pub(super) fn state(&self) -> (&'static str, egui::Color32) {
        if self.paused { ("paused", PAUSED) } else { ("playing", PLAYS) }
    }
}

/// A button with its key.
fn button(ui: &mut Ui, editor: &mut Editor, stage: &mut Stage, (text, help): (RichText, &str), action: Action) {
    if ui.button(text).on_hover_text(format!("{help} ({})", text_of(action))).clicked() {
        act(editor, stage, action);
    }
}

/// Plays the game: its systems, on a copy of the scene.
fn game(ui: &mut Ui, editor: &mut Editor, stage: &mut Stage) {
    let Some(playing) = stage.facts.playing else {
        let help = "play the game on a copy of the scene: its systems, with mouse and keyboard in the view. Stop brings the \
                    scene back as it is now";
        return button(ui, editor, stage, (RichText::new("▶ Play"), help), Action::Play);
    };
    let (state, color) = playing.state();
    let stop = RichText::new("⏹ Stop").color(color);
    button(ui, editor, stage, (stop, "end the game; the scene is as it was"), Action::Play);
    match playing.paused {
        true => button(ui, editor, stage, (RichText::new("▶ Resume"), "let the game go on"), Action::PauseGame),
        false => button(ui, editor, stage, (RichText::new("⏸ Pause"), "let the game stand still"), Action::PauseGame),
    }
    button(ui, editor, stage, (RichText::new("⏭ Step"), "pause, and let one step pass"), Action::StepGame);
    ui.colored_label(color, format!("{state} · {:.1} s · step {}", playing.seconds, playing.step));
}

fn game_menu(ui: &mut Ui, editor: &mut Editor, stage: &mut Stage) {
    let plays = stage.facts.playing.is_some();
    entry(ui, editor, stage, if plays { "Stop" } else { "Play" }, Action::Play, true);
    entry(ui, editor, stage, "Pause or resume", Action::PauseGame, plays);
    entry(ui, editor, stage, "One step", Action::StepGame, plays);
    ui.separator();
    let any = plays && !editor.selection.is_empty();
    entry(ui, editor, stage, "Apply the selection to the scene", Action::Apply, any);
}

/// Previews the animation of the edited scene.
fn preview(ui: &mut Ui, editor: &mut Editor, stage: &mut Stage) {
    ui.weak("Animation").on_hover_text("a preview of what moves by itself; it changes nothing of the scene");
    if ui.button("Rewind").clicked() {
        act(editor, stage, Action::Rewind);
    }
    let word = if stage.clock.playing { "Pause preview" } else { "Preview" };
    if ui.button(word).on_hover_text("Space").clicked() {
        act(editor, stage, Action::Pause);
    }
    if ui.button("Step").on_hover_text("one tick of the clock").clicked() {
        act(editor, stage, Action::Step);
    }
    let length = stage.clock.length_seconds();
    let mut seconds = stage.clock.seconds();
    // Rounded as text alone: a slider that rounds the value has changed it, and would stop the play.
    let slider = egui::Slider::new(&mut seconds, 0.0..=length.unwrap_or(60.0)).suffix(" s");
    let slider = slider.custom_formatter(|value, _| format!("{value:.2}"));
    let response = ui.add(slider).on_hover_text("time of the animation; the saved scene is the pose without it");
    super::widgets::named(&response, "Time");
    if response.changed() {
        stage.clock.playing = false;
        stage.clock.seek(seconds);
    }
    let speed = stage.clock.speed();
    if speed != 1.0 {
        ui.label(format!("×{speed}"));
    }
}

fn gizmos(ui: &mut Ui, editor: &mut Editor) {
    for (mode, text) in [(Mode::Move, "Move"), (Mode::Rotate, "Rotate"), (Mode::Scale, "Scale")] {
        if ui.selectable_label(editor.view.mode == mode, text).on_hover_text("gizmo in the view").clicked() {
            editor.view.mode = if editor.view.mode == mode { Mode::None } else { mode };
        }
    }
    ui.checkbox(&mut editor.view.local, "local").on_hover_text("along the axes of the entity itself, not the world's");
    ui.checkbox(&mut editor.view.snap, "snap").on_hover_text("in steps; Ctrl does so while it is held");
}

/// A message: its first line, and all of it on hover.
fn notice(ui: &mut Ui, text: &str, is_error: bool) {
    let line = text.lines().next().unwrap_or_default();
    let line = RichText::new(line);
    let line = if is_error { line.color(ERROR) } else { line };
    ui.add(egui::Label::new(line).truncate()).on_hover_text(text);
}

/// Pictures that take longer say so.
const LONG: Duration = Duration::from_millis(300);
/// How often what goes on is looked at.
const GLANCE: Duration = Duration::from_millis(400);

/// What goes on behind the panels, so that nobody takes waiting for doing nothing.
fn working(ui: &mut Ui, editor: &mut Editor, stage: &Stage) {
    let Working { picture, export } = stage.facts.working;
    let bar = |ui: &mut Ui, text: String, share: f32| {
        let bar = egui::ProgressBar::new(share).desired_width(150.0).text(text.clone());
        super::widgets::named(&ui.add(bar), &text);
    };
    if let Some((done, all)) = export {
        ui.separator();
        bar(ui, format!("exported {done} of {all}"), done as f32 / all.max(1) as f32);
        if ui.button("Cancel the export").on_hover_text("the frames that are written stay").clicked() {
            editor.requests.push(Request::CancelExport);
        }
        ui.ctx().request_repaint_after(GLANCE);
    } else if let Some((since, (done, all))) = picture {
        if since < LONG {
            return ui.ctx().request_repaint_after(LONG.saturating_sub(since));
        }
        ui.separator();
        let text = if all == 0 { "drawing…".to_owned() } else { format!("drawing {done} of {all}") };
        bar(ui, text, done as f32 / all.max(1) as f32);
        ui.ctx().request_repaint_after(GLANCE);
    }
}

/// The line at the bottom.
pub fn status(ui: &mut Ui, editor: &mut Editor, stage: &mut Stage) {
    Panel::bottom("status").show(ui, |ui| {
        ui.horizontal(|ui| {
            let mark = if editor.is_dirty() { " ●" } else { "" };
            ui.label(format!("{}{mark}", stage.facts.name)).on_hover_text(stage.files.path.display().to_string());
            ui.separator();
            if let Some(statistics) = stage.facts.profiler.frame_statistics() {
                ui.monospace(format!("{:.1} ms", statistics.median)).on_hover_text("median time of a frame");
            }
            if let Some(tracing) = stage.facts.tracing {
                ui.monospace(format!("{}/{} samples", tracing.samples, tracing.target));
            }
            if let Some(budget) = &stage.facts.budget {
                ui.separator();
                ui.label(budget).on_hover_text("size at which frames are drawn, and why (--fps)");
            }
            working(ui, editor, stage);
            ui.separator();
            if let Some(playing) = stage.facts.playing {
                let (state, color) = playing.state();
                let text = format!("{state}: edits are those of the game, and end with it");
                ui.colored_label(color, text).on_hover_text("Apply to scene keeps them; Save saves the edited scene");
                ui.separator();
            }
            match &editor.notice {
                Some((text, is_error, _)) => notice(ui, text, *is_error),
                None => drop(ui.weak("F1: help")),
            }
        });
    });
}
