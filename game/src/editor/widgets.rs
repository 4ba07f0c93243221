//! Widgets for any value that scene files can hold, by its shape and its documentation.

use super::docs::{Docs, Note};
use super::own::OwnComponent;
use super::schema::Shape;
use super::value::{Value, float};
use egui::{DragValue, Response, Ui};
use glam::{EulerRot, Quat, Vec3};
use lightwell::files;
use std::collections::HashMap;

/// Starting values of what zeros would make invalid, or dull.
const STARTERS: [(&str, &str); 8] = [
    ("Override.light", "(kind:Point,intensity:10.0)"),
    ("Override.mesh", "Box()"),
    ("Override.material", "()"),
    ("LightKind.Spot", "Spot(inner:20.0,outer:30.0)"),
    ("Spin", "Spin(axis:(0.0,1.0,0.0),degrees_per_second:90.0)"),
    ("Orbit", "Orbit(radius:1.0,period:4.0)"),
    ("Keys", "Keys(target:Translation,keys:[(0.0,(0.0,0.0,0.0)),(1.0,(0.0,1.0,0.0))])"),
    ("Transform.scale", "1.0"),
];

/// What widgets need to know of the rest.
pub struct Kit {
    docs: Docs,
    /// Components of a game.
    pub own: Vec<OwnComponent>,
    /// Shapes of types that read several forms.
    customs: HashMap<&'static str, (&'static str, Shape)>,
    /// Named materials of the scene.
    pub materials: Vec<String>,
    /// Folders that assets are looked for in.
    pub folders: Vec<std::path::PathBuf>,
}

impl Default for Kit {
    fn default() -> Self {
        let customs = HashMap::from([
            ("MaterialRef", ("Material", Shape::of::<files::MaterialFile>())),
            ("ModelFile", ("Model", Shape::of::<files::ModelDetails>())),
            ("TextureFile", ("Texture", Shape::of::<files::SampledTexture>())),
        ]);
        Self {
            docs: Docs::read(&files::DESCRIBED),
            own: Vec::new(),
            customs,
            materials: Vec::new(),
            folders: Vec::new(),
        }
    }
}

/// A field's name as people read it.
pub fn title(name: &str) -> String {
    let mut chars = name.chars();
    let first: String = chars.next().into_iter().flat_map(char::to_uppercase).collect();
    first + &chars.as_str().replace('_', " ")
}

impl Kit {
    /// Adds components of a game with their help.
    pub fn add_own(&mut self, own: Vec<OwnComponent>) {
        for note in own.iter().flat_map(|component| &component.notes) {
            self.docs.insert(note.key, note.help);
        }
        self.own.extend(own);
    }

    /// The note of a field.
    pub fn note(&self, key: &str) -> Note {
        self.docs.note(key)
    }

    /// A valid value to begin with.
    pub fn starter(&self, key: &str, shape: &Shape) -> Value {
        let known = STARTERS.iter().find(|(k, _)| *k == key).map(|(_, text)| (*text).to_owned());
        let text = known.unwrap_or_else(|| match shape {
            Shape::Float(_) => float(self.note(key).range.map_or(1.0, |r| *r.end()), true),
            Shape::Integer(_) => "1".into(),
            Shape::Bool => "true".into(),
            Shape::Struct(..) => "()".into(),
            Shape::Option(inner) => self.starter(key, inner).print(),
            other => other.sample(),
        });
        Value::parse(&text).unwrap_or_default()
    }

    /// A labelled row of a field; true if it changed.
    pub fn row(&self, ui: &mut Ui, name: &str, key: &str, shape: &Shape, value: &mut Value) -> bool {
        let note = self.note(key);
        match shape.inner() {
            _ if is_plain(shape, value) => ui.horizontal(|ui| self.labelled(ui, name, key, shape, value, &note)).inner,
            _ => {
                let header = egui::CollapsingHeader::new(title(name)).id_salt((key, name)).default_open(true);
                let response = header.show(ui, |ui| self.value(ui, name, key, shape, value, &note));
                help(response.header_response, &note);
                response.body_returned.unwrap_or(false)
            }
        }
    }

    fn labelled(&self, ui: &mut Ui, name: &str, key: &str, shape: &Shape, value: &mut Value, note: &Note) -> bool {
        let width = (ui.available_width() * 0.34).clamp(60.0, 120.0);
        let height = ui.spacing().interact_size.y;
        let label = egui::Label::new(title(name)).truncate().sense(egui::Sense::hover());
        let layout = egui::Layout::left_to_right(egui::Align::Center).with_main_align(egui::Align::Min);
        let label = ui.allocate_ui_with_layout([width, height].into(), layout, |ui| {
            ui.set_min_width(width);
            ui.add(label)
        });
        help(label.inner, note);
        ui.push_id(name, |ui| self.value(ui, name, key, shape, value, note)).inner
    }

    /// The widget of a component; true if it changed.
    pub fn body(&self, ui: &mut Ui, name: &str, key: &str, shape: &Shape, value: &mut Value) -> bool {
        self.value(ui, name, key, shape, value, &self.note(key))
    }

    /// The widget of a value; true if it changed.
    fn value(&self, ui: &mut Ui, name: &str, key: &str, shape: &Shape, value: &mut Value, note: &Note) -> bool {
        match shape {
            Shape::Option(inner) => self.option(ui, name, key, inner, value, note),
            Shape::Bool => boolean(ui, name, value),
            Shape::Integer(signed) => integer(ui, name, value, note, *signed),
            Shape::Float(single) => number(ui, name, value, note, *single),
            Shape::Text => self.text(ui, name, key, value),
            Shape::Tuple(items) => match items.iter().all(|i| matches!(i, Shape::Float(_) | Shape::Integer(_))) {
                true => numbers(ui, name, value, note, matches!(items.first(), Some(Shape::Integer(_)))),
                false => self.tuple(ui, key, items, value),
            },
            Shape::Struct(ty, fields) => self.fields(ui, ty_or(ty, key), fields, value),
            Shape::Enum(ty, variants) => self.choice(ui, name, ty, variants, value, note),
            Shape::List(item) => self.list(ui, key, item, value),
            Shape::Map(item) => self.map(ui, key, item, value),
            Shape::Custom(ty) => self.custom(ui, name, key, ty, value, note),
            Shape::Unit | Shape::Unknown => self.by_value(ui, name, key, value, note),
        }
    }

    /// The fields of a structure; true if one changed.
    pub fn fields(&self, ui: &mut Ui, ty: &str, fields: &[(&'static str, Shape)], value: &mut Value) -> bool {
        let mut changed = false;
        for (name, shape) in fields {
            let key = format!("{ty}.{name}");
            let written = value.field(name).cloned();
            let empty = match shape {
                Shape::Option(_) => Some("None"),
                Shape::Bool => Some("false"),
                Shape::Text => Some("\"\""),
                Shape::List(_) => Some("[]"),
                Shape::Map(_) => Some("{}"),
                // Left out as it has its default, which the text does not tell.
                _ => None,
            };
            let Some(mut field) = written.clone().or_else(|| Value::parse(empty?)) else { continue };
            if self.row(ui, name, &key, shape, &mut field) {
                changed = true;
                match field.head == "None" && field.group.is_none() && written.is_none() {
                    true => value.remove(name),
                    false => value.set(name, field),
                }
            }
        }
        changed
    }

    fn option(&self, ui: &mut Ui, name: &str, key: &str, inner: &Shape, value: &mut Value, note: &Note) -> bool {
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

    fn choice(
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

    fn starter_variant(&self, key: &str, name: &str, shape: &Shape) -> Value {
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

    fn tuple(&self, ui: &mut Ui, key: &str, shapes: &[Shape], value: &mut Value) -> bool {
        let Some(group) = &mut value.group else { return false };
        let mut changed = false;
        for (index, ((_, item), shape)) in group.items.iter_mut().zip(shapes).enumerate() {
            changed |=
                ui.push_id(index, |ui| self.value(ui, &index.to_string(), key, shape, item, &Note::default())).inner;
        }
        changed
    }

    fn list(&self, ui: &mut Ui, key: &str, shape: &Shape, value: &mut Value) -> bool {
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

    fn starter_of_list(&self, key: &str, shape: &Shape) -> Value {
        match shape {
            Shape::Enum(ty, variants) => match variants.first() {
                Some((name, inner)) => self.starter_variant(&format!("{ty}.{name}"), name, inner),
                None => self.starter(key, shape),
            },
            _ => self.starter(key, shape),
        }
    }

    fn map(&self, ui: &mut Ui, key: &str, shape: &Shape, value: &mut Value) -> bool {
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

    fn custom(&self, ui: &mut Ui, name: &str, key: &str, ty: &str, value: &mut Value, note: &Note) -> bool {
        if ty == "MaterialRef" {
            return self.material(ui, name, value);
        }
        match self.customs.get(ty) {
            Some((ty, Shape::Struct(_, fields))) if value.group.is_some() => self.fields(ui, ty, fields, value),
            Some(_) => self.text(ui, name, key, value),
            None => self.by_value(ui, name, key, value, note),
        }
    }

    fn material(&self, ui: &mut Ui, name: &str, value: &mut Value) -> bool {
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
    fn by_value(&self, ui: &mut Ui, name: &str, key: &str, value: &mut Value, note: &Note) -> bool {
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
    fn text(&self, ui: &mut Ui, name: &str, key: &str, value: &mut Value) -> bool {
        let endings = endings(name, key);
        let before = value.unquoted().unwrap_or_default();
        let mut text = before.clone();
        let mut changed = edited_text(ui, name, &mut text);
        if !endings.is_empty() {
            ui.menu_button("…", |ui| {
                egui::ScrollArea::vertical().max_height(260.0).show(ui, |ui| {
                    for file in super::assets::find(&self.folders, endings) {
                        if ui.button(&file).clicked() {
                            text = file;
                            changed = true;
                            ui.close();
                        }
                    }
                });
            })
            .response
            .on_hover_text("pick a file");
        }
        if changed && text != before {
            *value = Value::text(&text);
            return true;
        }
        false
    }
}

/// Endings of the files that a field names.
fn endings(name: &str, key: &str) -> &'static [&'static str] {
    if key.contains("texture") || key.starts_with("Texture") || key.contains("image") {
        &["png", "jpg", "jpeg", "exr", "hdr"]
    } else if name == "model" || key.starts_with("Model") {
        &["gltf", "glb"]
    } else if name == "prefab" {
        &["prefab.ron"]
    } else {
        &[]
    }
}

fn ty_or<'a>(ty: &'a str, key: &'a str) -> &'a str {
    if ty.is_empty() { key } else { ty }
}

/// Whether a value fits beside its label.
fn is_plain(shape: &Shape, value: &Value) -> bool {
    match shape {
        Shape::Option(inner) => value.head == "None" && value.group.is_none() || is_plain(inner, value),
        Shape::Struct(..) | Shape::List(_) | Shape::Map(_) => false,
        Shape::Enum(_, variants) => {
            let shape = variants.iter().find(|(name, _)| *name == value.head).map(|(_, shape)| shape);
            !matches!(shape, Some(Shape::Struct(..)))
        }
        Shape::Tuple(items) => items.iter().all(|i| matches!(i, Shape::Float(_) | Shape::Integer(_))),
        Shape::Custom(_) | Shape::Unknown => value.group.is_none() || value.numbers().is_some_and(|n| !n.is_empty()),
        _ => true,
    }
}

/// Gives a widget without text a name, for those who cannot see it and for tests.
pub fn named(response: &Response, name: &str) {
    response.ctx.accesskit_node_builder(response.id, |node| node.set_label(name));
}

fn help(response: Response, note: &Note) {
    if !note.help.is_empty() {
        response.on_hover_text(&note.help);
    }
}

fn boolean(ui: &mut Ui, name: &str, value: &mut Value) -> bool {
    let mut on = value.head == "true";
    let response = ui.checkbox(&mut on, "");
    named(&response, &title(name));
    if response.changed() {
        *value = Value::literal(on.to_string());
    }
    response.changed()
}

fn integer(ui: &mut Ui, name: &str, value: &mut Value, note: &Note, signed: bool) -> bool {
    let mut now: i64 = value.head.parse().unwrap_or_default();
    let range = note.range.as_ref().map(|r| *r.start() as i64..=*r.end() as i64);
    let floor = if signed { i64::MIN } else { 0 };
    let drag = DragValue::new(&mut now).range(range.unwrap_or(floor..=i64::from(u32::MAX))).speed(0.2);
    let response = ui.add(drag.suffix(suffix(note)));
    named(&response, &title(name));
    if response.changed() {
        *value = Value::literal(now.to_string());
    }
    response.changed()
}

fn suffix(note: &Note) -> String {
    match note.unit {
        Some(unit) if unit.starts_with('°') => unit.to_owned(),
        Some(unit) => format!(" {unit}"),
        None => String::new(),
    }
}

/// Most decimals that are shown.
const DECIMALS: usize = 5;

/// A number to drag, of up to so many decimals; gives it if it changed.
fn drag(ui: &mut Ui, label: &str, now: f64, note: &Note, decimals: usize) -> Option<f64> {
    let mut value = now;
    let speed = match &note.range {
        Some(range) => (range.end() - range.start()) / 200.0,
        None => (now.abs() * 0.01).max(0.005),
    };
    let mut drag = DragValue::new(&mut value).speed(speed).max_decimals(decimals).suffix(suffix(note));
    if let Some(range) = &note.range {
        drag = drag.range(range.clone()).clamp_existing_to_range(false);
    }
    let response = ui.add(drag);
    named(&response, label);
    // Rounding for display is no change.
    (response.changed() && value != now).then_some(value)
}

fn number(ui: &mut Ui, name: &str, value: &mut Value, note: &Note, single: bool) -> bool {
    let changed = drag(ui, &title(name), value.number().unwrap_or_default(), note, DECIMALS);
    if let Some(new) = changed {
        *value = Value::literal(float(new, single));
    }
    changed.is_some()
}

const AXES: [&str; 4] = ["x", "y", "z", "w"];

fn numbers(ui: &mut Ui, name: &str, value: &mut Value, note: &Note, whole: bool) -> bool {
    let Some(mut now) = value.numbers() else { return false };
    let mut changed = false;
    if note.color && now.len() == 3 {
        changed |= color(ui, name, &mut now);
    }
    ui.spacing_mut().interact_size.x = 40.0;
    ui.spacing_mut().item_spacing.x = 3.0;
    let plain = Note { unit: None, ..note.clone() };
    for (index, number) in now.iter_mut().enumerate() {
        let label = format!("{} {}", title(name), AXES.get(index).unwrap_or(&"more"));
        if let Some(new) = drag(ui, &label, *number, &plain, if whole { 0 } else { DECIMALS }) {
            *number = if whole { new.round() } else { new };
            changed = true;
        }
    }
    if changed && let Some(group) = &mut value.group {
        for ((_, item), number) in group.items.iter_mut().zip(now) {
            let text = if whole { format!("{}", number.max(0.0) as u64) } else { float(number, true) };
            *item = Value::literal(text);
        }
    }
    changed
}

/// A colour to pick. Brighter than white keeps its strength: the picker changes hue and saturation.
fn color(ui: &mut Ui, name: &str, now: &mut [f64]) -> bool {
    let strength = now.iter().copied().fold(1.0, f64::max);
    let mut rgb = [0, 1, 2].map(|i| (now[i] / strength) as f32);
    let response = ui.color_edit_button_rgb(&mut rgb);
    named(&response, &format!("{} picker", title(name)));
    // The picker's own colour space rounds: only what the user changes is a change.
    if !response.changed() {
        return false;
    }
    now.iter_mut().zip(rgb).for_each(|(now, c)| *now = f64::from(c) * strength);
    true
}

/// A rotation as angles, whatever the file says.
fn angles(ui: &mut Ui, name: &str, value: &mut Value) -> bool {
    let now = value.numbers().unwrap_or_default();
    let mut degrees = match now[..] {
        [x, y, z] => [x, y, z],
        [x, y, z, w] => {
            let q = Quat::from_xyzw(x as f32, y as f32, z as f32, w as f32).normalize();
            let (heading, pitch, roll) = q.to_euler(EulerRot::YXZ);
            Vec3::new(pitch, heading, roll).to_array().map(|a| (f64::from(a.to_degrees()) * 1e4).round() / 1e4)
        }
        _ => [0.0; 3],
    };
    let note = Note { unit: Some("°"), ..Note::default() };
    let mut changed = false;
    ui.spacing_mut().interact_size.x = 42.0;
    ui.spacing_mut().item_spacing.x = 3.0;
    for (angle, axis) in degrees.iter_mut().zip(AXES) {
        if let Some(new) = drag_angle(ui, &format!("{} {axis}", title(name)), *angle, &note) {
            *angle = new;
            changed = true;
        }
    }
    if changed {
        *value = Value::tuple(&degrees.map(|d| d as f32));
    }
    changed
}

fn drag_angle(ui: &mut Ui, label: &str, now: f64, note: &Note) -> Option<f64> {
    let mut value = now;
    let response = ui.add(DragValue::new(&mut value).speed(0.5).max_decimals(3).suffix(suffix(note)));
    named(&response, label);
    (response.changed() && value != now).then_some(value)
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
