//! The small examples, played.

#![allow(clippy::unwrap_used)]

use lightwell_game::prelude::*;
use std::path::Path;

#[allow(dead_code)]
#[path = "../examples/change_scene.rs"]
mod change_scene;
#[allow(dead_code)]
#[path = "../examples/hello_light.rs"]
mod hello_light;
#[allow(dead_code)]
#[path = "../examples/own_component.rs"]
mod own_component;

fn script(text: &str) -> InputScript {
    InputScript::parse(Path::new("a.script.ron"), text).unwrap()
}

fn place(game: &Game, name: &str) -> Vec3 {
    game.world.ecs.get::<Transform>(game.world.find(name).unwrap()).unwrap().translation
}

#[test]
fn lifts_ride_as_the_scene_says() {
    let at = |steps: u64| {
        let game = own_component::app().simulate(&InputScript { steps, ..Default::default() }).unwrap();
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
