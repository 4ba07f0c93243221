//! A game that plays in the editor: its systems run on a copy, and Stop brings the scene back.

use super::*;
use crate::editor::{CustomComponent, set_fonts};
use crate::play::playing::{Overlay, PlayedGame};
use bevy_ecs::prelude::*;
use egui::{Key, Modifiers};
use lightwell::files::{ComponentType, ComponentTypes, SceneData};
use lightwell::game::{FixedUpdate, Game, GameCommands, GameError, OnSceneEnter, Time};
use lightwell::world::{Light, Name, Transform};

/// Rises by itself.
#[derive(Component, SceneData, Clone, Default)]
struct Balloon {
    /// Speed \[m/s\].
    speed: f32,
    /// Steps so far.
    steps: u32,
}

/// What the game is to do in the next step.
#[derive(Resource, Clone, Copy, Default)]
enum Wish {
    #[default]
    Rise,
    Panic,
    Fail,
    Quit,
    Elsewhere,
    Restart,
}

fn rise(
    time: Res<Time>,
    mut wish: ResMut<Wish>,
    mut balloons: Query<(&mut Balloon, &mut Transform)>,
    mut commands: Commands,
) -> Result {
    for (mut balloon, mut transform) in &mut balloons {
        balloon.steps += 1;
        transform.translation.y += balloon.speed * time.delta;
    }
    match std::mem::take(&mut *wish) {
        Wish::Rise => {}
        Wish::Panic => panic!("the balloon burst"),
        Wish::Fail => return Err("the balloon leaks".into()),
        Wish::Quit => commands.quit(),
        Wish::Elsewhere => commands.change_scene("other.scene.ron"),
        Wish::Restart => commands.restart_scene(),
    }
    Ok(())
}

fn cloud(mut commands: Commands) {
    commands.spawn((Name("Cloud".into()), Transform::default()));
}

struct Sky(Game);

impl Sky {
    fn new_game() -> anyhow::Result<Box<dyn PlayedGame>> {
        let mut game = Game::new();
        game.add_component::<Balloon>()?;
        game.world.ecs.init_resource::<Wish>();
        game.add_systems(OnSceneEnter, cloud);
        game.add_systems(FixedUpdate, rise);
        Ok(Box::new(Self(game)))
    }
}

impl PlayedGame for Sky {
    fn game(&self) -> &Game {
        &self.0
    }

    fn game_mut(&mut self) -> &mut Game {
        &mut self.0
    }

    fn frame(&mut self, delta: f32, _: egui::RawInput) -> (Result<(), GameError>, Option<Overlay>) {
        (self.0.frame(delta), None)
    }
}

const SKY: &str = r#"Scene(entities: [
    (name: "Camera", transform: (translation: (0, 1, 5)), camera: ()),
    (name: "Lamp", light: (kind: Point, intensity: 20)),
    (name: "Red", transform: (translation: (1, 0, 0)), mesh: Sphere(radius: 0.5), components: {"Balloon": (speed: 3)}),
])"#;

fn sky_bench() -> (Bench, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("other.scene.ron"), SKY.replace("Red", "Blue")).unwrap();
    let path = folder.path().join("sky.scene.ron");
    std::fs::write(&path, SKY).unwrap();
    let mut types = ComponentTypes::default();
    types.add(ComponentType::of::<Balloon>()).unwrap();
    let mut desk = Desk::with_options(&path, LoadOptions { types, ..LoadOptions::default() });
    desk.editor.set_own(vec![CustomComponent::of::<Balloon>()]);
    desk.new_game = Rc::new(Sky::new_game);
    let builder = Harness::builder().with_size([1400.0, 900.0]).with_max_steps(12).with_context_setup(set_fonts);
    let mut bench = builder.build_ui_state(|ui, desk: &mut Desk| desk.show(ui), desk);
    bench.run_steps(3);
    (bench, folder)
}

fn begin(bench: &mut Bench) {
    click(bench, "▶ Play");
    assert!(bench.state().playing.is_some(), "{:?}", bench.state().editor.notice);
}

/// Lets the game's time pass, and shows what came of it.
fn pass(bench: &mut Bench, seconds: f64) -> Option<End> {
    let end = bench.state_mut().pass(seconds);
    bench.run_steps(3);
    end
}

fn game(bench: &Bench) -> &Game {
    bench.state().playing.as_ref().unwrap().game()
}

fn wish(bench: &mut Bench, wish: Wish) {
    bench.state_mut().playing.as_mut().unwrap().game_mut().world.ecs.insert_resource(wish);
}

/// Height of the balloon of the game.
fn height(bench: &Bench) -> f32 {
    let world = &game(bench).world;
    world.ecs.get::<Transform>(world.find("Red").unwrap()).unwrap().translation.y
}

fn step(bench: &Bench) -> u64 {
    bench.state().playing.as_ref().unwrap().time().step
}

fn intensity(world: &GameWorld) -> f32 {
    world.ecs.get::<Light>(world.find("Lamp").unwrap()).unwrap().intensity
}

/// Types a number into a field of the inspector.
fn enter(bench: &mut Bench, name: &str, value: &str) {
    find(bench, name).focus();
    bench.run_steps(2);
    press(bench, Modifiers::COMMAND, Key::A);
    bench.event(egui::Event::Text(value.to_owned()));
    press(bench, Modifiers::NONE, Key::Enter);
    bench.run_steps(3);
}

/// The scene with an unsaved edit, in the inspector.
fn edited_bench() -> (Bench, tempfile::TempDir) {
    let (mut bench, folder) = sky_bench();
    bench.state_mut().select("Lamp");
    bench.run_steps(3);
    enter(&mut bench, "Intensity", "30");
    assert_eq!(intensity(&bench.state().world), 30.0);
    (bench, folder)
}

#[test]
fn play_runs_the_systems_on_a_copy_and_stop_brings_the_scene_back() {
    let (mut bench, _folder) = sky_bench();
    let before = bench.state().text();
    bench.state_mut().select("Red");
    begin(&mut bench);
    assert!(bench.query_by_label("Cloud").is_some(), "the hierarchy shows what a system has spawned");
    assert_eq!(pass(&mut bench, 0.25), None);
    assert!((height(&bench) - 0.75).abs() < 1e-5);
    // The inspector shows what the systems make of the entity that was selected before.
    assert_eq!(find(&bench, "Steps").accesskit_node().numeric_value(), Some(15.0));
    assert!(bench.query_by_label_contains("step 15").is_some());
    assert_eq!(bench.state().text(), before, "the edited world does not move");
    click(&mut bench, "⏹ Stop");
    assert!(bench.state().playing.is_none() && bench.query_by_label("Cloud").is_none());
    assert_eq!(bench.state().text(), before);
    assert!(!bench.state().editor.is_dirty());
    assert_eq!(bench.state().editor.selection, [bench.state().id("Red")]);
    begin(&mut bench);
    assert_eq!(height(&bench), 0.0, "each play begins anew");
}

#[test]
fn a_game_pauses_steps_and_goes_on_by_keys() {
    let (mut bench, _folder) = sky_bench();
    press(&mut bench, Modifiers::NONE, Key::F5);
    press(&mut bench, Modifiers::NONE, Key::F7);
    pass(&mut bench, 1.0);
    assert_eq!(step(&bench), 0, "time stands still");
    press(&mut bench, Modifiers::NONE, Key::F10);
    press(&mut bench, Modifiers::NONE, Key::Period);
    assert_eq!(step(&bench), 2);
    press(&mut bench, Modifiers::COMMAND | Modifiers::SHIFT, Key::P);
    pass(&mut bench, 0.101);
    assert_eq!(step(&bench), 8);
    press(&mut bench, Modifiers::NONE, Key::F8);
    assert!(bench.state().playing.is_none());
    press(&mut bench, Modifiers::COMMAND, Key::P);
    assert!(bench.state().playing.is_some());
    press(&mut bench, Modifiers::COMMAND, Key::P);
    assert!(bench.state().playing.is_none());
    press(&mut bench, Modifiers::NONE, Key::F10);
    assert!(bench.query_by_label("no game plays; F5 plays it").is_some());
}

#[test]
fn edits_in_a_game_end_with_it() {
    let (mut bench, _folder) = edited_bench();
    begin(&mut bench);
    click(&mut bench, "⏸ Pause");
    enter(&mut bench, "Intensity", "70");
    let both = |bench: &Bench| (intensity(&game(bench).world), intensity(&bench.state().world));
    assert_eq!(both(&bench), (70.0, 30.0));
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    assert_eq!(both(&bench), (30.0, 30.0), "undo is that of the game");
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    assert_eq!(both(&bench), (30.0, 30.0), "and of nothing before it");
    press(&mut bench, Modifiers::COMMAND, Key::Y);
    assert_eq!(both(&bench), (70.0, 30.0));
    // Save is for the edited scene.
    press(&mut bench, Modifiers::COMMAND, Key::S);
    assert_eq!(bench.state_mut().requests.pop(), Some(Request::Save));
    assert!(bench.state().text().contains("intensity: 30"), "{}", bench.state().text());
    click(&mut bench, "⏹ Stop");
    assert_eq!(intensity(&bench.state().world), 30.0);
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    assert_eq!(intensity(&bench.state().world), 20.0, "what was done before can be undone again");
}

#[test]
fn what_was_found_good_is_applied_to_the_scene() {
    let (mut bench, _folder) = sky_bench();
    bench.state_mut().select("Lamp");
    begin(&mut bench);
    click(&mut bench, "⏸ Pause");
    enter(&mut bench, "Intensity", "70");
    enter(&mut bench, "Translation y", "2");
    click(&mut bench, "Apply Intensity to the scene");
    assert!(bench.query_by_label("Apply Intensity to the scene").is_none(), "it differs no longer");
    let lamp = |bench: &Bench| {
        let world = &bench.state().world;
        (intensity(world), world.ecs.get::<Transform>(world.find("Lamp").unwrap()).unwrap().translation.y)
    };
    assert_eq!(lamp(&bench), (70.0, 0.0), "the other field is left");
    click(&mut bench, "Apply to scene");
    assert_eq!(lamp(&bench), (70.0, 2.0));
    assert!(bench.state().editor.is_dirty());
    click(&mut bench, "⏹ Stop");
    assert_eq!(lamp(&bench), (70.0, 2.0));
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    assert_eq!(lamp(&bench), (70.0, 0.0), "each was one step");
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    assert_eq!(lamp(&bench), (20.0, 0.0));
    assert!(!bench.state().editor.is_dirty());
}

#[test]
fn fields_of_custom_components_are_applied_too() {
    let (mut bench, _folder) = sky_bench();
    bench.state_mut().select("Red");
    begin(&mut bench);
    pass(&mut bench, 0.1);
    click(&mut bench, "⏸ Pause");
    enter(&mut bench, "Speed", "5");
    click(&mut bench, "Apply Speed to the scene");
    click(&mut bench, "⏹ Stop");
    let world = &bench.state().world;
    let balloon = world.ecs.get::<Balloon>(world.find("Red").unwrap()).unwrap();
    assert_eq!((balloon.speed, balloon.steps), (5.0, 0));
}

#[test]
fn what_only_the_game_has_cannot_be_applied() {
    let (mut bench, _folder) = sky_bench();
    begin(&mut bench);
    click(&mut bench, "⏸ Pause");
    click(&mut bench, "Cloud");
    assert!(find(&bench, "Apply to scene").accesskit_node().is_disabled());
    press(&mut bench, Modifiers::COMMAND, Key::Enter);
    assert!(bench.query_by_label("the edited scene has no such entity").is_some());
    click(&mut bench, "⏹ Stop");
    assert_eq!(bench.state().editor.selection, []);
}

#[test]
fn a_game_that_has_the_keyboard_leaves_few_keys_to_the_editor() {
    let (mut bench, _folder) = sky_bench();
    begin(&mut bench);
    assert!(bench.state().editor.view.has_input);
    press(&mut bench, Modifiers::NONE, Key::H);
    press(&mut bench, Modifiers::NONE, Key::Tab);
    press(&mut bench, Modifiers::NONE, Key::Escape);
    let view = &bench.state().editor.view;
    assert!(view.has_input && !bench.state().editor.hidden);
    let told = |event: &egui::Event| matches!(event, egui::Event::Key { key: Key::H, pressed: true, .. });
    assert!(view.forwarded.iter().any(told), "the game's own interface is told");
    // A click beside the view takes them back, one into it gives them.
    click(&mut bench, "Lamp");
    assert!(!bench.state().editor.view.has_input);
    press(&mut bench, Modifiers::NONE, Key::H);
    assert!(bench.state().editor.hidden);
    press(&mut bench, Modifiers::NONE, Key::H);
    click(&mut bench, "Picture");
    assert!(bench.state().editor.view.has_input && bench.state().requests.is_empty());
    press(&mut bench, Modifiers::NONE, Key::F7);
    assert!(!bench.state().editor.view.has_input);
    press(&mut bench, Modifiers::NONE, Key::Space);
    assert!(bench.state().editor.view.has_input, "Space lets it go on");
    press(&mut bench, Modifiers::NONE, Key::F5);
    assert!(bench.state().playing.is_none() && !bench.state().editor.view.has_input);
}

#[test]
fn a_system_that_panics_ends_the_game_and_the_scene_is_safe() {
    let (mut bench, _folder) = edited_bench();
    begin(&mut bench);
    wish(&mut bench, Wish::Panic);
    assert_eq!(pass(&mut bench, 0.1), Some(End::Panic("the balloon burst".into())));
    assert!(bench.state().playing.is_none());
    assert_eq!(intensity(&bench.state().world), 30.0);
    press(&mut bench, Modifiers::COMMAND, Key::Z);
    assert_eq!(intensity(&bench.state().world), 20.0);
    begin(&mut bench);
    assert_eq!(pass(&mut bench, 0.1), None, "it can be played again");
}

#[test]
fn a_system_that_fails_is_told_and_the_game_goes_on() {
    let (mut bench, _folder) = sky_bench();
    begin(&mut bench);
    wish(&mut bench, Wish::Fail);
    assert_eq!(pass(&mut bench, 0.101), None);
    let trouble = bench.state().playing.as_ref().and_then(Playing::trouble).unwrap().to_owned();
    assert!(trouble.contains("the balloon leaks") && trouble.contains("rise"), "{trouble}");
    assert_eq!(step(&bench), 6);
    wish(&mut bench, Wish::Quit);
    assert_eq!(pass(&mut bench, 0.1), Some(End::Quit));
    assert!(bench.state().playing.is_none());
}

#[test]
fn a_game_that_cannot_begin_says_why() {
    let (mut bench, _folder) = sky_bench();
    bench.state_mut().new_game = Rc::new(|| anyhow::bail!("no actions"));
    click(&mut bench, "▶ Play");
    assert!(bench.state().playing.is_none());
    assert!(bench.query_by_label("cannot play: no actions").is_some());
    assert!(bench.query_by_label("▶ Play").is_some());
}

#[test]
fn other_scenes_are_played_and_the_edited_one_restarts_as_it_is_edited() {
    let (mut bench, _folder) = edited_bench();
    begin(&mut bench);
    wish(&mut bench, Wish::Restart);
    pass(&mut bench, 0.1);
    assert_eq!(intensity(&game(&bench).world), 30.0, "unsaved edits count");
    assert!(!find(&bench, "Apply to scene").accesskit_node().is_disabled());
    wish(&mut bench, Wish::Elsewhere);
    pass(&mut bench, 0.1);
    let world = &game(&bench).world;
    assert!(world.find("Blue").is_some() && world.find("Red").is_none());
    assert_eq!(intensity(world), 20.0, "that scene is read from its file");
    assert!(bench.query_by_label("Blue").is_some());
    click(&mut bench, "⏹ Stop");
    assert!(bench.query_by_label("Red").is_some() && bench.query_by_label("Blue").is_none());
    assert_eq!(intensity(&bench.state().world), 30.0);
}

#[test]
fn without_a_game_the_engine_plays_what_moves_by_itself() {
    let (mut bench, _folder) = bench();
    let before = bench.state().text();
    begin(&mut bench);
    pass(&mut bench, 0.2501);
    pass(&mut bench, 0.2501);
    let world = &game(&bench).world;
    let mover = world.ecs.get::<Transform>(world.find("Mover").unwrap()).unwrap();
    assert!((mover.translation.x - 0.5).abs() < 1e-5, "{}", mover.translation);
    click(&mut bench, "⏹ Stop");
    assert_eq!(bench.state().text(), before);
}
