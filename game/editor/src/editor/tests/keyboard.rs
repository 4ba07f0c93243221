//! Everything without a mouse.

use super::*;
use egui::{Key, Modifiers};
use lightwell::world::Light;
use std::collections::BTreeSet;

/// The name of what has the keyboard, and its number.
fn focused(bench: &Bench) -> Option<(String, impl Ord + use<>)> {
    let all: Vec<_> = bench.root().children_recursive().collect();
    let node = all.into_iter().find(|node| node.accesskit_node().is_focused())?;
    let node = node.accesskit_node();
    let name = node.label().or_else(|| node.value()).unwrap_or_default();
    Some((name, node.id()))
}

/// Presses Tab until it has come around; gives what it came by.
fn walk(bench: &mut Bench) -> Vec<String> {
    let (mut names, mut seen) = (Vec::new(), BTreeSet::new());
    for _ in 0..500 {
        bench.key_press(Key::Tab);
        bench.run_steps(2);
        let Some((name, id)) = focused(bench) else { continue };
        if !seen.insert(id) {
            return names;
        }
        names.push(name);
    }
    panic!("Tab does not come around: {names:?}");
}

#[test]
fn tab_comes_by_everything() {
    let (mut bench, _folder) = bench();
    bench.state_mut().select("Lamp");
    bench.run_steps(3);
    let names = walk(&mut bench);
    for wanted in [
        "File",
        "Edit",
        "Debug",
        "Panels",
        "▶ Play",
        "Preview",
        "Time",
        "Search",
        "Camera",
        "Lamp",
        "Group",
        "Kind",
        "Intensity",
        "Color x",
        "Translation x",
        "Casts shadow",
        "Remove Light",
        "Add component",
    ] {
        assert!(names.iter().any(|name| name == wanted), "{wanted} is not reached; Tab comes by {names:?}");
    }
}

fn tab_to(bench: &mut Bench, wanted: &str) {
    for _ in 0..300 {
        if focused(bench).is_some_and(|(name, _)| name == wanted) {
            return;
        }
        bench.key_press(Key::Tab);
        bench.run_steps(2);
    }
    panic!("Tab does not come to {wanted}");
}

fn type_text(bench: &mut Bench, text: &str) {
    bench.event(egui::Event::Text(text.to_owned()));
    bench.run_steps(2);
}

#[test]
fn a_light_is_found_changed_and_undone_by_the_keyboard_alone() {
    let (mut bench, _folder) = bench();
    let intensity = |bench: &Bench| {
        let desk = bench.state();
        desk.world.ecs.get::<Light>(desk.world.find("Lamp").unwrap()).unwrap().intensity
    };
    press(&mut bench, Modifiers::COMMAND, Key::F);
    type_text(&mut bench, "lam");
    tab_to(&mut bench, "Lamp");
    press(&mut bench, Modifiers::NONE, Key::Enter);
    assert_eq!(bench.state().editor.selection, [bench.state().id("Lamp")], "Enter selects");
    tab_to(&mut bench, "Intensity");
    press(&mut bench, Modifiers::COMMAND, Key::A);
    type_text(&mut bench, "35");
    press(&mut bench, Modifiers::NONE, Key::Enter);
    assert_eq!(intensity(&bench), 35.0);
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    assert_eq!(intensity(&bench), 20.0);
    tab_to(&mut bench, "Kind");
    press(&mut bench, Modifiers::NONE, Key::Enter);
    tab_to(&mut bench, "Spot");
    press(&mut bench, Modifiers::NONE, Key::Enter);
    let desk = bench.state();
    let light = desk.world.rest_light(desk.world.find("Lamp").unwrap()).unwrap();
    assert!(matches!(light.kind, lightwell::world::LightKind::Spot { .. }), "a choice opens and is made by Enter");
}
