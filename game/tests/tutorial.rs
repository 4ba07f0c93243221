//! The game of the README's "Write a game": what stands there is what is played here.

#![allow(clippy::unwrap_used)]

#[allow(dead_code)]
#[path = "moth/moth.rs"]
mod moth;

use lightwell_game::prelude::*;
use std::path::Path;

#[test]
fn the_readme_shows_the_game_as_it_is_and_it_can_be_played() {
    let readme = include_str!("../../README.md");
    for (name, text) in [
        ("moth.rs", include_str!("moth/moth.rs")),
        ("moth.scene.ron", include_str!("moth/moth.scene.ron")),
        ("moth.actions.ron", include_str!("moth/moth.actions.ron")),
    ] {
        assert!(readme.contains(text.trim()), "README.md shows another {name}");
    }
    // Its paths are relative to where it is started, as a game's are.
    std::env::set_current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/moth")).unwrap();
    let text = "Script(steps: 180, events: [(1, Press(Key(D))), (60, Release(Key(D))), (60, Press(Key(W))), (150, Release(Key(W)))])";
    let script = InputScript::parse(Path::new("way.script.ron"), text).unwrap();
    let outcome = moth::app().headless(&script, &Pictures { size: [64, 40], every: 20, folder: None }).unwrap();
    let lit = |name: &str| {
        let entity = outcome.game.world.find(name).unwrap();
        let renderer = outcome.game.world.ecs.get::<MeshRenderer>(entity).unwrap();
        let probe = outcome.game.world.ecs.get::<LightProbe>(entity).unwrap();
        (renderer.material.emissive.x > 0.0, probe.direct.x, probe.indirect.x)
    };
    let (left, behind) = (lit("Left"), lit("Behind the screen"));
    assert!(left.0 && left.1 > 0.0, "{left:?}");
    assert!(!behind.0 && behind.1 == 0.0 && behind.2 > 0.0, "in the shade, with bounced light alone: {behind:?}");
}
