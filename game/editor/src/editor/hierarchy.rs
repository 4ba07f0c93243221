//! The tree of entities. Only rows that can be seen are laid out.

use super::Editor;
use super::commands::TEMPLATES;
use super::stage::Stage;
use super::widgets::edited_text;
use bevy_ecs::prelude::Entity;
use egui::{Color32, Key, RichText, Sense, Ui};
use lightwell::files;
use lightwell::scene::SceneId;
use lightwell::world::{Camera, Clpv, Fog, GameWorld, Light, MeshRenderer, Particles};
use std::collections::HashSet;

/// What the tree remembers.
#[derive(Debug, Default)]
pub struct Hierarchy {
    search: String,
    open: HashSet<SceneId>,
    /// The entity that is being given a name.
    renaming: Option<(SceneId, String)>,
    /// Opens the parents of the selection and scrolls there.
    pub reveal: bool,
    /// Puts the cursor into the search.
    pub find: bool,
}

#[cfg(test)]
impl Hierarchy {
    /// Opens every branch.
    pub fn open_all(&mut self, world: &GameWorld) {
        let all = world.roots().into_iter().flat_map(|root| world.subtree(root));
        self.open.extend(all.filter_map(|entity| world.id(entity)));
    }
}

#[derive(Clone, Copy, Debug)]
struct Row {
    id: SceneId,
    entity: Entity,
    depth: usize,
    children: bool,
}

/// What is dragged.
struct Dragged(Vec<SceneId>);

/// Shows the tree.
pub fn show(ui: &mut Ui, editor: &mut Editor, stage: &mut Stage) {
    top(ui, editor, stage);
    let reveal = std::mem::take(&mut editor.hierarchy.reveal);
    if reveal {
        open_parents(editor, stage.world);
    }
    let rows = rows(&editor.hierarchy, stage.world);
    let target = editor.selection.last().filter(|_| reveal);
    let target = target.and_then(|id| rows.iter().position(|row| row.id == *id));
    arrows(ui, editor, &rows);
    let height = ui.spacing().interact_size.y;
    let mut area = egui::ScrollArea::both().id_salt("hierarchy").auto_shrink(false);
    if let Some(index) = target {
        let step = height + ui.spacing().item_spacing.y;
        let seen = ui.available_height();
        area = area.vertical_scroll_offset((index as f32 * step - seen * 0.5).max(0.0));
    }
    area.show_rows(ui, height, rows.len() + 1, |ui, range| {
        for index in range {
            match rows.get(index) {
                Some(row) => show_row(ui, editor, stage, row, &rows),
                None => end(ui, editor, stage),
            }
        }
    });
}

fn top(ui: &mut Ui, editor: &mut Editor, stage: &mut Stage) {
    ui.horizontal(|ui| {
        ui.menu_button("+", |ui| add_menu(ui, editor, stage, None)).response.on_hover_text("add an entity");
        let text =
            egui::TextEdit::singleline(&mut editor.hierarchy.search).hint_text("search").desired_width(f32::INFINITY);
        let response = ui.add(text);
        super::widgets::named(&response, "Search");
        if std::mem::take(&mut editor.hierarchy.find) {
            response.request_focus();
        }
    });
}

/// What can be added.
pub fn add_menu(ui: &mut Ui, editor: &mut Editor, stage: &mut Stage, parent: Option<SceneId>) {
    for (name, text) in TEMPLATES {
        if ui.button(name).clicked() {
            let result = editor.add_template(stage, parent, name, text);
            editor.told(result);
            ui.close();
        }
    }
    ui.menu_button("Prefab", |ui| {
        let folders = [super::commands::folder_of(stage.files.path).join("../prefabs")];
        egui::ScrollArea::vertical().max_height(300.0).show(ui, |ui| {
            for file in super::assets::find(&folders, &["prefab.ron"]) {
                if ui.button(file.trim_end_matches(".prefab.ron")).clicked() {
                    let result = editor.add_file(stage, &folders[0].join(&file));
                    editor.told(result);
                    ui.close();
                }
            }
        });
    });
}

fn rows(state: &Hierarchy, world: &GameWorld) -> Vec<Row> {
    let search = state.search.trim().to_lowercase();
    let mut rows = Vec::new();
    let mut pending: Vec<(Entity, usize)> = world.roots().into_iter().rev().map(|e| (e, 0)).collect();
    while let Some((entity, depth)) = pending.pop() {
        let Some(id) = world.id(entity) else { continue };
        let children = world.children(entity);
        let found = search.is_empty() || world.name(entity).to_lowercase().contains(&search);
        if found {
            let depth = if search.is_empty() { depth } else { 0 };
            rows.push(Row { id, entity, depth, children: !children.is_empty() && search.is_empty() });
        }
        if !search.is_empty() || state.open.contains(&id) {
            pending.extend(children.into_iter().rev().map(|child| (child, depth + 1)));
        }
    }
    rows
}

fn open_parents(editor: &mut Editor, world: &GameWorld) {
    for (_, entity) in editor.selected(world) {
        let above = std::iter::successors(world.parent(entity), |e| world.parent(*e));
        editor.hierarchy.open.extend(above.filter_map(|e| world.id(e)));
    }
}

fn show_row(ui: &mut Ui, editor: &mut Editor, stage: &mut Stage, row: &Row, rows: &[Row]) {
    let name = stage.world.name(row.entity).to_owned();
    ui.push_id(row.id.0, |ui| {
        ui.horizontal(|ui| {
            ui.add_space(row.depth as f32 * 12.0);
            toggle(ui, editor, row, &name);
            if editor.hierarchy.renaming.as_ref().is_some_and(|(id, _)| *id == row.id) {
                return rename(ui, editor, stage);
            }
            label(ui, editor, stage, row, rows, &name);
        });
    });
}

fn toggle(ui: &mut Ui, editor: &mut Editor, row: &Row, name: &str) {
    if !row.children {
        ui.add_space(ui.spacing().icon_width + ui.spacing().item_spacing.x);
        return;
    }
    let is_open = editor.hierarchy.open.contains(&row.id);
    let sign = if is_open { "▾" } else { "▸" };
    let button = ui.add(egui::Button::new(sign).frame(false).min_size([ui.spacing().icon_width, 0.0].into()));
    super::widgets::named(&button, &format!("Open {name}"));
    if button.clicked() && !editor.hierarchy.open.remove(&row.id) {
        editor.hierarchy.open.insert(row.id);
    }
}

fn label(ui: &mut Ui, editor: &mut Editor, stage: &mut Stage, row: &Row, rows: &[Row], name: &str) {
    let selected = editor.selection.contains(&row.id);
    let (sign, color) = sign(stage.world, row.entity, ui);
    ui.colored_label(color, sign);
    let mut text = RichText::new(name);
    if files::is_from_model(stage.world, row.entity) {
        text = text.weak();
    } else if files::prefab_of(stage.world, row.entity).is_some() {
        text = text.color(Color32::from_rgb(130, 180, 255));
    }
    let button = egui::Button::selectable(selected, text).sense(Sense::click_and_drag());
    let response = ui.add(button);
    if response.clicked() {
        select(ui, editor, row.id, rows);
    }
    if response.double_clicked() {
        editor.hierarchy.renaming = Some((row.id, name.to_owned()));
    }
    let dragged = if selected { editor.selection.clone() } else { vec![row.id] };
    response.dnd_set_drag_payload(Dragged(dragged));
    if response.dnd_hover_payload::<Dragged>().is_some() {
        ui.painter().rect_stroke(response.rect, 2.0, ui.visuals().selection.stroke, egui::StrokeKind::Inside);
    }
    if let Some(dragged) = response.dnd_release_payload::<Dragged>() {
        let result = editor.reparent(stage, &dragged.0, Some(row.id));
        editor.hierarchy.open.insert(row.id);
        editor.told(result);
    }
    response.context_menu(|ui| context_menu(ui, editor, stage, row.id, name));
}

/// A sign of what the entity is.
fn sign(world: &GameWorld, entity: Entity, ui: &Ui) -> (&'static str, Color32) {
    let ecs = &world.ecs;
    if ecs.get::<Light>(entity).is_some() {
        ("◆", Color32::from_rgb(255, 210, 100))
    } else if ecs.get::<Camera>(entity).is_some() {
        ("►", Color32::from_rgb(140, 200, 255))
    } else if ecs.get::<Clpv>(entity).is_some() {
        ("▦", Color32::from_rgb(160, 230, 160))
    } else if ecs.get::<Fog>(entity).is_some() {
        ("≈", Color32::from_rgb(185, 205, 225))
    } else if ecs.get::<Particles>(entity).is_some() {
        ("✳", Color32::from_rgb(255, 170, 90))
    } else if ecs.get::<MeshRenderer>(entity).is_some() {
        ("■", ui.visuals().text_color())
    } else {
        ("○", ui.visuals().weak_text_color())
    }
}

fn select(ui: &Ui, editor: &mut Editor, id: SceneId, rows: &[Row]) {
    let modifiers = ui.input(|i| i.modifiers);
    let last = editor.selection.last().and_then(|last| rows.iter().position(|row| row.id == *last));
    let this = rows.iter().position(|row| row.id == id);
    match (modifiers.command, modifiers.shift, last, this) {
        (true, ..) => editor.toggle(id),
        (_, true, Some(a), Some(b)) => {
            let between = &rows[a.min(b)..=a.max(b)];
            editor.selection = between.iter().map(|row| row.id).filter(|other| *other != id).chain([id]).collect();
        }
        _ => editor.selection = vec![id],
    }
    editor.problem = None;
}

fn rename(ui: &mut Ui, editor: &mut Editor, stage: &mut Stage) {
    let Some((id, mut name)) = editor.hierarchy.renaming.clone() else { return };
    let before = name.clone();
    let done = edited_text(ui, "new name", &mut name);
    if done {
        let result = editor.rename(stage, id, &name);
        editor.told(result);
    }
    let left = ui.input(|i| i.key_pressed(Key::Escape) || i.key_pressed(Key::Enter));
    if done || left || name != before {
        editor.hierarchy.renaming = None;
    }
}

fn context_menu(ui: &mut Ui, editor: &mut Editor, stage: &mut Stage, id: SceneId, name: &str) {
    if !editor.selection.contains(&id) {
        editor.selection = vec![id];
    }
    ui.menu_button("Add child", |ui| add_menu(ui, editor, stage, Some(id)));
    if ui.button("Rename").clicked() {
        editor.hierarchy.renaming = Some((id, name.to_owned()));
        ui.close();
    }
    ui.separator();
    super::menu::edit_entries(ui, editor, stage);
}

/// The space below the tree: what is dropped there stands below nothing.
fn end(ui: &mut Ui, editor: &mut Editor, stage: &mut Stage) {
    let size = [ui.available_width().max(40.0), ui.spacing().interact_size.y];
    let (rect, response) = ui.allocate_exact_size(size.into(), Sense::click());
    if response.clicked() {
        editor.selection.clear();
    }
    if response.dnd_hover_payload::<Dragged>().is_some() {
        ui.painter().rect_stroke(rect, 2.0, ui.visuals().selection.stroke, egui::StrokeKind::Inside);
    }
    if let Some(dragged) = response.dnd_release_payload::<Dragged>() {
        let result = editor.reparent(stage, &dragged.0, None);
        editor.told(result);
    }
}

/// Arrow keys go through the tree while the pointer is over it and nothing is typed.
fn arrows(ui: &Ui, editor: &mut Editor, rows: &[Row]) {
    if ui.ctx().egui_wants_keyboard_input() || !ui.rect_contains_pointer(ui.max_rect()) {
        return;
    }
    let now = editor.selection.last().and_then(|id| rows.iter().position(|row| row.id == *id));
    let pressed = |key| ui.input(|i| i.key_pressed(key));
    let next = match now {
        _ if pressed(Key::ArrowDown) => now.map_or(0, |now| now + 1),
        Some(now) if pressed(Key::ArrowUp) => now.saturating_sub(1),
        Some(now) if pressed(Key::ArrowRight) => {
            editor.hierarchy.open.insert(rows[now].id);
            return;
        }
        Some(now) if pressed(Key::ArrowLeft) => {
            editor.hierarchy.open.remove(&rows[now].id);
            return;
        }
        _ => return,
    };
    if let Some(row) = rows.get(next) {
        editor.select_only(row.id);
    }
}
