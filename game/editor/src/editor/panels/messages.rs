//! Console, errors, help.

use crate::editor::Editor;
use crate::editor::console::{self, Record};
use crate::editor::keys::{KEYS, MOUSE, WITHOUT_MOUSE};
use crate::editor::layout::ERROR;
use crate::editor::stage::Stage;
use egui::{Color32, RichText, Ui};
use log::Level;

/// Levels that are not shown.
#[derive(Clone, Copy, Debug, Default)]
pub struct Hide {
    warnings: bool,
    notes: bool,
}

/// What was logged.
pub fn console(ui: &mut Ui, editor: &mut Editor, stage: &Stage) {
    let state = &mut editor.panels;
    ui.horizontal(|ui| {
        let filter = egui::TextEdit::singleline(&mut state.filter).hint_text("filter").desired_width(160.0);
        let response = ui.add(filter);
        crate::editor::widgets::named(&response, "Filter");
        let [mut warnings, mut notes] = [!state.hide.warnings, !state.hide.notes];
        ui.checkbox(&mut warnings, "warnings");
        ui.checkbox(&mut notes, "notes");
        state.hide = Hide { warnings: !warnings, notes: !notes };
        if ui.button("Clear").clicked() {
            console::clear();
        }
        if ui.button("Copy").clicked() {
            let lines = stage.facts.log.iter().map(|r| format!("{}: {}", r.level, r.text));
            ui.ctx().copy_text(lines.collect::<Vec<_>>().join("\n"));
        }
    });
    let filter = state.filter.to_lowercase();
    let shown = |record: &&Record| {
        let hidden = match record.level {
            Level::Error => false,
            Level::Warn => state.hide.warnings,
            _ => state.hide.notes,
        };
        !hidden && (filter.is_empty() || record.text.to_lowercase().contains(&filter))
    };
    for record in stage.facts.log.iter().rev().filter(shown).take(200) {
        let color = match record.level {
            Level::Error => ERROR,
            Level::Warn => WARNING,
            _ => ui.visuals().text_color(),
        };
        let times = if record.times > 1 { format!(" (×{})", record.times) } else { String::new() };
        ui.label(RichText::new(format!("{}{times}", record.text)).monospace().color(color))
            .on_hover_text(&record.target);
    }
}

/// What is wrong just now, with file and line, and what of the scene does not show.
pub fn errors(ui: &mut Ui, stage: &Stage) {
    let warnings = stage.warnings();
    if stage.facts.errors.is_empty() && warnings.is_empty() {
        ui.weak("Nothing is wrong.");
    }
    if !stage.facts.errors.is_empty() {
        ui.label("The last good version is running.");
    }
    for error in stage.facts.errors {
        ui.separator();
        ui.horizontal_top(|ui| {
            if ui.button("Copy").clicked() {
                ui.ctx().copy_text(error.clone());
            }
            ui.label(RichText::new(error).monospace().color(ERROR));
        });
    }
    for warning in warnings {
        ui.separator();
        ui.label(RichText::new(warning).monospace().color(WARNING));
    }
    for remark in stage.files.library.remarks() {
        ui.separator();
        ui.weak(remark);
    }
}

/// Colour of warnings.
const WARNING: Color32 = Color32::from_rgb(255, 200, 90);

/// Keys and mouse.
pub fn help(ui: &mut Ui) {
    egui::Grid::new("keys").striped(true).show(ui, |ui| {
        for (what, meaning) in MOUSE {
            ui.strong(what);
            ui.label(meaning);
            ui.end_row();
        }
        for (what, meaning) in WITHOUT_MOUSE {
            ui.strong(what);
            ui.label(meaning);
            ui.end_row();
        }
        for (modifiers, key, _, meaning) in KEYS {
            let mut text = String::new();
            if modifiers.command {
                text += "Ctrl+";
            }
            if modifiers.shift {
                text += "Shift+";
            }
            ui.strong(text + key.name());
            ui.label(meaning);
            ui.end_row();
        }
    });
}
