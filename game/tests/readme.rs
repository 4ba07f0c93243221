//! The game in forty lines of the README: what stands there is what is played here.

#![allow(clippy::unwrap_used)]

#[allow(dead_code)]
#[path = "../examples/corner.rs"]
mod corner;

use lightwell_game::prelude::*;
use std::path::Path;

#[test]
fn the_readme_shows_the_game_as_it_is_and_it_can_be_played() {
    let readme = include_str!("../../README.md");
    let game = [include_str!("../examples/corner.rs"), include_str!("../examples/scenes/corner.scene.ron")];
    for text in game {
        assert!(readme.contains(text.trim()), "README.md shows another game:\n{text}");
    }
    assert_eq!(game.map(|text| text.lines().count()).iter().sum::<usize>(), 40, "lines of the game");
    // Its path is relative to the repository, where the README starts it.
    std::env::set_current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("..")).unwrap();
    let light = |x: f32, y: f32| {
        let text = format!("Script(steps: 6, events: [(1, Point({x}, {y}))])");
        let script = InputScript::parse(Path::new("a.script.ron"), &text).unwrap();
        let outcome = corner::app().headless(&script, &Pictures { size: [64, 40], every: 2, folder: None }).unwrap();
        let probe = outcome.game.world.find("Corner").unwrap();
        *outcome.game.world.ecs.get::<LightProbe>(probe).unwrap()
    };
    let hidden = light(0.2, 0.5);
    assert!(hidden.direct == Vec3::ZERO && hidden.indirect.max_element() > 0.0, "reflected light alone: {hidden:?}");
    let seen = light(0.9, 0.5);
    assert!(seen.direct.max_element() > 0.0 && seen.indirect.max_element() > 0.0, "{seen:?}");
}
