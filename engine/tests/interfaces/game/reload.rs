//! A scene's file that changes while its game runs.

use super::*;
use lightwell::world::{Name, SceneSettings};

/// Rolls on, and keeps how far it got in a field that the file does not mention.
#[derive(Component, SceneData, Clone, Debug, Default, PartialEq)]
struct Wheel {
    /// Speed [m/s].
    speed: f32,
    /// Way so far [m].
    way: f32,
}

/// Something that no file knows.
#[derive(Component)]
struct Unnamed(u32);

#[derive(Resource, Default)]
struct Starts(u32);

const BEFORE: &str = r#"Scene(
    materials: {"red": (color: (1, 0, 0))},
    entities: [
        (name: "Wheel", mesh: Sphere(radius: 0.5), material: "red", components: {"Wheel": (speed: 6)}),
        (name: "Lamp", light: (kind: Point, intensity: 10, color: (1, 1, 1))),
        (name: "Coin", mesh: Sphere(radius: 0.1)),
        (name: "Wall", mesh: Box(size: (4, 2, 1)), children: [(name: "Picture", mesh: Box())]),
        (name: "Ball", prefab: "ball.prefab.ron"),
    ],
)"#;

fn playing(folder: &Folder) -> Game {
    folder.write("a.scene.ron", BEFORE);
    let mut game = Game::new();
    game.add_component::<Runner>().unwrap();
    game.add_component::<Wheel>().unwrap();
    game.world.ecs.init_resource::<Starts>();
    game.add_systems(OnSceneEnter, |mut starts: ResMut<Starts>| starts.0 += 1);
    game.add_systems(FixedUpdate, |time: Res<Time>, mut wheels: Query<(&mut Wheel, &mut Transform)>| {
        for (mut wheel, mut transform) in &mut wheels {
            let way = wheel.speed * time.delta;
            wheel.way += way;
            transform.translation.x += way;
        }
    });
    game.enter(&folder.path("a.scene.ron")).unwrap();
    for _ in 0..60 {
        game.step(&[]).unwrap();
    }
    // What the game does by itself.
    let coin = game.world.find("Coin").unwrap();
    game.world.ecs.despawn(coin);
    let lamp = game.world.find("Lamp").unwrap();
    game.world.ecs.get_mut::<Light>(lamp).unwrap().intensity = 3.0;
    let wheel = game.world.find("Wheel").unwrap();
    game.world.ecs.entity_mut(wheel).insert(Unnamed(7));
    game
}

fn component<C: Component + Clone>(game: &Game, name: &str) -> C {
    game.world.ecs.get::<C>(game.world.find(name).unwrap()).unwrap().clone()
}

#[test]
fn what_the_file_changed_changes_and_all_else_goes_on() {
    let folder = Folder::new();
    let mut game = playing(&folder);
    let wheel = game.world.find("Wheel").unwrap();
    let now = BEFORE
        .replace("speed: 6", "speed: 12")
        .replace("color: (1, 1, 1)", "color: (0, 0, 1)")
        .replace("color: (1, 0, 0)", "color: (0, 1, 0)")
        .replace("radius: 0.1", "radius: 0.2")
        .replace("(name: \"Picture\", mesh: Box())", "(name: \"Clock\", mesh: Box())")
        .replace(
            "entities: [",
            "settings: (exposure: 1), entities: [(name: \"New\", light: (kind: Point, intensity: 1)),",
        );
    folder.write("a.scene.ron", &now);
    game.reload().unwrap();
    assert_eq!(game.world.find("Wheel"), Some(wheel), "the same entity");
    assert_eq!(component::<Wheel>(&game, "Wheel"), Wheel { speed: 12.0, way: component::<Wheel>(&game, "Wheel").way });
    assert!((component::<Wheel>(&game, "Wheel").way - 6.0).abs() < 1e-3, "what the file does not mention goes on");
    assert!((x_of(&game, "Wheel") - 6.0).abs() < 1e-3);
    assert_eq!(game.world.ecs.get::<Unnamed>(wheel).unwrap().0, 7);
    let lamp = component::<Light>(&game, "Lamp");
    assert_eq!((lamp.intensity, lamp.color), (3.0, Vec3::Z), "the intensity is the game's, the colour the file's");
    assert_eq!(component::<MeshRenderer>(&game, "Wheel").material.base_color.truncate(), Vec3::Y);
    assert!(game.world.find("Coin").is_none(), "what was collected stays so");
    assert!(game.world.find("New").is_some() && game.world.find("Wall/Clock").is_some());
    assert!(game.world.find("Wall/Picture").is_none());
    assert_eq!(game.world.ecs.resource::<SceneSettings>().exposure, 1.0);
    assert_eq!(game.world.ecs.resource::<Starts>().0, 1, "it does not start again");
    game.step(&[]).unwrap();
    assert!((component::<Wheel>(&game, "Wheel").way - 6.2).abs() < 1e-3);
}

#[test]
fn a_faulty_file_leaves_the_last_good_one() {
    let folder = Folder::new();
    let mut game = playing(&folder);
    for (from, to, said) in [
        ("speed: 6", "sped: 6", "did you mean `speed`"),
        ("\"Wheel\": (", "\"Whel\": (", "did you mean `Wheel`"),
        ("radius: 0.5", "radius: -0.5", "radius"),
        ("ball.prefab.ron", "bal.prefab.ron", "bal.prefab.ron"),
        ("material: \"red\"", "material: (color_texture: \"no.png\")", "no.png"),
        ("entities: [", "entities: ", "a.scene.ron:"),
    ] {
        folder.write("a.scene.ron", &BEFORE.replace(from, to).replace("intensity: 10", "intensity: 99"));
        let error = message(game.reload());
        assert!(error.contains(said), "{to}: {error}");
        assert_eq!(component::<Light>(&game, "Lamp").intensity, 3.0, "{to}: nothing of it is taken");
        assert!(game.world.find("Ball/Body").is_some());
    }
    folder.write("a.scene.ron", &BEFORE.replace("intensity: 10", "intensity: 99"));
    game.reload().unwrap();
    assert_eq!(component::<Light>(&game, "Lamp").intensity, 99.0, "mended");
}

/// The game has given the wall a mesh that no file can name, so that the wall cannot be merged with its file.
#[test]
fn what_cannot_be_taken_up_changes_nothing_and_is_tried_again() {
    let folder = Folder::new();
    let mut game = playing(&folder);
    let wall = game.world.find("Wall").unwrap();
    let usual = component::<MeshRenderer>(&game, "Wall");
    let mesh = std::sync::Arc::new(lightwell::assets::Mesh::new("made by code", Vec::new(), Vec::new()));
    game.world.ecs.entity_mut(wall).insert(MeshRenderer { mesh, ..usual.clone() });
    let now = BEFORE
        .replace("entities: [", "settings: (exposure: 3), entities: [")
        .replace("intensity: 10", "intensity: 99")
        .replace("size: (4, 2, 1)", "size: (4, 3, 1)");
    folder.write("a.scene.ron", &now);
    let error = message(game.reload());
    assert!(error.contains("Wall"), "{error}");
    assert_eq!(component::<Light>(&game, "Lamp").intensity, 3.0, "nothing of it is taken");
    assert_eq!(game.world.ecs.resource::<SceneSettings>().exposure, SceneSettings::default().exposure);

    game.world.ecs.entity_mut(wall).insert(usual);
    game.reload().unwrap();
    assert_eq!(component::<Light>(&game, "Lamp").intensity, 99.0, "the file before still counts as the known one");
    assert_eq!(game.world.ecs.resource::<SceneSettings>().exposure, 3.0);
}

#[test]
fn changed_prefabs_begin_the_scene_anew_and_broken_ones_do_not() {
    let folder = Folder::new();
    let mut game = playing(&folder);
    folder.write("ball.prefab.ron", "Prefab(entities: [");
    assert!(message(game.reload_all()).contains("ball.prefab.ron:1:"));
    assert!(x_of(&game, "Wheel") > 5.0 && game.world.find("Ball/Body").is_some());
    folder.write("ball.prefab.ron", &PREFAB.replace("Body", "Core"));
    assert_eq!(game.files().len(), 1, "to be watched");
    game.reload_all().unwrap();
    assert!(game.world.find("Ball/Core").is_some() && game.world.find("Coin").is_some());
    assert_eq!((x_of(&game, "Wheel"), game.world.ecs.resource::<Starts>().0), (0.0, 2));
}

#[test]
fn an_instance_that_became_another_is_replaced() {
    let folder = Folder::new();
    let mut game = playing(&folder);
    folder.write("cube.prefab.ron", "Prefab(entities: [(name: \"Cube\", mesh: Box())])");
    folder.write("a.scene.ron", &BEFORE.replace("ball.prefab", "cube.prefab"));
    game.reload().unwrap();
    assert!(game.world.find("Ball/Cube").is_some() && game.world.find("Ball/Body").is_none());
    let names = game.world.roots().into_iter().map(|e| game.world.ecs.get::<Name>(e).unwrap().0.clone());
    assert_eq!(names.filter(|name| name == "Ball").count(), 1);
}

#[test]
fn a_loaded_game_follows_the_file_too() {
    let folder = Folder::new();
    let mut game = playing(&folder);
    let slot = folder.path("slot.ron");
    game.save(&slot).unwrap();
    game.load(&slot).unwrap();
    folder.write("a.scene.ron", &BEFORE.replace("speed: 6", "speed: 1"));
    game.reload().unwrap();
    let wheel = component::<Wheel>(&game, "Wheel");
    assert!(wheel.speed == 1.0 && wheel.way > 5.9, "{wheel:?}");
}

#[test]
fn a_scene_is_changed_before_it_begins_whenever_it_is_entered() {
    let folder = Folder::new();
    folder.write("a.scene.ron", BEFORE);
    let mut game = Game::new();
    game.add_component::<Runner>().unwrap();
    game.add_component::<Wheel>().unwrap();
    #[derive(Resource, Default)]
    struct Seen(Vec<f32>);
    game.world.ecs.init_resource::<Seen>();
    game.add_systems(OnSceneEnter, |wheels: Query<&Wheel>, mut seen: ResMut<Seen>| {
        seen.0.extend(wheels.iter().map(|wheel| wheel.speed));
    });
    game.on_entering(|world, path| {
        if path.ends_with("b.scene.ron") {
            return Err("not this one".into());
        }
        let wheel = world.find("Wheel").ok_or("no wheel")?;
        world.ecs.get_mut::<Wheel>(wheel).ok_or("no wheel")?.speed = 2.5;
        Ok(())
    });
    game.enter(&folder.path("a.scene.ron")).unwrap();
    game.enter(&folder.path("a.scene.ron")).unwrap();
    assert_eq!(game.world.ecs.resource::<Seen>().0, [2.5, 2.5]);
    assert!(message(game.enter(&folder.path("b.scene.ron"))).contains("not this one"));
}
