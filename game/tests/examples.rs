//! The small examples, played.

#![allow(clippy::unwrap_used)]

use lightwell_game::prelude::*;
use std::path::Path;

#[allow(dead_code)]
#[path = "../examples/change_scene.rs"]
mod change_scene;
#[allow(dead_code)]
#[path = "../examples/custom_component.rs"]
mod custom_component;
#[allow(dead_code)]
#[path = "../examples/custom_method/main.rs"]
mod custom_method;
#[allow(dead_code)]
#[path = "../examples/hello_light.rs"]
mod hello_light;

fn script(text: &str) -> InputScript {
    InputScript::parse(Path::new("a.script.ron"), text).unwrap()
}

fn place(game: &Game, name: &str) -> Vec3 {
    game.world.ecs.get::<Transform>(game.world.find(name).unwrap()).unwrap().translation
}

#[test]
fn lifts_ride_as_the_scene_says() {
    let at = |steps: u64| {
        let game = custom_component::app().simulate(&InputScript { steps, ..Default::default() }).unwrap();
        ["First", "Second", "Third"].map(|name| place(&game, name).y)
    };
    let close = |a: [f32; 3], b: [f32; 3]| assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 0.03), "{a:?} {b:?}");
    close(at(60), [1.125, 0.25 + 2.75 / 2.0, 2.0]);
    close(at(120), [2.0, 3.0, 2.0]);
    close(at(30), [0.25 + 1.75 * 0.15625, 0.25 + 2.75 / 4.0, 1.125]);
}

#[test]
fn the_walker_goes_from_room_to_room() {
    let right = "(1, Press(Key(D))), (120, Release(Key(D)))";
    let game = change_scene::app().simulate(&script(&format!("Script(steps: 125, events: [{right}])"))).unwrap();
    assert_eq!(game.world.ecs.resource::<CurrentScene>().name(), "right");
    assert!(game.world.find("Walker").is_some() && game.world.roots().len() == 9);
    let back = format!("Script(steps: 260, events: [{right}, (130, Press(Pad(Left))), (131, Move(LeftX, -1))])");
    let game = change_scene::app().simulate(&script(&back)).unwrap();
    assert_eq!(game.world.ecs.resource::<CurrentScene>().name(), "left", "by the stick too");
    assert!(place(&game, "Walker").x < 1.9);
}

#[test]
fn a_hidden_corner_has_bounced_light_alone() {
    let pictures = Pictures { size: [64, 40], every: 2, folder: None };
    let outcome = hello_light::app().headless(&script("Script(steps: 6)"), &pictures).unwrap();
    assert_eq!(outcome.count, 3);
    let probe = outcome.game.world.find("Behind the screen").unwrap();
    let probe = *outcome.game.world.ecs.get::<LightProbe>(probe).unwrap();
    assert_eq!(probe.direct, Vec3::ZERO);
    assert!(
        probe.indirect.min_element() > 0.0 && probe.indirect.x > 1.5 * probe.indirect.z,
        "of the red wall: {probe:?}"
    );
}

#[test]
fn own_components_are_set_on_the_command_line() {
    let folder = tempfile::tempdir().unwrap();
    let run = |name: &str, set: &str| {
        let out = folder.path().join(name);
        let words: Vec<std::ffi::OsString> = [
            "lifts",
            "--headless",
            "--steps",
            "1",
            "--every",
            "1",
            "--size",
            "48x30",
            "--gi",
            "none",
            "--set",
            set,
            "-o",
        ]
        .map(Into::into)
        .to_vec();
        let code = custom_component::app().run_with(words.into_iter().chain([out.clone().into_os_string()]));
        (code == std::process::ExitCode::SUCCESS, std::fs::read(out.join("step_0001.png")).ok())
    };
    let (low, high) = (run("low", "First.Lift.low=0.25"), run("high", "First.Lift.low=1.5"));
    assert!(low.0 && high.0 && low.1 != high.1, "the lift stands higher");
    for wrong in ["First.Lift.lowe=1", "First.Lift.low=deep", "First.Left.low=1", "Frist.Lift.low=1"] {
        assert_eq!(run("wrong", wrong), (false, None), "{wrong}");
    }
}

#[test]
fn faulty_games_say_what_to_do() {
    /// Another type of that name.
    #[derive(Component, SceneData, Clone, Default)]
    struct Lift;
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/scenes/lift.scene.ron");
    let error = |app: App| format!("{:#}", app.start().map(drop).unwrap_err());
    let bare = error(App::new(scene));
    assert!(bare.contains("the game has no component `Lift`") && bare.contains(".component::<Lift>()"), "{bare}");
    let twice = error(custom_component::app().component::<Lift>());
    assert!(twice.contains("two types are named `Lift`") && twice.contains("rename one of them"), "{twice}");
    let lost = error(App::new("nowhere.scene.ron"));
    assert!(lost.contains("nowhere.scene.ron"), "{lost}");
    let table = error(App::new(scene).component::<custom_component::Lift>().actions("none.actions.ron"));
    assert!(table.contains("none.actions.ron"), "{table}");
    fn needs(_: Res<Hidden>) {}
    #[derive(Resource)]
    struct Hidden;
    let app = custom_component::app().systems(FixedUpdate, needs);
    let failed = format!("{:#}", app.simulate(&script("Script(steps: 3)")).map(drop).unwrap_err());
    assert!(
        failed.starts_with("step 1: system") && failed.contains("needs") && failed.contains(".resource("),
        "{failed}"
    );
}

#[test]
fn a_custom_method_is_chosen_and_set_by_scene_and_command_line() {
    let folder = tempfile::tempdir().unwrap();
    let run = |words: &[&str]| {
        let out = folder.path().join(words.join(" ").replace(['/', '.'], "_"));
        let always = ["yard", "--headless", "--steps", "1", "--every", "1", "--size", "48x30", "-o"];
        let all = always.into_iter().map(Into::into).chain([out.clone().into_os_string()]);
        let code = custom_method::app().run_with(all.chain(words.iter().map(Into::into)));
        assert_eq!(code, std::process::ExitCode::SUCCESS, "{words:?}");
        std::fs::read(out.join("step_0001.png")).unwrap()
    };
    let scene = run(&[]);
    assert!(scene == run(&["--gi", "hemisphere"]), "the scene asks for it by `gi: Hemisphere`");
    assert!(scene != run(&["--gi", "none"]), "it lights the yard");
    assert!(scene != run(&["--set", "Ambient.HemisphereLight.sky=3"]), "its settings are in the scene");
}

#[test]
fn a_method_that_is_not_registered_is_refused_with_those_that_are() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.scene.ron");
    let error = |app: App| format!("{:#}", app.start().map(drop).unwrap_err());
    let write =
        |gi: &str| std::fs::write(&path, format!("Scene(gi: {gi}, entities: [(name: \"Camera\", camera: ())])"));
    let app = || App::new(path.display().to_string());
    write("Hemisphere").unwrap();
    let unknown = error(app());
    assert!(unknown.contains("a.scene.ron:1:11") && unknown.contains("`Hemisphere`"), "{unknown}");
    assert!(["None", "Clpv", "Vpl", "Slc"].iter().all(|known| unknown.contains(known)), "{unknown}");
    app().method(|| custom_method::method::Hemisphere).start().unwrap();
    write("Hemispere").unwrap();
    let misspelt = error(app().method(|| custom_method::method::Hemisphere));
    assert!(misspelt.contains("did you mean `Hemisphere`?"), "{misspelt}");
}
