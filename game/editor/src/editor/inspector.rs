//! The inspector: what the selected entity is made of.

use super::Editor;
use super::custom_component::{self, CustomComponent};
use super::playing::{differences, edited_value};
use super::schema::Shape;
use super::stage::Stage;
use super::value::Value;
use super::widgets::{edited_text, endings, pick_file, title};
use egui::Ui;
use lightwell::files::{self, Overridden, OverrideFile, SceneFile, describe_entity, describe_scene, ron_options};
use lightwell::scene::SceneId;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::LazyLock;

/// Fields of an override that are no components.
const NO_COMPONENTS: [&str; 5] = ["remove", "without", "children", "overrides", custom_component::FIELD];

/// The components that scene files know, with their shapes.
static COMPONENTS: LazyLock<Vec<(&'static str, Shape)>> =
    LazyLock::new(|| Shape::fields_of::<OverrideFile>(&NO_COMPONENTS));

/// What belongs to a scene as a whole.
static SCENE: LazyLock<Vec<(&'static str, Shape)>> =
    LazyLock::new(|| Shape::fields_of::<SceneFile>(&["version", "entities"]));

/// Shows the selection.
pub fn show(ui: &mut Ui, editor: &mut Editor, stage: &mut Stage) {
    let selected = editor.selected(stage.world);
    let Some(&(id, entity)) = selected.last() else {
        ui.weak("Nothing is selected. Click on something in the view or in the hierarchy.");
        return;
    };
    ui.push_id(id.0, |ui| {
        ui.horizontal(|ui| {
            let mut name = stage.world.name(entity).to_owned();
            if edited_text(ui, "name", &mut name) {
                let result = editor.rename(stage, id, &name);
                editor.told(result);
            }
        });
        if selected.len() > 1 {
            ui.weak(format!("{} entities are selected; a change is made to all that have the value", selected.len()));
        }
        if stage.facts.playing.is_some() {
            apply_all(ui, editor, stage, id);
        }
        origin(ui, stage, entity);
        if files::is_from_model(stage.world, entity) {
            return model_part(ui, stage, entity);
        }
        match describe_entity(stage.world, entity, stage.files.path) {
            Ok(before) => components(ui, editor, stage, id, &before),
            Err(error) => drop(ui.colored_label(ui.visuals().warn_fg_color, error.to_string())),
        }
    });
}

/// Says whose values these are, and applies all of them to the scene.
fn apply_all(ui: &mut Ui, editor: &mut Editor, stage: &Stage, id: SceneId) {
    let Some(playing) = stage.facts.playing else { return };
    let is_known = playing.edited.is_some_and(|(world, _)| world.entity(id).is_some());
    ui.horizontal_wrapped(|ui| {
        ui.colored_label(playing.state().1, "of the game that plays");
        let button = ui.add_enabled(is_known, egui::Button::new("Apply to scene"));
        let help = "give the edited scene these values, as one step of undo; a ● marks each that differs, and applies it alone";
        let button = button.on_hover_text(help).on_disabled_hover_text("the edited scene has no such entity");
        if button.clicked() {
            editor.ask_apply(stage);
        }
    });
}

fn origin(ui: &mut Ui, stage: &Stage, entity: bevy_ecs::prelude::Entity) {
    if let Some(prefab) = files::prefab_of(stage.world, entity) {
        ui.weak(format!("instance of {prefab}"));
    }
    if stage.world.rest_transform(entity) != stage.world.ecs.get(entity).copied().unwrap_or_default() {
        ui.weak("animated: the transform is that without the animation; gizmos in the view move both");
    }
    if files::is_in_prefab(stage.world, entity) {
        ui.weak("part of a prefab; changes are kept as overrides of this instance");
    }
}

fn model_part(ui: &mut Ui, stage: &Stage, entity: bevy_ecs::prelude::Entity) {
    ui.weak("part of a glTF model: the model's file holds it, so it is shown and not changed");
    let t = stage.world.rest_transform(entity);
    ui.monospace(format!("translation {}\nrotation    {}\nscale       {}", t.translation, t.rotation, t.scale));
    if let Some(renderer) = stage.world.ecs.get::<lightwell::world::MeshRenderer>(entity) {
        let (mesh, material) = (&renderer.mesh, &renderer.material);
        ui.monospace(format!("mesh        {}\nmaterial    {}", mesh.name, material.name));
    }
}

fn components(ui: &mut Ui, editor: &mut Editor, stage: &mut Stage, id: SceneId, before: &OverrideFile) {
    let Ok(text) = ron_options().to_string(before) else { return };
    let Some(mut value) = Value::parse(&text) else { return };
    let written = value.clone();
    fill_transform(&mut value);
    let old = value.clone();
    let mut changed: Option<String> = None;
    let mut resting = edited_value(stage.facts.playing, id);
    resting.iter_mut().for_each(fill_transform);
    let differ = |before: &Value, path: [&str; 2]| match &resting {
        Some(edited) => differences(at(edited, path), before, path[1]),
        None => BTreeMap::new(),
    };
    let overridden = stage.world.ecs.get_resource::<Overridden>();
    let fields = overridden.map(|overridden| overridden.fields(id, before)).unwrap_or_default();
    for (name, shape) in COMPONENTS.iter() {
        let Some(mut component) = value.field(name).cloned() else { continue };
        editor.kit.differences = differ(&component, ["", name]);
        let key = format!("Override.{name}");
        editor.kit.marks = marks(overridden, &fields, name);
        if is_section(shape) {
            let mut remove = false;
            let edited = section(ui, editor, name, &key, shape.inner(), &mut component, &mut remove);
            if remove {
                value.remove(name);
                changed = Some(format!("remove {name}"));
            } else if edited {
                value.set(name, component);
                changed = Some(format!("change {name}"));
            }
        } else if editor.kit.row(ui, name, &key, shape, &mut component) {
            match component.head == "None" {
                true => value.remove(name),
                false => value.set(name, component),
            }
            changed = Some(format!("change {name}"));
        }
        apply_field(editor, id, resting.as_ref(), &old, &[name]);
    }
    let own_components = editor.kit.own.clone();
    for CustomComponent { name, shape, .. } in &own_components {
        let Some(mut component) = custom_component::get(&value, name) else { continue };
        let mut remove = false;
        editor.kit.differences = differ(&component, [custom_component::FIELD, name]);
        editor.kit.marks = marks(overridden, &fields, &format!("components.{name}"));
        let edited = section(ui, editor, name, name, shape, &mut component, &mut remove);
        if remove || edited {
            custom_component::set(&mut value, name, Some(component).filter(|_| !remove));
            changed = Some(format!("{} {name}", if remove { "remove" } else { "change" }));
        }
        let quoted = custom_component::quoted(name);
        apply_field(editor, id, resting.as_ref(), &old, &[custom_component::FIELD, &quoted]);
    }
    editor.kit.marks.clear();
    editor.kit.differences.clear();
    ui.add_space(6.0);
    ui.menu_button("Add component", |ui| {
        let missing: Vec<_> =
            own_components.iter().filter(|c| custom_component::get(&value, c.name).is_none()).collect();
        for CustomComponent { name, .. } in missing {
            let Some(starter) = stage.files.options.types.get(name).and_then(|t| t.starter().ok()) else { continue };
            if ui.button(*name).on_hover_text(editor.kit.note(name).help).clicked() {
                custom_component::set(&mut value, name, Value::parse(&starter));
                changed = Some(format!("add {name}"));
                ui.close();
            }
        }
        // An entity has a mesh or a model.
        let excluded = |name: &str| match name {
            "model" => value.field("mesh").is_some(),
            "mesh" => value.field("model").is_some(),
            _ => false,
        };
        let missing = COMPONENTS.iter().filter(|(name, _)| value.field(name).is_none() && !excluded(name));
        for (name, shape) in missing.collect::<Vec<_>>() {
            let key = format!("Override.{name}");
            let endings = endings(name, &key);
            let component = match endings.is_empty() {
                true => {
                    let button = ui.button(title(name)).on_hover_text(editor.kit.note(&key).help);
                    button.clicked().then(|| editor.kit.starter(&key, shape.inner()))
                }
                // Without its file it would be none.
                false => pick_file(ui, &title(name), &editor.kit.folders, endings).map(|file| Value::text(&file)),
            };
            if let Some(component) = component {
                value.set(name, component);
                changed = Some(format!("add {name}"));
                ui.close();
            }
        }
    });
    if let Some(error) = &editor.problem {
        ui.colored_label(ui.visuals().error_fg_color, error);
    }
    if let Some(label) = changed {
        let mut old = old;
        [&mut old, &mut value].into_iter().for_each(|value| strip_transform(value, &written));
        apply(editor, stage, id, &label, &old, &value);
    }
}

/// A component of an entity's description, or a custom one below that field.
fn at<'a>(description: &'a Value, [below, name]: [&str; 2]) -> Option<&'a Value> {
    match below {
        "" => description.field(name),
        below => description.field(below)?.field(&custom_component::quoted(name)),
    }
}

/// Applies the field of a component whose sign was clicked on. `path` is that of the component.
fn apply_field(editor: &mut Editor, id: SceneId, edited: Option<&Value>, playing: &Value, path: &[&str]) {
    let Some((field, edited)) = editor.kit.applied.take().zip(edited) else { return };
    let is_whole = path.last().is_some_and(|name| name.trim_matches('"') == field);
    let path: Vec<&str> = path.iter().copied().chain((!is_whole).then_some(field.as_str())).collect();
    editor.ask_apply_field(id, edited, playing, &path);
}

/// The fields of a component that the command line set, with what is said of each: those of its first level, or itself.
fn marks(overridden: Option<&Overridden>, fields: &BTreeSet<String>, component: &str) -> BTreeMap<String, String> {
    let Some(overridden) = overridden else { return BTreeMap::new() };
    let inside = |field: &String| {
        let rest = field.strip_prefix(component)?;
        let name = match rest.strip_prefix('.') {
            Some(rest) => rest.split('.').next().unwrap_or(rest),
            None if rest.is_empty() => component,
            None => return None,
        };
        Some((name.to_owned(), overridden.reason(field)))
    };
    fields.iter().filter_map(inside).collect()
}

/// What files leave out of a transform, since it is the usual.
const USUAL: [(&str, &str); 3] = [("translation", "(0.0,0.0,0.0)"), ("rotation", "(0.0,0.0,0.0)"), ("scale", "1.0")];

/// Shows all of the transform, whatever the file says of it.
fn fill_transform(value: &mut Value) {
    let mut transform = value.field("transform").cloned().unwrap_or_else(|| Value::parse("()").unwrap_or_default());
    for (name, usual) in USUAL {
        let looks = name == "rotation" && transform.field("look_at").is_some();
        if transform.field(name).is_none() && !looks {
            transform.set(name, Value::parse(usual).unwrap_or_default());
        }
    }
    value.set("transform", transform);
}

/// Leaves out again what was filled in and not changed.
fn strip_transform(value: &mut Value, written: &Value) {
    let Some(transform) = value.field_mut("transform") else { return };
    let before = written.field("transform");
    for (name, usual) in USUAL {
        let was_there = before.is_some_and(|before| before.field(name).is_some());
        if !was_there && transform.field(name).is_some_and(|now| now.print() == usual) {
            transform.remove(name);
        }
    }
    if before.is_none() && transform.items().is_empty() {
        value.remove("transform");
    }
}

/// Components with parts of their own get a header.
fn is_section(shape: &Shape) -> bool {
    !matches!(shape.inner(), Shape::Bool | Shape::Integer(_) | Shape::Float(_) | Shape::Text)
}

fn section(
    ui: &mut Ui,
    editor: &Editor,
    name: &str,
    key: &str,
    shape: &Shape,
    component: &mut Value,
    remove: &mut bool,
) -> bool {
    let id = ui.make_persistent_id(("component", name));
    let state = egui::collapsing_header::CollapsingState::load_with_default_open(ui.ctx(), id, true);
    let header = state.show_header(ui, |ui| {
        ui.strong(title(name)).on_hover_text(editor.kit.note(key).help);
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let button = ui.small_button("×").on_hover_text("remove this component");
            super::widgets::named(&button, &format!("Remove {}", title(name)));
            *remove = button.clicked();
        });
    });
    let (_, _, body) = header.body(|ui| editor.kit.body(ui, name, key, shape, component));
    body.is_some_and(|body| body.inner)
}

/// Makes the change, to all selected entities that have the changed values.
fn apply(editor: &mut Editor, stage: &mut Stage, id: SceneId, label: &str, old: &Value, new: &Value) {
    let read = |value: &Value| ron_options().from_str::<OverrideFile>(&value.print());
    let mut edits = Vec::new();
    match read(new) {
        Ok(now) => edits.push((id, now)),
        Err(error) => return editor.problem = Some(format!("{label}: {}", error.code)),
    }
    for (other, entity) in editor.selected(stage.world) {
        if other == id || files::is_from_model(stage.world, entity) {
            continue;
        }
        let described = describe_entity(stage.world, entity, stage.files.path).ok();
        let text = described.and_then(|described| ron_options().to_string(&described).ok());
        let Some(mut value) = text.and_then(|text| Value::parse(&text)) else { continue };
        carry(old, new, &mut value);
        edits.extend(read(&value).ok().map(|now| (other, now)));
    }
    let result = editor.edit_components(stage, label, &edits);
    editor.problem = result.err().map(|error| format!("{error:#}"));
}

/// Makes in `target` the changes from `old` to `new`, where it has the changed fields.
fn carry(old: &Value, new: &Value, target: &mut Value) {
    for (key, value) in new.items() {
        let Some(key) = key else { continue };
        match (old.field(key), target.field_mut(key)) {
            (Some(before), _) if before == value => {}
            (Some(before), Some(there)) if has_fields(before) && has_fields(value) && before.head == value.head => {
                carry(before, value, there);
            }
            (_, Some(there)) => *there = value.clone(),
            (None, None) => target.set(key, value.clone()),
            (Some(_), None) => {}
        }
    }
    for (key, _) in old.items() {
        if let Some(key) = key.as_deref().filter(|key| new.field(key).is_none()) {
            target.remove(key);
        }
    }
}

fn has_fields(value: &Value) -> bool {
    value.items().iter().any(|(key, _)| key.is_some())
}

/// Shows what belongs to the scene as a whole.
pub fn show_scene(ui: &mut Ui, editor: &mut Editor, stage: &mut Stage) {
    let Ok(text) = ron_options().to_string(&describe_scene(stage.world)) else { return };
    let Some(mut value) = Value::parse(&text) else { return };
    // Fields that are left out while they are empty.
    for (name, empty) in [("description", "\"\""), ("presets", "{}"), ("materials", "{}")] {
        if value.field(name).is_none() {
            value.set(name, Value::parse(empty).unwrap_or_default());
        }
    }
    if let Some(overridden) = stage.world.ecs.get_resource::<Overridden>() {
        let reason = |field: String| (field.clone(), overridden.reason(&format!("scene.{field}")));
        editor.kit.marks = overridden.settings(&stage.world.rest_settings()).into_iter().map(reason).collect();
    }
    let is_edited = editor.kit.fields(ui, "Scene", &SCENE, &mut value);
    editor.kit.marks.clear();
    if !is_edited {
        return;
    }
    let result = ron_options().from_str::<SceneFile>(&value.print());
    let now = match result {
        Ok(now) => now,
        Err(error) => return editor.problem = Some(error.code.to_string()),
    };
    let result = editor.edit_scene(stage, &now);
    editor.problem = result.err().map(|error| format!("{error:#}"));
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn changes_are_carried_to_others_alone() {
        let parse = |text: &str| Value::parse(text).unwrap();
        let old = parse("(light:(intensity:1.0,color:(1,1,1)),visible:true)");
        let new = parse("(light:(intensity:2.0,color:(1,1,1)))");
        let mut other = parse("(light:(intensity:7.0,color:(0,0,1)),visible:true)");
        carry(&old, &new, &mut other);
        assert_eq!(other.print(), "(light:(intensity:2.0,color:(0,0,1)))");
        let mut without = parse("(camera:())");
        carry(&old, &new, &mut without);
        assert_eq!(without.print(), "(camera:())", "what has no light gets none");
    }
}
