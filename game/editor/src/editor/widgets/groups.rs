//! Widgets of what holds other values: options, variants, tuples, lists, maps.

use super::{Kit, STARTERS, help, is_plain, named, title};
use crate::editor::docs::Note;
use crate::editor::schema::Shape;
use crate::editor::value::Value;
use egui::Ui;

impl Kit {
    pub(super) fn option(
        &self,
        ui: &mut Ui,
        name: &str,
        key: &str,
        inner: &Shape,
        value: &mut Value,
        note: &Note,
    ) -> bool {
        let is_none = value.head == "None" && value.group.is_none();
        let mut on = !is_none;
        let toggle = ui.checkbox(&mut on, "").on_hover_text("whether there is one");
        named(&toggle, &format!("{} on", title(name)));
        if toggle.changed() {
            *value = if on { self.starter(key, inner) } else { Value::literal("None") };
            return true;
        }
        on && self.value(ui, name, key, inner, value, note)
    }

    pub(super) fn choice(
        &self,
        ui: &mut Ui,
        name: &str,
        ty: &str,
        variants: &[(&'static str, Shape)],
        value: &mut Value,
        note: &Note,
    ) -> bool {
        let mut changed = false;
        let now = value.head.trim_start_matches("r#").to_owned();
        let combo = egui::ComboBox::from_id_salt((ty, name)).selected_text(&now).show_ui(ui, |ui| {
            for (variant, shape) in variants {
                let key = format!("{ty}.{variant}");
                let entry = ui.selectable_label(now == *variant, *variant).on_hover_text(self.note(&key).help);
                if entry.clicked() && now != *variant {
                    *value = self.starter_variant(&key, variant, shape);
                    changed = true;
                }
            }
        });
        named(&combo.response, &title(name));
        help(combo.response, note);
        let shape = variants.iter().find(|(variant, _)| *variant == value.head).map(|(_, shape)| shape);
        match shape {
            Some(Shape::Struct(_, fields)) => {
                let ty = format!("{ty}.{}", value.head);
                ui.vertical(|ui| changed |= self.fields(ui, &ty, fields, value));
            }
            Some(Shape::Unit | Shape::Unknown) | None => {}
            Some(inner) => {
                let key = format!("{ty}.{}", value.head);
                let note = self.note(&key);
                if let Some((_, item)) = value.group.as_mut().and_then(|group| group.items.first_mut()) {
                    changed |= self.value(ui, name, &key, inner, item, &note);
                }
            }
        }
        changed
    }

    pub(super) fn starter_variant(&self, key: &str, name: &str, shape: &Shape) -> Value {
        let known = STARTERS.iter().find(|(k, _)| *k == key || *k == name).map(|(_, text)| (*text).to_owned());
        // Numbers of one, since zero is often no size.
        let text = known.unwrap_or_else(|| match shape {
            Shape::Unit => name.to_owned(),
            Shape::Struct(_, fields) => {
                let field = |(field, shape): &(&str, Shape)| {
                    format!("{field}:{}", self.starter(&format!("{key}.{field}"), shape).print())
                };
                format!("{name}({})", fields.iter().map(field).collect::<Vec<_>>().join(","))
            }
            other => format!("{name}({})", self.starter(key, other).print()),
        });
        Value::parse(&text).unwrap_or_default()
    }

    pub(super) fn tuple(&self, ui: &mut Ui, key: &str, shapes: &[Shape], value: &mut Value) -> bool {
        let Some(group) = &mut value.group else { return false };
        let is_row = group.items.iter().zip(shapes).all(|((_, item), shape)| is_plain(shape, item));
        let mut all = |ui: &mut Ui| {
            let mut changed = false;
            for (index, ((_, item), shape)) in group.items.iter_mut().zip(shapes).enumerate() {
                let name = index.to_string();
                changed |= ui.push_id(index, |ui| self.value(ui, &name, key, shape, item, &Note::default())).inner;
            }
            changed
        };
        // A key and its value stand side by side.
        if is_row { ui.horizontal(all).inner } else { all(ui) }
    }

    pub(super) fn list(&self, ui: &mut Ui, key: &str, shape: &Shape, value: &mut Value) -> bool {
        let Some(group) = &mut value.group else { return false };
        let (mut changed, mut gone) = (false, None);
        for (index, (_, item)) in group.items.iter_mut().enumerate() {
            ui.push_id(index, |ui| {
                ui.horizontal_top(|ui| {
                    if ui.small_button("−").on_hover_text("take this one away").clicked() {
                        gone = Some(index);
                    }
                    let name = format!("{}", index + 1);
                    ui.vertical(|ui| changed |= self.value(ui, &name, key, shape, item, &Note::default()));
                });
            });
        }
        if let Some(index) = gone {
            group.items.remove(index);
        }
        let add = ui.small_button("+ add");
        named(&add, &format!("Add to {}", title(key.rsplit('.').next().unwrap_or(key))));
        if add.clicked() {
            let new = group.items.last().map(|(_, item)| item.clone());
            group.items.push((None, new.unwrap_or_else(|| self.starter_of_list(key, shape))));
            return true;
        }
        changed || gone.is_some()
    }

    pub(super) fn starter_of_list(&self, key: &str, shape: &Shape) -> Value {
        match shape {
            Shape::Enum(ty, variants) => match variants.first() {
                Some((name, inner)) => self.starter_variant(&format!("{ty}.{name}"), name, inner),
                None => self.starter(key, shape),
            },
            _ => self.starter(key, shape),
        }
    }

    pub(super) fn map(&self, ui: &mut Ui, key: &str, shape: &Shape, value: &mut Value) -> bool {
        let Some(group) = &mut value.group else { return false };
        let (mut changed, mut gone) = (false, None);
        for (index, (name, item)) in group.items.iter_mut().enumerate() {
            let name = name.clone().unwrap_or_default();
            let shown = Value::literal(name.clone()).unquoted().unwrap_or(name.clone());
            egui::CollapsingHeader::new(&shown).id_salt((key, &name)).show(ui, |ui| {
                changed |= self.value(ui, &shown, key, shape, item, &Note::default());
                if ui.small_button("− remove").clicked() {
                    gone = Some(index);
                }
            });
        }
        if let Some(index) = gone {
            group.items.remove(index);
        }
        let id = ui.scope_id().with("new key");
        let mut name: String = ui.data(|d| d.get_temp(id)).unwrap_or_default();
        ui.horizontal(|ui| {
            ui.add(egui::TextEdit::singleline(&mut name).hint_text("new name").desired_width(100.0));
            let quoted = Value::text(name.trim()).head;
            let taken = group.items.iter().any(|(key, _)| key.as_ref() == Some(&quoted));
            let can = !name.trim().is_empty() && !taken;
            if ui.add_enabled(can, egui::Button::new("+ add").small()).clicked() {
                group.items.push((Some(quoted), self.starter(key, shape)));
                name.clear();
                changed = true;
            }
        });
        ui.data_mut(|d| d.insert_temp(id, name));
        changed || gone.is_some()
    }
}
