use lightwell_game::prelude::*;

/// Flies where the player steers it.
#[derive(Component, SceneData, Clone, Default)]
struct Moth {
    /// Speed [m/s], 0 to 10.
    speed: f32,
}

/// Wakes up where it is bright.
#[derive(Component, SceneData, Clone, Default)]
struct Sleeper {
    /// Irradiance that wakes it [W/m²].
    threshold: f32,
    /// Whether it is awake.
    awake: bool,
}

fn fly(time: Res<Time>, input: Res<Input>, mut moths: Query<(&Moth, &mut Transform)>) {
    let steer = input.vector("right", "forward");
    for (moth, mut transform) in &mut moths {
        transform.translation += Vec3::new(steer.x, 0.0, -steer.y) * moth.speed * time.delta;
    }
}

fn wake(mut sleepers: Query<(&mut Sleeper, &LightProbe, &mut MeshRenderer)>) {
    for (mut sleeper, probe, mut renderer) in &mut sleepers {
        if !sleeper.awake && probe.brightness() > sleeper.threshold {
            sleeper.awake = true;
            renderer.set_emissive(Vec3::new(2.0, 0.8, 0.2));
        }
    }
}

fn tell(hud: Res<Hud>, sleepers: Query<&Sleeper>) {
    let awake = sleepers.iter().filter(|sleeper| sleeper.awake).count();
    hud.text(Align2::LEFT_TOP, 6.0, format!("{awake} of {} awake", sleepers.iter().count()));
}

pub fn app() -> App {
    App::new("moth.scene.ron")
        .actions("moth.actions.ron")
        .component::<Moth>()
        .component::<Sleeper>()
        .systems(FixedUpdate, (fly, wake).chain())
        .systems(Update, tell)
}

fn main() -> std::process::ExitCode {
    run(app)
}
