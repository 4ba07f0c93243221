//! Components of a game in the inspector: shown, changed, added, removed, undone and saved like any other.

use super::*;
use crate::editor::custom_component::CustomComponent;
use crate::editor::schema::Shape;
use bevy_ecs::prelude::Component;
use egui::{Key, Modifiers};
use lightwell::files::{ComponentType, SceneData};

/// How a door opens.
#[derive(SceneData, Clone, Debug, Default, PartialEq)]
enum Opening {
    /// By itself.
    #[default]
    Alone,
    /// With a key.
    Locked {
        /// Turns of the key, 1 to 4.
        turns: u32,
    },
}

/// Leads somewhere.
#[derive(Component, SceneData, Clone, Debug, Default, PartialEq)]
struct Door {
    /// Angle when it is open, 0 to 120 [degrees].
    angle: f32,
    /// How it opens.
    opening: Opening,
}

/// Says hello.
#[derive(Component, SceneData, Clone, Debug, Default, PartialEq)]
struct Greeter {
    /// What it says.
    text: String,
}

fn own<C: SceneData>() -> CustomComponent {
    let mut notes = Vec::new();
    C::describe(&mut notes);
    CustomComponent { name: C::NAME, shape: Shape::of::<C>(), notes }
}

fn bench() -> (Bench, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("test.scene.ron");
    let scene = r#"Scene(entities: [
        (name: "Camera", camera: ()),
        (name: "Door", mesh: Box(), components: {"Door": (angle: 30), "Unknown": (kept: "as it is")}),
    ])"#;
    std::fs::write(&path, scene).unwrap();
    let mut options = LoadOptions::default();
    options.types.add(ComponentType::of::<Door>()).unwrap();
    options.types.add(ComponentType::of::<Greeter>()).unwrap();
    let mut desk = Desk::with_options(&path, options);
    desk.editor.set_own(vec![own::<Door>(), own::<Greeter>()]);
    desk.select("Door");
    let context = super::super::set_fonts;
    let builder = Harness::builder().with_size([1400.0, 900.0]).with_max_steps(12).with_context_setup(context);
    let mut harness = builder.build_ui_state(|ui, desk: &mut Desk| desk.show(ui), desk);
    harness.run_steps(3);
    (harness, folder)
}

fn get<C: Component + Clone>(bench: &Bench) -> Option<C> {
    let desk = bench.state();
    desk.world.ecs.get::<C>(desk.world.find("Door").unwrap()).cloned()
}

#[test]
fn a_field_is_dragged_saved_and_undone() {
    let (mut bench, _folder) = bench();
    let before = bench.state().text();
    let at = place_of(&bench, "Angle");
    drag(&mut bench, at, at + egui::vec2(40.0, 0.0));
    let changed = get::<Door>(&bench).unwrap().angle;
    assert!(changed > 30.5 && changed <= 120.0, "{changed}");
    let text = bench.state().text();
    assert!(text.contains(&format!("\"Door\": (angle: {changed:?}")), "{text}");
    assert!(text.contains("\"Unknown\": (kept: \"as it is\")"), "what nobody knows is kept: {text}");
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    assert_eq!((get::<Door>(&bench).unwrap().angle, bench.state().text()), (30.0, before));
}

#[test]
fn a_variant_is_chosen() {
    let (mut bench, _folder) = bench();
    click(&mut bench, "Opening");
    click(&mut bench, "Locked");
    assert!(matches!(get::<Door>(&bench).unwrap().opening, Opening::Locked { .. }));
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    assert_eq!(get::<Door>(&bench).unwrap().opening, Opening::Alone);
}

#[test]
fn they_are_added_and_removed_like_any_other() {
    let (mut bench, _folder) = bench();
    click(&mut bench, "Add component");
    click(&mut bench, "Greeter");
    assert_eq!(get::<Greeter>(&bench), Some(Greeter::default()));
    click(&mut bench, "Remove Door");
    assert_eq!(get::<Door>(&bench), None);
    assert!(!bench.state().text().contains("Door\": ("));
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    assert_eq!((get::<Door>(&bench).map(|door| door.angle), get::<Greeter>(&bench)), (Some(30.0), None));
}

#[test]
fn help_unit_and_range_come_from_comments() {
    let (bench, _folder) = bench();
    let kit = &bench.state().editor.kit;
    let note = kit.note("Door.angle");
    assert_eq!((note.unit, note.range), (Some("°"), Some(0.0..=120.0)));
    assert_eq!(kit.note("Greeter").help, "Says hello.");
    assert_eq!(kit.note("Opening.Locked.turns").range, Some(1.0..=4.0));
}
