//! The rules. All of them are systems; the court is a scene, and the lamps and fireflies in it are prefabs.

use lightwell_game::prelude::*;

/// The ball that is rolled.
#[derive(Component, SceneData, Clone)]
pub struct Ball {
    /// Radius [m].
    pub radius: f32,
    /// How fast it gains speed, 1 to 30 (m/s²).
    pub push: f32,
    /// Speed, the present one (m/s).
    pub velocity: Vec3,
}

impl Default for Ball {
    fn default() -> Self {
        Self { radius: 0.35, push: 9.0, velocity: Vec3::ZERO }
    }
}

/// Goes on for good when the ball comes near.
#[derive(Component, SceneData, Clone)]
pub struct Lamp {
    /// Distance at which the ball switches it on [m].
    pub reach: f32,
    /// Radiant intensity of its beam when it shines [W/sr].
    pub power: f32,
    /// Whether it was switched on.
    pub on: bool,
}

impl Default for Lamp {
    fn default() -> Self {
        Self { reach: 1.1, power: 90.0, on: false }
    }
}

/// Caught by rolling through it.
#[derive(Component, SceneData, Clone)]
pub struct Firefly {
    /// Points that it gives, 0 to 100.
    pub points: u32,
}

impl Default for Firefly {
    fn default() -> Self {
        Self { points: 10 }
    }
}

/// The way out, open when all lamps shine.
#[derive(Component, SceneData, Clone, Default)]
pub struct Gate;

/// Where the game is.
#[derive(SceneData, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Phase {
    /// Before it begins.
    #[default]
    Menu,
    /// The ball rolls.
    Playing,
    /// It went out through the gate.
    Won,
    /// Its glow has gone out, or it fell into the well.
    Lost,
}

/// The state of the game, saved with it.
#[derive(Resource, SceneData, Clone, Debug, PartialEq)]
pub struct Run {
    /// Where it is.
    pub phase: Phase,
    /// What is left of the ball's glow, 0 to 1.
    pub glow: f32,
    /// Points.
    pub score: u32,
    /// Lamps that shine, and how many there are.
    pub lamps: [u32; 2],
    /// Since the ball began to roll [s].
    pub time: f32,
}

impl Default for Run {
    fn default() -> Self {
        Self { phase: Phase::Menu, glow: 1.0, score: 0, lamps: [0, 0], time: 0.0 }
    }
}

/// A lamp was switched on.
#[derive(EntityEvent)]
struct Lit(Entity);

/// Glow that is lost in a second of darkness.
const FADING: f32 = 1.0 / 18.0;
/// Irradiance at which the ball loses and gains nothing [W/m²].
const BRIGHT_ENOUGH: f32 = 0.25;

/// All of the game.
pub fn app() -> App {
    App::new(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/lamplight/court.scene.ron"))
        .title("Lamplight")
        .actions("lamplight.actions.ron")
        .component::<Ball>()
        .component::<Lamp>()
        .component::<Firefly>()
        .component::<Gate>()
        .saved_resource(Run::default())
        .observer(on_lit)
        .systems(OnSceneEnter, begin)
        .systems(FixedUpdate, menu)
        .systems(FixedUpdate, (roll, switch_on, catch, fade, leave).chain().after(menu).run_if(is_playing))
        .systems(FixedUpdate, (shine, glow, follow, hover).after(menu))
        .systems(Update, hud)
}

fn is_playing(run: Res<Run>) -> bool {
    run.phase == Phase::Playing
}

/// A scene was entered: at first behind the menu, later to play it again.
fn begin(mut run: ResMut<Run>, lamps: Query<&Lamp>) {
    let phase = if run.phase == Phase::Menu { Phase::Menu } else { Phase::Playing };
    *run = Run { phase, lamps: [0, lamps.iter().count() as u32], ..Run::default() };
}

fn menu(input: Res<Input>, mut run: ResMut<Run>, mut commands: Commands) {
    match run.phase {
        Phase::Menu if input.just_pressed("start") => run.phase = Phase::Playing,
        Phase::Won | Phase::Lost if input.just_pressed("start") => commands.restart_scene(),
        Phase::Playing if input.just_pressed("restart") => commands.restart_scene(),
        _ => {}
    }
    if input.just_pressed("quit") {
        commands.quit();
    }
}

/// Rolls the ball, held up by floors and stopped by walls.
fn roll(
    time: Res<Time>,
    input: Res<Input>,
    space: Res<SpatialQuery>,
    mut run: ResMut<Run>,
    ball: Single<(Entity, &mut Ball, &mut Transform)>,
) {
    let (entity, mut ball, mut transform) = ball.into_inner();
    run.time += time.delta;
    let steer = input.vector("right", "forward");
    let push = Vec3::new(steer.x, 0.0, -steer.y) * ball.push + Vec3::NEG_Y * 9.81;
    let drag = (-1.2 * time.delta).exp();
    ball.velocity = (ball.velocity + push * time.delta) * Vec3::new(drag, 1.0, drag);
    let before = transform.translation;
    let (at, contacts) = space.slide_sphere(before, ball.radius, ball.velocity * time.delta, |other| other != entity);
    for contact in contacts {
        let into = ball.velocity.dot(contact.normal);
        // A little of it bounces back from walls.
        let bounce = if contact.normal.y < 0.5 { 1.3 } else { 1.0 };
        if into < 0.0 {
            ball.velocity -= contact.normal * into * bounce;
        }
    }
    transform.translation = at;
    // It rolls without slipping: the angle is the way over the radius.
    let way = at - before;
    if let Some(axis) = Vec3::Y.cross(way).try_normalize() {
        let turn = Quat::from_axis_angle(axis, way.length() / ball.radius);
        transform.rotation = (turn * transform.rotation).normalize();
    }
    if at.y < -2.0 {
        run.phase = Phase::Lost;
    }
}

fn switch_on(
    ball: Single<&Transform, With<Ball>>,
    mut lamps: Query<(Entity, &mut Lamp, &GlobalTransform)>,
    mut commands: Commands,
) {
    for (entity, mut lamp, place) in &mut lamps {
        let distance = ball.translation.distance(place.position());
        if !lamp.on && distance < lamp.reach {
            lamp.on = true;
            commands.trigger(Lit(entity));
        }
    }
}

fn on_lit(_: On<Lit>, mut run: ResMut<Run>, mut sounds: ResMut<Sounds>) {
    run.lamps[0] += 1;
    run.score += 50;
    run.glow = (run.glow + 0.35).min(1.0);
    sounds.play("lit.wav", 0.8);
}

fn catch(
    ball: Single<&Transform, With<Ball>>,
    fireflies: Query<(Entity, &Firefly, &GlobalTransform)>,
    mut run: ResMut<Run>,
    mut commands: Commands,
) {
    for (entity, firefly, place) in &fireflies {
        if ball.translation.distance(place.position()) < 0.7 {
            run.score += firefly.points;
            run.glow = (run.glow + 0.1).min(1.0);
            commands.entity(entity).despawn();
        }
    }
}

/// The ball's glow fades in the dark, and comes back in the light.
fn fade(time: Res<Time>, probe: Single<&LightProbe, With<Ball>>, mut run: ResMut<Run>) {
    let light = (probe.brightness() / BRIGHT_ENOUGH).min(2.0);
    run.glow = (run.glow + (light - 1.0) * FADING * time.delta).min(1.0);
    if run.glow <= 0.0 {
        run.phase = Phase::Lost;
    }
}

fn leave(
    ball: Single<&Transform, With<Ball>>,
    gate: Single<&GlobalTransform, With<Gate>>,
    mut run: ResMut<Run>,
    mut sounds: ResMut<Sounds>,
) {
    let [on, all] = run.lamps;
    if on == all && ball.translation.distance(gate.position()) < 1.2 {
        run.phase = Phase::Won;
        run.score += (100.0 * run.glow).round() as u32;
        sounds.play("won.wav", 1.0);
    }
}

/// Lamps and gate come to their brightness within a moment.
fn shine(
    time: Res<Time>,
    run: Res<Run>,
    lamps: Query<(Entity, &Lamp)>,
    gate: Single<Entity, With<Gate>>,
    children: Query<&Children>,
    mut lights: Query<&mut Light>,
    mut bulbs: Query<(&Name, &mut MeshRenderer)>,
) {
    let step = (4.0 * time.delta).min(1.0);
    for (entity, lamp) in &lamps {
        let mut color = Vec3::ONE;
        for part in children.iter_descendants(entity) {
            if let Ok(mut light) = lights.get_mut(part) {
                let wanted = if lamp.on { lamp.power } else { 0.0 };
                let next = light.intensity + (wanted - light.intensity) * step;
                // Close enough is there: light that no longer changes is computed no more.
                light.intensity = if (next - wanted).abs() < 0.01 * lamp.power { wanted } else { next };
                color = light.color;
            }
        }
        for part in children.iter_descendants(entity) {
            if let Ok((name, mut renderer)) = bulbs.get_mut(part)
                && name.0 == "Bulb"
            {
                renderer.set_emissive(color * if lamp.on { 4.0 } else { 0.05 });
            }
        }
    }
    let [on, all] = run.lamps;
    if let Ok((_, mut renderer)) = bulbs.get_mut(*gate) {
        renderer.set_emissive(if on == all { Vec3::new(2.4, 2.2, 1.4) } else { Vec3::new(0.03, 0.01, 0.01) });
    }
}

/// The ball shines by what is left of its glow.
fn glow(run: Res<Run>, ball: Single<(&mut Light, &mut MeshRenderer), With<Ball>>) {
    let (mut light, mut renderer) = ball.into_inner();
    // In steps that the eye does not see, so that not every frame is another one.
    let glow = (run.glow.max(0.0) * 32.0).ceil() / 32.0;
    light.intensity = 0.35 * glow;
    renderer.set_emissive(Vec3::new(1.0, 0.85, 0.6) * (0.25 * glow));
}

/// The camera stays behind the ball, and looks down at it.
fn follow(
    time: Res<Time>,
    ball: Single<&Transform, (With<Ball>, Without<Camera>)>,
    camera: Single<&mut Transform, With<Camera>>,
) {
    let target = ball.translation.max(Vec3::new(-6.5, 0.0, -4.5)).min(Vec3::new(6.5, 1.0, 4.5));
    let wanted = target + Vec3::new(0.0, 7.6, 7.4);
    let mut camera = camera.into_inner();
    let step = 1.0 - (-3.0 * time.delta).exp();
    camera.translation = camera.translation + (wanted - camera.translation) * step;
}

/// Fireflies go up and down, each in its own time.
fn hover(time: Res<Time>, mut fireflies: Query<(&Firefly, &GlobalTransform, &mut Transform)>) {
    for (_, place, mut transform) in &mut fireflies {
        let phase = time.elapsed as f32 * 2.0 + place.position().x;
        transform.translation.y = 0.5 + 0.12 * phase.sin();
    }
}

fn hud(run: Res<Run>, hud: Res<Hud>) {
    let [on, all] = run.lamps;
    let middle = |offset: f32, height: f32, text: &str| {
        hud.text_at(Align2::CENTER_CENTER, Vec2::new(0.0, offset), height, [1.0, 0.93, 0.8], text);
    };
    match run.phase {
        Phase::Menu => {
            hud.shade(0.45);
            middle(-12.0, 13.0, "Lamplight");
            middle(2.0, 4.0, "Switch on every lamp before your glow fades, then leave by the gate.");
            middle(10.0, 4.0, "roll: W A S D, arrows or left stick     again: R     quit: Esc");
            middle(22.0, 5.5, "Enter or (A) to begin");
        }
        Phase::Playing => {
            hud.text(Align2::LEFT_TOP, 5.0, format!("lamps {on} of {all}"));
            hud.text(Align2::RIGHT_TOP, 5.0, format!("{} points", run.score));
            let color = if run.glow < 0.3 { [1.0, 0.35, 0.2] } else { [1.0, 0.8, 0.4] };
            hud.bar(Align2::CENTER_TOP, Vec2::new(0.0, 1.5), Vec2::new(45.0, 2.2), run.glow, color);
            if on == all {
                hud.text_at(Align2::CENTER_BOTTOM, Vec2::ZERO, 4.5, [1.0, 0.93, 0.8], "The gate is open");
            }
        }
        Phase::Won | Phase::Lost => {
            hud.shade(0.4);
            let won = run.phase == Phase::Won;
            middle(-8.0, 11.0, if won { "Light at last" } else { "Dark" });
            middle(4.0, 5.0, &format!("{} points in {:.0} seconds, lamps {on} of {all}", run.score, run.time));
            middle(14.0, 5.0, "Enter or (A) to roll again");
        }
    }
}
