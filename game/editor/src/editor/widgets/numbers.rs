//! Widgets of numbers: one, several, colours and angles.

use super::{named, title};
use crate::editor::docs::Note;
use crate::editor::value::{Value, float};
use egui::{DragValue, Ui};
use glam::{EulerRot, Quat, Vec3};

pub(super) fn boolean(ui: &mut Ui, name: &str, value: &mut Value) -> bool {
    let mut on = value.head == "true";
    let response = ui.checkbox(&mut on, "");
    named(&response, &title(name));
    if response.changed() {
        *value = Value::literal(on.to_string());
    }
    response.changed()
}

pub(super) fn integer(ui: &mut Ui, name: &str, value: &mut Value, note: &Note, signed: bool) -> bool {
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

/// Width of a range from which on a drag changes numbers by shares of themselves, as without a range.
const WIDE: f64 = 1e4;

/// A number to drag, of up to so many decimals; gives it if it changed.
fn drag(ui: &mut Ui, label: &str, now: f64, note: &Note, decimals: usize) -> Option<f64> {
    let mut value = now;
    let speed = match &note.range {
        Some(range) if range.end() - range.start() <= WIDE => (range.end() - range.start()) / 200.0,
        _ => (now.abs() * 0.01).max(0.005),
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

pub(super) fn number(ui: &mut Ui, name: &str, value: &mut Value, note: &Note, single: bool) -> bool {
    let changed = drag(ui, &title(name), value.number().unwrap_or_default(), note, DECIMALS);
    if let Some(new) = changed {
        *value = Value::literal(float(new, single));
    }
    changed.is_some()
}

const AXES: [&str; 4] = ["x", "y", "z", "w"];

pub(super) fn numbers(ui: &mut Ui, name: &str, value: &mut Value, note: &Note, whole: bool) -> bool {
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
pub(super) fn angles(ui: &mut Ui, name: &str, value: &mut Value) -> bool {
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
