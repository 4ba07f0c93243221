//! The game of `docs/game.md`: what stands there is what is played here.

#![allow(clippy::unwrap_used)]

#[allow(dead_code)]
#[path = "moth/moth.rs"]
mod moth;

use lightwell_game::prelude::*;
use moth::app;
use std::path::Path;

#[test]
fn the_page_shows_the_game_as_it_is_and_it_can_be_played() {
    let page = include_str!("../../docs/game.md");
    for (name, text) in [
        ("moth.rs", include_str!("moth/moth.rs")),
        ("moth.scene.ron", include_str!("moth/moth.scene.ron")),
        ("moth.actions.ron", include_str!("moth/moth.actions.ron")),
    ] {
        assert!(page.contains(text.trim()), "docs/game.md shows another {name}");
    }
    // Its paths are relative to where it is started, as a game's are.
    std::env::set_current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/moth")).unwrap();
    let script = InputScript::read(Path::new("way.script.ron")).unwrap();
    let outcome = app().headless(&script, &Pictures { size: [64, 40], every: 20, folder: None }).unwrap();
    let lit = |name: &str| {
        let entity = outcome.game.world.find(name).unwrap();
        let renderer = outcome.game.world.ecs.get::<MeshRenderer>(entity).unwrap();
        let probe = outcome.game.world.ecs.get::<LightProbe>(entity).unwrap();
        (renderer.material.emissive.x > 0.0, probe.direct.x, probe.indirect.x)
    };
    let (left, behind) = (lit("Left"), lit("Behind the screen"));
    assert!(left.0 && left.1 > 0.0, "{left:?}");
    assert!(!behind.0 && behind.1 == 0.0 && behind.2 > 0.0, "in the shade, with bounced light alone: {behind:?}");
    as_the_page_tests_it().unwrap();
}

/// The last step of the page: a test of the game.
fn as_the_page_tests_it() -> Result<(), Box<dyn std::error::Error>> {
    let script = InputScript::read(Path::new("way.script.ron"))?;
    // The rules alone, without a device.
    let game = app().simulate(&script)?;
    let moth = game.world.find("Moth").expect("the scene has a moth");
    assert!(game.world.ecs.get::<Transform>(moth).expect("it stands somewhere").translation.x > -2.5);
    // With images of 64×40 pixels, one every 60 steps.
    let outcome = app().headless(&script, &Pictures { size: [64, 40], every: 60, folder: None })?;
    assert_eq!(outcome.count, 3);
    Ok(())
}
