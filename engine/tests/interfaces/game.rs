//! A game without a window: steps, input, scenes, prefabs, saved games, and what goes wrong.

#![allow(clippy::unwrap_used)]

use bevy_ecs::prelude::*;
use glam::Vec3;
use lightwell::files::SceneData;
use lightwell::game::*;
use lightwell::world::{Camera, GlobalTransform, Light, MeshRenderer, Transform};
use std::path::{Path, PathBuf};
use std::sync::Arc;

mod bad_use;
mod reload;
mod saved;

/// Moves along x.
#[derive(Component, SceneData, Clone, Debug, Default, PartialEq)]
struct Runner {
    /// Speed [m/s].
    speed: f32,
}

/// What was reached.
#[derive(Resource, SceneData, Clone, Debug, Default, PartialEq)]
struct Score {
    /// Points.
    points: u32,
}

fn run(time: Res<Time>, mut runners: Query<(&Runner, &mut Transform)>) {
    for (runner, mut transform) in &mut runners {
        transform.translation.x += runner.speed * time.delta;
    }
}

const SCENE: &str = r#"Scene(
    materials: {"red": (color: (1, 0, 0))},
    entities: [
        (name: "A", components: {"Runner": (speed: 6)}),
        (name: "Wall", transform: (translation: (0, 1, -5)), mesh: Box(size: (4, 2, 1)), material: "red"),
    ],
)"#;

const PREFAB: &str = r#"Prefab(entities: [
    (name: "Body", mesh: Sphere(radius: 0.5), components: {"Runner": (speed: 1)}),
])"#;

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        folder.write("a.scene.ron", SCENE);
        folder.write("b.scene.ron", r#"Scene(entities: [(name: "B")])"#);
        folder.write("ball.prefab.ron", PREFAB);
        folder
    }

    fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.path(name);
        std::fs::write(&path, text).unwrap();
        path
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn game(&self) -> Game {
        let mut game = Game::new();
        game.add_component::<Runner>().unwrap();
        game.add_saved_resource(Score::default()).unwrap();
        game.add_systems(FixedUpdate, run);
        game.enter(&self.path("a.scene.ron")).unwrap();
        game
    }
}

fn x_of(game: &Game, name: &str) -> f32 {
    game.world.ecs.get::<Transform>(game.world.find(name).unwrap()).unwrap().translation.x
}

fn message(result: Result<(), GameError>) -> String {
    result.unwrap_err().to_string()
}

#[test]
fn steps_are_equally_long_and_frames_come_between() {
    #[derive(Resource, Default)]
    struct Seen(Vec<(u64, f32)>);
    let folder = Folder::new();
    let mut game = folder.game();
    game.set_rate(30);
    game.world.ecs.init_resource::<Seen>();
    game.add_systems(Update, |time: Res<Time>, mut seen: ResMut<Seen>| seen.0.push((time.step, time.delta)));
    for step in 0..30 {
        game.step(&[]).unwrap();
        if step % 10 == 9 {
            game.frame(0.25).unwrap();
        }
    }
    assert!((x_of(&game, "A") - 6.0).abs() < 1e-4);
    assert_eq!(game.world.ecs.resource::<Seen>().0, [(10, 0.25), (20, 0.25), (30, 0.25)]);
    assert_eq!(game.world.ecs.resource::<Time>().elapsed, 1.0);
}

#[test]
fn messages_observers_and_events_are_those_of_bevy() {
    #[derive(Message)]
    struct Found(u32);
    #[derive(Event)]
    struct Cheer;
    let folder = Folder::new();
    let mut game = folder.game();
    game.add_message::<Found>();
    game.add_observer(|_: On<Cheer>, mut score: ResMut<Score>| score.points += 100);
    game.add_observer(|added: On<Add<Runner>>, mut commands: Commands| {
        commands.entity(added.entity).insert(Light::default());
    });
    let send = |mut found: MessageWriter<Found>| {
        found.write(Found(2));
    };
    let receive = |mut found: MessageReader<Found>, mut score: ResMut<Score>, mut commands: Commands| {
        for Found(points) in found.read() {
            score.points += points;
            commands.trigger(Cheer);
        }
    };
    game.add_systems(FixedUpdate, (send, receive).chain());
    for _ in 0..3 {
        game.step(&[]).unwrap();
        game.frame(0.0).unwrap();
    }
    assert_eq!(game.world.ecs.resource::<Score>().points, 306);
    game.enter(&folder.path("a.scene.ron")).unwrap();
    let runner = game.world.find("A").unwrap();
    assert!(game.world.ecs.get::<Light>(runner).is_some(), "observers see what a scene brings");
}

#[test]
fn prefabs_come_and_subtrees_are_copied() {
    let folder = Folder::new();
    let mut game = folder.game();
    let at = Transform { translation: Vec3::new(3.0, 0.0, 0.0), ..Transform::default() };
    game.add_systems(FixedUpdate, move |time: Res<Time>, mut commands: Commands| {
        if time.step <= 2 {
            commands.spawn_prefab("ball.prefab.ron", at).insert(Runner { speed: 0.0 });
        }
    });
    game.step(&[]).unwrap();
    let ball = game.world.find("ball").unwrap();
    assert_eq!(game.world.ecs.get::<Transform>(ball).unwrap().translation, at.translation);
    assert_eq!(game.world.ecs.get::<Runner>(ball).unwrap().speed, 0.0, "what was given to it stays");
    let body = game.world.find("ball/Body").unwrap();
    assert!(game.world.ecs.get::<MeshRenderer>(body).is_some());
    game.step(&[]).unwrap();
    assert!(game.world.find("ball 2/Body").is_some(), "names are made new");
    let copy = |query: Query<(Entity, &lightwell::world::Name)>, time: Res<Time>, mut commands: Commands| {
        for (entity, name) in &query {
            if name.0 == "ball" && time.step == 3 {
                commands.clone_subtree(entity).insert(Runner { speed: 9.0 });
            }
        }
    };
    game.add_systems(FixedUpdate, copy);
    game.step(&[]).unwrap();
    let third = game.world.find("ball 3").unwrap();
    assert_eq!(game.world.ecs.get::<Runner>(third).unwrap().speed, 9.0);
    assert!(game.world.find("ball 3/Body").is_some());
}

#[test]
fn scenes_change_and_what_persists_stays() {
    #[derive(Resource, Default)]
    struct Starts(Vec<String>);
    let folder = Folder::new();
    let mut game = folder.game();
    game.world.ecs.init_resource::<Starts>();
    game.add_systems(OnSceneEnter, |scene: Res<CurrentScene>, mut starts: ResMut<Starts>| starts.0.push(scene.name()));
    let runner = game.world.find("A").unwrap();
    let wall = game.world.find("Wall").unwrap();
    game.world.ecs.entity_mut(runner).insert(Persistent);
    let next = folder.path("b.scene.ron");
    game.add_systems(FixedUpdate, move |time: Res<Time>, mut commands: Commands| match time.step {
        2 => commands.change_scene(&next),
        4 => commands.restart_scene(),
        _ => {}
    });
    for _ in 0..5 {
        game.step(&[]).unwrap();
    }
    assert_eq!(game.world.ecs.resource::<Starts>().0, ["b", "b"]);
    assert!(game.world.ecs.get_entity(wall).is_err(), "the scene before is gone");
    assert!((x_of(&game, "A") - 0.5).abs() < 1e-4, "what persists goes on");
    assert!(game.world.find("B").is_some() && game.world.roots().len() == 2);
}

#[test]
fn meshes_of_a_scene_are_released_when_it_is_left() {
    let folder = Folder::new();
    let mut game = folder.game();
    let mut walls = game.world.ecs.query::<&MeshRenderer>();
    let wall = Arc::downgrade(&walls.single(&game.world.ecs).unwrap().mesh);
    game.enter(&folder.path("a.scene.ron")).unwrap();
    assert!(wall.upgrade().is_some(), "a scene that is entered again has the same mesh");
    game.enter(&folder.path("b.scene.ron")).unwrap();
    assert!(wall.upgrade().is_none(), "nothing needs the mesh");
}

#[test]
fn a_scene_that_cannot_be_loaded_leaves_the_present_one() {
    let folder = Folder::new();
    let mut game = folder.game();
    let bad =
        folder.write("bad.scene.ron", r#"Scene(entities: [(name: "New"), (name: "X", prefab: "none.prefab.ron")])"#);
    let error = message(game.enter(&bad));
    assert!(error.contains("bad.scene.ron:1") && error.contains("there is no prefab `none.prefab.ron`"), "{error}");
    assert!(game.world.find("A").is_some() && game.world.find("New").is_none());
    game.step(&[]).unwrap();
    let missing = message(game.enter(Path::new("nowhere.scene.ron")));
    assert!(missing.contains("there is no such file"), "{missing}");
    let model = message(game.enter(Path::new("fox.glb")));
    assert!(model.contains("model"), "{model}");
}

#[test]
fn a_script_plays_the_same_game_again() {
    let actions = r#"Actions(
        buttons: {"boost": [Key(Space), Pad(South)]},
        axes: {"right": [Buttons(negative: Key(A), positive: Key(D)), Stick(LeftX)]},
    )"#;
    let folder = Folder::new();
    let play = |script: &InputScript| {
        let mut game = folder.game();
        game.set_actions(Actions::parse(Path::new("a.actions.ron"), actions).unwrap());
        let steer = |input: Res<Input>, mut runners: Query<&mut Runner>| {
            for mut runner in &mut runners {
                runner.speed += input.axis("right") + if input.just_pressed("boost") { 10.0 } else { 0.0 };
            }
        };
        game.add_systems(FixedUpdate, steer.before(run));
        let mut recorded = InputScript::default();
        for step in 1..=script.steps {
            let events = script.at(step);
            game.step(&events).unwrap();
            recorded.record(&events);
        }
        (x_of(&game, "A"), recorded)
    };
    let text = r#"Script(steps: 20, events: [
        (3, Press(Key(D))), (7, Release(Key(D))), (7, Press(Pad(South))), (9, Press(Pad(South))), (12, Move(LeftX, -0.5)),
    ])"#;
    let script = InputScript::parse(Path::new("a.script.ron"), text).unwrap();
    let (end, recorded) = play(&script);
    assert_eq!(recorded, script);
    let file = folder.path("recorded.script.ron");
    recorded.write(&file).unwrap();
    assert_eq!(play(&InputScript::read(&file).unwrap()).0.to_bits(), end.to_bits());
    // The key is down in steps 3 to 6, the pad's button goes down in step 7 alone, the stick is held from step 12 on.
    let mut speed = 6.0;
    let expected: f32 = (1..=20)
        .map(|step| {
            speed += match step {
                3..=6 => 1.0,
                7 => 10.0,
                12.. => -0.5,
                _ => 0.0,
            };
            speed / 60.0
        })
        .sum();
    assert!((end - expected).abs() < 1e-3, "{end} instead of {expected}");
}

#[test]
fn tables_and_scripts_with_mistakes_say_where() {
    let actions = |text: &str| Actions::parse(Path::new("x.actions.ron"), text).unwrap_err().to_string();
    let cases = [
        ("Actions(buttons: {\"a\": [Key(Spcae)]})", vec!["x.actions.ron:1:", "unknown variant `Spcae`", "`Space`"]),
        ("Actions(buttons: {\"a\": [Key(A)], \"a\": [Key(B)]})", vec!["`a` is given twice"]),
        ("Actions(buttons: {\"a\": []})", vec!["nothing is bound to `a`", "1:"]),
        ("Actions(axis: {})", vec!["unknown field `axis`", "did you mean `axes`?"]),
    ];
    for (text, parts) in cases {
        let error = actions(text);
        parts.iter().for_each(|part| assert!(error.contains(part), "no {part} in {error}"));
    }
    let script = |text: &str| InputScript::parse(Path::new("x.script.ron"), text).unwrap_err().to_string();
    let late = script("Script(steps: 5, events: [(2, Wheel(1)), (1, Wheel(1))])");
    assert!(late.contains("step 1 comes after step 2") && late.contains("1:"), "{late}");
    let beyond = script("Script(steps: 5, events: [(6, Wheel(1))])");
    assert!(beyond.contains("behind the end"), "{beyond}");
    let endless = script("Script(\n  steps: 18446744073709551615)");
    assert!(endless.contains("x.script.ron:2:") && endless.contains("at most 10000000"), "{endless}");
}

#[test]
fn a_system_ends_the_game() {
    let folder = Folder::new();
    let mut game = folder.game();
    game.add_systems(FixedUpdate, |time: Res<Time>, mut commands: Commands| {
        if time.step == 2 {
            commands.quit();
        }
    });
    game.step(&[]).unwrap();
    assert!(!game.has_ended());
    game.step(&[]).unwrap();
    assert!(game.has_ended());
}

#[test]
fn timers_end_when_they_should() {
    let mut once = Timer::once(0.5);
    assert_eq!([once.tick(0.3), once.tick(0.3), once.tick(0.3)], [0, 1, 0]);
    assert!(once.is_over() && once.left() == 0.0);
    once.restart();
    assert!(!once.is_over());
    let mut again = Timer::repeating(0.1);
    let ends: u32 = (0..60).map(|_| again.tick(1.0 / 60.0)).sum();
    assert!((9..=10).contains(&ends), "{ends}");
    assert_eq!(Timer::repeating(0.0).tick(0.1), 1);
}

#[test]
fn what_is_pointed_at_is_found() {
    let folder = Folder::new();
    let scene = r#"Scene(entities: [
        (name: "Camera", transform: (translation: (0, 0, 5)), camera: (fov: 90)),
        (name: "Middle", mesh: Box(size: (1, 1, 1))),
        (name: "Corner", transform: (translation: (9, 4.5, 0)), mesh: Box(size: (1, 1, 1))),
    ])"#;
    let mut game = Game::new();
    game.enter(&folder.write("c.scene.ron", scene)).unwrap();
    let under = |game: &mut Game, events: &[InputEvent]| {
        game.step(events).unwrap();
        let ecs = &game.world.ecs;
        let camera = game.world.find("Camera").unwrap();
        let (camera, place) = (ecs.get::<Camera>(camera).unwrap(), ecs.get::<GlobalTransform>(camera).unwrap());
        let (origin, direction) = ecs.resource::<Input>().pointer_ray(camera, place);
        let hit = ecs.resource::<SpatialQuery>().cast_ray(origin, direction, 100.0, |_| true);
        hit.map(|hit| game.world.name(hit.entity).to_owned())
    };
    assert_eq!(under(&mut game, &[InputEvent::Point(0.5, 0.5)]).as_deref(), Some("Middle"));
    assert_eq!(under(&mut game, &[InputEvent::Point(0.6, 0.1)]), None);
    // 9 m to the right, 4.5 m up, 5 m away: 0.9 of the way to a border that is 10 m off.
    assert_eq!(under(&mut game, &[InputEvent::Aspect(2.0), InputEvent::Point(0.95, 0.05)]).as_deref(), Some("Corner"));
    assert_eq!(under(&mut game, &[InputEvent::Aspect(1.0)]), None, "in a square picture it is somewhere else");
    let flat = scene.replace("fov: 90", "projection: Orthographic(height: 20)");
    game.enter(&folder.write("c.scene.ron", &flat)).unwrap();
    let hit = under(&mut game, &[InputEvent::Point(0.95, 0.275)]);
    assert_eq!(hit.as_deref(), Some("Corner"), "9 and 4.5 of 10 m, however far away");
}
