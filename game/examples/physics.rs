//! A physics engine wired to a game: rapier moves what has a `Body`, and the scene says what that is.
//! `cargo run --release --example physics --features physics-example`

use lightwell_game::prelude::*;
use rapier3d::prelude as rapier;

fn main() -> std::process::ExitCode {
    run(app)
}

/// The whole of it.
pub fn app() -> App {
    App::new(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/scenes/tower.scene.ron"))
        .title("Tower")
        .component::<Body>()
        .resource(Physics(rapier::PhysicsWorld::new()))
        .observer(on_body)
        .observer(on_body_gone)
        .systems(FixedUpdate, simulate)
}

/// Takes part in the physics, as a box of the entity's scale around its place.
#[derive(Component, SceneData, Clone, Default)]
struct Body {
    /// Whether it stays where it is, whatever hits it.
    fixed: bool,
    /// Speed at the start [m/s].
    velocity: Vec3,
}

/// The body of an entity in the physics.
#[derive(Component)]
struct Handle(rapier::RigidBodyHandle);

#[derive(Resource)]
struct Physics(rapier::PhysicsWorld);

/// Wherever a body comes from, a scene, a prefab or a system, the physics gets one too.
fn on_body(
    added: On<Add<Body>>,
    bodies: Query<(&Body, &Transform)>,
    mut physics: ResMut<Physics>,
    mut commands: Commands,
) -> Result {
    let (body, place) = bodies.get(added.entity)?;
    let half = 0.5 * place.scale.abs();
    let kind = if body.fixed { rapier::RigidBodyBuilder::fixed() } else { rapier::RigidBodyBuilder::dynamic() };
    let pose = rapier::Pose::from_parts(place.translation, place.rotation);
    let handle = physics.0.insert_body(kind.pose(pose).linvel(body.velocity));
    physics.0.insert_collider(rapier::ColliderBuilder::cuboid(half.x, half.y, half.z), Some(handle));
    commands.entity(added.entity).insert(Handle(handle));
    Ok(())
}

fn on_body_gone(removed: On<Remove<Body>>, handles: Query<&Handle>, mut physics: ResMut<Physics>) {
    if let Ok(handle) = handles.get(removed.entity) {
        physics.0.remove_body(handle.0);
    }
}

fn simulate(time: Res<Time>, mut physics: ResMut<Physics>, mut bodies: Query<(&Handle, &mut Transform)>) {
    physics.0.integration_parameters.dt = time.delta;
    physics.0.step();
    for (handle, mut transform) in &mut bodies {
        let Some(body) = physics.0.bodies.get(handle.0) else { continue };
        // What rests is not written: light that did not change is not computed again.
        transform.set_if_neq(Transform {
            translation: body.translation(),
            rotation: *body.rotation(),
            scale: transform.scale,
        });
    }
}
