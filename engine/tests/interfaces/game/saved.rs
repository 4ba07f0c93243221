//! Saved games.

use super::*;

#[test]
fn what_persists_is_saved_with_the_next_scene() {
    let folder = Folder::new();
    let mut game = folder.game();
    let wall = game.world.find("Wall").unwrap();
    game.world.ecs.entity_mut(wall).insert(Persistent);
    game.enter(&folder.path("b.scene.ron")).unwrap();
    let file = folder.path("slot.save.ron");
    game.save(&file).unwrap();
    game.load(&file).unwrap();
    let wall = game.world.find("Wall").unwrap();
    let renderer = game.world.ecs.get::<MeshRenderer>(wall).unwrap();
    assert_eq!(renderer.material.base_color.truncate(), Vec3::X, "its material is no name of the new scene");
    assert!(game.world.ecs.get::<Persistent>(wall).is_some() && game.world.roots().len() == 2);
}

#[test]
fn saved_games_go_on_where_they_were() {
    let folder = Folder::new();
    let mut game = folder.game();
    for _ in 0..10 {
        game.step(&[]).unwrap();
    }
    game.world.ecs.resource_mut::<Score>().points = 7;
    let wall = game.world.find("Wall").unwrap();
    game.world.ecs.get_mut::<MeshRenderer>(wall).unwrap().set_emissive(Vec3::new(0.0, 2.0, 0.0));
    let file = folder.path("slot.save.ron");
    game.save(&file).unwrap();
    for _ in 0..5 {
        game.step(&[]).unwrap();
    }
    game.world.ecs.resource_mut::<Score>().points = 0;
    let later = x_of(&game, "A");
    game.load(&file).unwrap();
    assert!((x_of(&game, "A") - 1.0).abs() < 1e-4);
    assert_eq!(game.world.ecs.resource::<Score>().points, 7);
    let wall = game.world.find("Wall").unwrap();
    assert_eq!(game.world.ecs.get::<MeshRenderer>(wall).unwrap().material.emissive.y, 2.0);
    for _ in 0..5 {
        game.step(&[]).unwrap();
    }
    assert_eq!(x_of(&game, "A").to_bits(), later.to_bits(), "the same steps give the same bits");
    assert_eq!(game.world.ecs.resource::<Time>().step, 15);
    // Into another run of the game, which is in another scene.
    let mut other = folder.game();
    other.enter(&folder.path("b.scene.ron")).unwrap();
    other.load(&file).unwrap();
    assert_eq!((other.world.find("B"), other.world.ecs.resource::<CurrentScene>().name()), (None, "a".to_owned()));
}

#[test]
fn saved_games_that_do_not_fit_are_refused() {
    let folder = Folder::new();
    let mut game = folder.game();
    let file = folder.path("slot.save.ron");
    game.save(&file).unwrap();
    let text = std::fs::read_to_string(&file).unwrap();
    let cases = [
        (text.replace("Score", "Gold"), "the game has none of that name"),
        (text.replace("points:0", "points:\"x\"").replace("points: 0", "points: \"x\""), "the resource `Score`"),
        (text.replace("Runner", "Rnner"), "no component `Rnner`"),
        ("SavedGame(".into(), "slot.save.ron:1"),
        (replaced_number(&text, "step"), "slot.save.ron:"),
        (replaced_number(&text, "scene_since"), "comes after `step:"),
    ];
    for (changed, part) in cases {
        assert_ne!(changed, text);
        std::fs::write(&file, changed).unwrap();
        let error = message(game.load(&file));
        assert!(error.contains(part), "no {part} in {error}");
        assert!(game.world.find("A").is_some(), "the present state stays");
    }
}

/// The text with the largest number in that field.
fn replaced_number(text: &str, field: &str) -> String {
    let start = text.find(&format!("{field}:")).unwrap() + field.len() + 1;
    let end = start + text[start..].find(',').unwrap();
    format!("{} 18446744073709551615{}", &text[..start], &text[end..])
}

/// What a saved game spawns counts against the budget of a load, and the error names the saved game.
#[test]
fn saved_games_spawn_within_the_budget() {
    let folder = Folder::new();
    let mut game = folder.game();
    let file = folder.path("slot.save.ron");
    game.save(&file).unwrap();
    let text = std::fs::read_to_string(&file).unwrap();
    let many =
        r#"(name: "Many", prefab: "ball.prefab.ron", repeat: Line(count: 100000000, points: [(0, 0, 0), (9, 0, 0)])),"#;
    let start = text.find("entities:").unwrap() + text[text.find("entities:").unwrap()..].find('[').unwrap() + 1;
    std::fs::write(&file, format!("{}{many}{}", &text[..start], &text[start..])).unwrap();
    let error = message(game.load(&file));
    assert!(error.contains("slot.save.ron"), "{error}");
    assert!(game.world.find("A").is_some(), "the present state stays");
}

/// A saved game from elsewhere names a scene that does not belong to the game.
#[test]
fn saved_games_stay_in_the_project() {
    let folder = Folder::new();
    let mut game = folder.game();
    let file = folder.path("slot.save.ron");
    game.save(&file).unwrap();
    let text = std::fs::read_to_string(&file).unwrap();
    let elsewhere = tempfile::tempdir().unwrap();
    let scene = elsewhere.path().join("a.scene.ron");
    std::fs::copy(folder.path("a.scene.ron"), &scene).unwrap();
    let written = folder.path("a.scene.ron").display().to_string();
    assert!(text.contains(&written), "{text}");
    for other in [scene.display().to_string(), written.replace("a.scene.ron", "../a.scene.ron"), "//host/a".into()] {
        std::fs::write(&file, text.replace(&written, &other)).unwrap();
        let error = message(game.load(&file));
        assert!(error.contains("slot.save.ron:") && error.contains("--trust DIR"), "{other}: {error}");
    }
    std::fs::write(&file, text.replace(&written, &scene.display().to_string())).unwrap();
    game.set_trusted(vec![elsewhere.path().to_owned()]);
    let error = game.load(&file).err().map(|error| error.to_string()).unwrap_or_default();
    assert!(!error.contains("--trust"), "{error}");
}
