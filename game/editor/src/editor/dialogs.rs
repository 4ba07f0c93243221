//! Questions that wait for an answer.

use super::Editor;
use super::commands::folder_of;
use super::stage::{Export, Request, Stage};
use egui::{Context, Modal, TextEdit, Ui};
use std::path::{Path, PathBuf};

/// A question.
#[derive(Clone, Debug, PartialEq)]
pub enum Dialog {
    /// Edits would be lost.
    Unsaved(Request),
    /// The scene's file, or the named part of it, changed on disk while there are edits.
    Changed(Option<String>),
    /// Under which name to save.
    SaveAs(String),
    /// Which scene to play.
    Open(String),
    /// Where to write a prefab.
    Prefab(String),
    /// What to export.
    Export(Export, String),
}

/// Asks for a name to save under.
pub fn ask_save_as(editor: &mut Editor, path: &Path) {
    let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    let stem = name
        .trim_end_matches(".scene.ron")
        .trim_end_matches(".prefab.ron")
        .trim_end_matches(".gltf")
        .trim_end_matches(".glb");
    let new = folder_of(path).join(format!("{stem}_edited.scene.ron"));
    editor.dialog = Some(Dialog::SaveAs(new.display().to_string()));
}

/// Asks for a scene to play.
pub fn ask_open(editor: &mut Editor, stage: &Stage) {
    editor.dialog = Some(Dialog::Open(folder_of(stage.files.path).display().to_string()));
}

/// Asks where to write a prefab of the selection.
pub fn ask_prefab(editor: &mut Editor, stage: &Stage) {
    let Some((_, entity)) = editor.selected(stage.world).last().copied() else { return };
    let name = stage.world.name(entity).to_lowercase().replace([' ', '/'], "_");
    let path = folder_of(stage.files.path).join("../prefabs").join(format!("{name}.prefab.ron"));
    editor.dialog = Some(Dialog::Prefab(path.display().to_string()));
}

/// Asks what to export.
pub fn ask_export(editor: &mut Editor, stage: &Stage) {
    let rate = 30;
    let seconds = stage.clock.length_seconds().unwrap_or(2.0);
    let export = Export {
        folder: Path::new("out").join(stage.facts.name),
        size: stage.facts.image_size.map(|edge| edge.max(16) & !1),
        rate,
        frames: ((seconds * f64::from(rate)).round() as u64).max(1),
        video: false,
    };
    let folder = export.folder.display().to_string();
    editor.dialog = Some(Dialog::Export(export, folder));
}

/// Shows the question that waits.
pub fn show(context: &Context, editor: &mut Editor, stage: &mut Stage) {
    let Some(mut dialog) = editor.dialog.take() else { return };
    let before = dialog.clone();
    let response = Modal::new(egui::Id::unique("question")).show(context, |ui| {
        ui.set_width(460.0);
        match &mut dialog {
            Dialog::Unsaved(request) => unsaved(ui, editor, request),
            Dialog::Changed(part) => changed(ui, editor, part.as_deref()),
            Dialog::SaveAs(text) => save_as(ui, editor, text),
            Dialog::Open(text) => open(ui, editor, text),
            Dialog::Prefab(text) => prefab(ui, editor, stage, text),
            Dialog::Export(export, folder) => export_ui(ui, editor, export, folder),
        }
    });
    // Escape or a click beside it closes it; an answer may have asked the next question.
    if !response.inner && !response.should_close() && editor.dialog.is_none() {
        editor.dialog = Some(dialog);
    } else if editor.dialog.is_none() && matches!(before, Dialog::Changed(_)) && !response.inner {
        editor.dialog = Some(before);
    }
}

/// Each gives whether it was answered.
fn unsaved(ui: &mut Ui, editor: &mut Editor, request: &Request) -> bool {
    ui.heading("There are changes that are not saved");
    ui.label("They are lost if you go on.");
    let mut done = false;
    ui.horizontal(|ui| {
        if ui.button("Save and go on").clicked() {
            editor.requests.extend([Request::Save, request.clone()]);
            done = true;
        }
        if ui.button("Discard").clicked() {
            editor.requests.push(request.clone());
            done = true;
        }
        done |= ui.button("Cancel").clicked();
    });
    done
}

fn changed(ui: &mut Ui, editor: &mut Editor, part: Option<&str>) -> bool {
    ui.heading(format!("{} was changed by another program", part.unwrap_or("The scene's file")));
    ui.label("There are changes here that are not saved, too.");
    let mut done = false;
    ui.horizontal(|ui| {
        let help = match part {
            Some(_) => "it is read when the scene is loaded the next time",
            None => "the next save overwrites the file; a backup is kept",
        };
        if ui.button("Keep mine").on_hover_text(help).clicked() {
            done = true;
        }
        if part.is_some() && ui.button("Save mine and load it").clicked() {
            editor.requests.extend([Request::Save, Request::Reload]);
            done = true;
        }
        if ui
            .button("Load the file")
            .on_hover_text("in place of what was changed here; undo brings that back")
            .clicked()
        {
            editor.requests.push(Request::Reload);
            done = true;
        }
    });
    done
}

fn save_as(ui: &mut Ui, editor: &mut Editor, text: &mut String) -> bool {
    ui.heading("Save as");
    let entered = path_field(ui, text);
    let path = PathBuf::from(text.trim());
    let fits = text.trim().ends_with(".scene.ron");
    if !fits {
        ui.weak("The name must end with .scene.ron");
    } else if path.exists() {
        ui.colored_label(ui.visuals().warn_fg_color, "This file is there already; it is kept as .bak");
    }
    if !folder_of(&path).is_dir() {
        ui.colored_label(ui.visuals().warn_fg_color, format!("There is no folder {}", folder_of(&path).display()));
    }
    answer(ui, "Save", fits && folder_of(&path).is_dir(), entered, || editor.requests.push(Request::SaveAs(path)))
}

fn open(ui: &mut Ui, editor: &mut Editor, text: &mut String) -> bool {
    ui.heading("Open");
    let entered = path_field(ui, text);
    let path = PathBuf::from(text.trim());
    let folder = if path.is_dir() { path.clone() } else { folder_of(&path).to_owned() };
    egui::ScrollArea::vertical().max_height(240.0).show(ui, |ui| {
        for file in super::assets::find(std::slice::from_ref(&folder), &["scene.ron", "gltf", "glb"]) {
            if ui.selectable_label(path.ends_with(&file), &file).clicked() {
                *text = folder.join(&file).display().to_string();
            }
        }
    });
    let mut asked = None;
    let done = answer(ui, "Open", path.is_file(), entered, || asked = Some(Request::Open(path)));
    if let Some(request) = asked {
        editor.ask(request);
    }
    done
}

fn prefab(ui: &mut Ui, editor: &mut Editor, stage: &mut Stage, text: &mut String) -> bool {
    ui.heading("Make a prefab of the selection");
    ui.label("The selected entity becomes an instance of it.");
    let entered = path_field(ui, text);
    let path = PathBuf::from(text.trim());
    let fits = text.trim().ends_with(".prefab.ron") && folder_of(&path).is_dir();
    if !fits {
        ui.weak("The name must end with .prefab.ron, and the folder must be there");
    }
    let mut wanted = false;
    let done = answer(ui, "Make", fits, entered, || wanted = true);
    if wanted {
        let result = editor.make_prefab(stage, &path);
        editor.told(result);
    }
    done
}

fn export_ui(ui: &mut Ui, editor: &mut Editor, export: &mut Export, folder: &mut String) -> bool {
    ui.heading("Export the animation");
    let entered = path_field(ui, folder);
    egui::Grid::new("export").show(ui, |ui| {
        ui.label("Width and height");
        ui.horizontal(|ui| {
            for (edge, name) in export.size.iter_mut().zip(["Width", "Height"]) {
                let response = ui.add(egui::DragValue::new(edge).range(16..=8192).suffix(" px"));
                super::widgets::named(&response, name);
            }
        });
        ui.end_row();
        ui.label("Frames a second");
        let response = ui.add(egui::DragValue::new(&mut export.rate).range(1..=240));
        super::widgets::named(&response, "Frames a second");
        ui.end_row();
        ui.label("Frames");
        ui.horizontal(|ui| {
            let response = ui.add(egui::DragValue::new(&mut export.frames).range(1..=100_000));
            super::widgets::named(&response, "Frames");
            let ([width, height], seconds) = (export.size, export.frames as f64 / f64::from(export.rate.max(1)));
            ui.weak(format!("{width} × {height} pixels, {seconds:.2} s of the animation"));
        });
        ui.end_row();
        ui.label("Video");
        let can = *editor.panels.ffmpeg.get_or_insert_with(super::panels::has_ffmpeg);
        let text = if can { "make one with ffmpeg" } else { "ffmpeg is not installed: images alone" };
        ui.add_enabled(can, egui::Checkbox::new(&mut export.video, text));
        ui.end_row();
    });
    ui.weak("Through the camera of the view, with its method of light, exposure and tone map.");
    export.folder = PathBuf::from(folder.trim());
    let wanted = export.clone();
    answer(ui, "Export", !folder.trim().is_empty(), entered, || editor.requests.push(Request::Export(wanted)))
}

/// A line for a path; whether it was entered.
fn path_field(ui: &mut Ui, text: &mut String) -> bool {
    let response = ui.add(TextEdit::singleline(text).desired_width(f32::INFINITY));
    super::widgets::named(&response, "Path");
    // Asked for before the focus comes back, with which nothing has lost it.
    let entered = response.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter));
    // Typing can begin at once.
    if !entered && ui.memory(|memory| memory.focused().is_none()) {
        response.request_focus();
    }
    entered
}

fn answer(ui: &mut Ui, word: &str, can: bool, entered: bool, work: impl FnOnce()) -> bool {
    let mut done = false;
    ui.horizontal(|ui| {
        let agreed = ui.add_enabled(can, egui::Button::new(word)).clicked() || entered && can;
        if agreed {
            work();
        }
        done = agreed || ui.button("Cancel").clicked();
    });
    done
}
