//! Two scenes and a way between them, with what the player has found on the way.
//! `cargo run --release --example change_scene`: A and D to walk, into the light.

use lightwell_game::prelude::*;

fn main() -> std::process::ExitCode {
    run(app)
}

/// The whole of it.
pub fn app() -> App {
    App::new(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/scenes/left.scene.ron"))
        .title("Two rooms")
        .actions("rooms.actions.ron")
        .component::<Walker>()
        .component::<Door>()
        .resource(Passed(0))
        .systems(OnSceneEnter, arrive)
        .systems(FixedUpdate, (walk, pass).chain())
        .systems(Update, tell)
}

/// Is moved by the player.
#[derive(Component, SceneData, Clone, Default)]
struct Walker {
    /// Speed [m/s], 0 to 10.
    speed: f32,
}

/// Leads to another scene.
#[derive(Component, SceneData, Clone, Default)]
struct Door {
    /// The scene, relative to this one.
    to: String,
    /// Where the walker comes in, if it comes from there [m].
    entry: f32,
}

/// Doors that were passed: resources stay when the scene changes.
#[derive(Resource)]
struct Passed(u32);

fn arrive(passed: Res<Passed>, doors: Query<&Door>, mut walkers: Query<&mut Transform, With<Walker>>) {
    for (door, mut walker) in doors.iter().zip(&mut walkers) {
        if passed.0 > 0 {
            walker.translation.x = door.entry;
        }
    }
}

fn walk(
    time: Res<Time>,
    input: Res<Input>,
    space: Res<SpatialQuery>,
    mut walkers: Query<(Entity, &Walker, &mut Transform)>,
) {
    for (entity, walker, mut transform) in &mut walkers {
        let motion = Vec3::X * input.axis("right") * walker.speed * time.delta;
        transform.translation = space.slide_sphere(transform.translation, 0.3, motion, |other| other != entity).0;
    }
}

fn pass(
    doors: Query<(&Door, &Transform), Without<Walker>>,
    walkers: Query<&Transform, With<Walker>>,
    mut passed: ResMut<Passed>,
    mut commands: Commands,
) {
    for (door, place) in &doors {
        if walkers.iter().any(|walker| walker.translation.distance(place.translation) < 0.6) {
            passed.0 += 1;
            commands.change_scene(&door.to);
        }
    }
}

fn tell(hud: Res<Hud>, passed: Res<Passed>, scene: Res<CurrentScene>) {
    hud.text(Align2::LEFT_TOP, 5.0, format!("{} room, {} doors passed", scene.name(), passed.0));
}
