//! Widgets of text, of what has several forms, and of what has no shape.

use super::numbers::{angles, boolean, number, numbers};
use super::{Kit, named, title};
use crate::editor::docs::Note;
use crate::editor::schema::Shape;
use crate::editor::value::Value;
use egui::Ui;
use std::path::PathBuf;

impl Kit {
    pub(super) fn custom(&self, ui: &mut Ui, name: &str, key: &str, ty: &str, value: &mut Value, note: &Note) -> bool {
        if ty == "MaterialRef" {
            return self.material(ui, name, value);
        }
        match self.customs.get(ty) {
            Some((ty, Shape::Struct(_, fields))) if value.group.is_some() => self.fields(ui, ty, fields, value),
            Some(_) => self.text(ui, name, key, value),
            None => self.by_value(ui, name, key, value, note),
        }
    }

    pub(super) fn material(&self, ui: &mut Ui, name: &str, value: &mut Value) -> bool {
        let mut changed = false;
        let named_now = value.unquoted();
        let combo = egui::ComboBox::from_id_salt("material").selected_text(named_now.as_deref().unwrap_or("its own"));
        let response = combo.show_ui(ui, |ui| {
            if ui.selectable_label(named_now.is_none(), "its own").clicked() && named_now.is_some() {
                *value = Value::parse("()").unwrap_or_default();
                changed = true;
            }
            for material in &self.materials {
                let is_this = named_now.as_deref() == Some(material);
                if ui.selectable_label(is_this, material).clicked() && !is_this {
                    *value = Value::text(material);
                    changed = true;
                }
            }
        });
        named(&response.response, &title(name));
        if let (true, Some((ty, Shape::Struct(_, fields)))) = (value.group.is_some(), self.customs.get("MaterialRef")) {
            ui.vertical(|ui| changed |= self.fields(ui, ty, fields, value));
        }
        changed
    }

    /// Without a shape: what the value itself shows.
    pub(super) fn by_value(&self, ui: &mut Ui, name: &str, key: &str, value: &mut Value, note: &Note) -> bool {
        if key.ends_with(".rotation") {
            return angles(ui, name, value);
        }
        if value.number().is_some() {
            return number(ui, name, value, note, true);
        }
        if value.head == "true" || value.head == "false" {
            return boolean(ui, name, value);
        }
        if value.numbers().is_some_and(|n| !n.is_empty()) {
            return numbers(ui, name, value, note, false);
        }
        match &mut value.group {
            None if value.head.starts_with('"') => self.text(ui, name, key, value),
            None => written(ui, name, value),
            Some(group) => {
                let mut changed = false;
                for (index, (field, item)) in group.items.iter_mut().enumerate() {
                    let field = field.clone().unwrap_or_else(|| index.to_string());
                    changed |= self.row(ui, &field, &format!("{key}.{field}"), &Shape::Unknown, item);
                }
                changed
            }
        }
    }

    /// Text, and files to pick where it names one.
    pub(super) fn text(&self, ui: &mut Ui, name: &str, key: &str, value: &mut Value) -> bool {
        let endings = endings(name, key);
        let before = value.unquoted().unwrap_or_default();
        let mut text = before.clone();
        let mut changed = edited_text(ui, name, &mut text);
        if !endings.is_empty()
            && let Some(file) = pick_file(ui, "…", &self.folders, endings)
        {
            text = file;
            changed = true;
        }
        if changed && text != before {
            *value = Value::text(&text);
            return true;
        }
        false
    }
}

/// A button with a list of the files of some endings; gives what was picked.
pub fn pick_file(ui: &mut Ui, text: &str, folders: &[PathBuf], endings: &[&str]) -> Option<String> {
    let mut picked = None;
    let button = ui.menu_button(text, |ui| {
        egui::ScrollArea::vertical().max_height(260.0).show(ui, |ui| {
            let files = crate::editor::assets::find(folders, endings);
            if files.is_empty() {
                ui.weak(format!("no file ending in .{} is near", endings.join(", .")));
            }
            for file in files {
                if ui.button(&file).clicked() {
                    picked = Some(file);
                    ui.close();
                }
            }
        });
    });
    button.response.on_hover_text("pick a file");
    picked
}

/// Endings of the files that a field names.
pub fn endings(name: &str, key: &str) -> &'static [&'static str] {
    if key.contains("texture") || key.starts_with("Texture") || key.contains("image") {
        &["png", "jpg", "jpeg", "exr", "hdr"]
    } else if name == "model" || key.starts_with("Model") {
        &["gltf", "glb"]
    } else if name == "grading" {
        &["cube"]
    } else if name == "prefab" {
        &["prefab.ron"]
    } else {
        &[]
    }
}

/// A line of text that is taken when it is done; true then.
pub fn edited_text(ui: &mut Ui, name: &str, text: &mut String) -> bool {
    let id = ui.scope_id().with(("text", name));
    let mut draft = ui.data(|d| d.get_temp::<String>(id)).unwrap_or_else(|| text.clone());
    let width = (ui.available_width() - 30.0).max(60.0);
    let response = ui.add(egui::TextEdit::singleline(&mut draft).desired_width(width));
    named(&response, &title(name));
    if response.has_focus() {
        ui.data_mut(|d| d.insert_temp(id, draft));
        return false;
    }
    let done = response.lost_focus() && draft != *text;
    ui.data_mut(|d| d.remove::<String>(id));
    if done {
        *text = draft;
    }
    done
}

/// A value as its text, for what has no widget.
fn written(ui: &mut Ui, name: &str, value: &mut Value) -> bool {
    let mut text = value.print();
    if !edited_text(ui, name, &mut text) {
        return false;
    }
    let Some(new) = Value::parse(&text) else { return false };
    *value = new;
    true
}
