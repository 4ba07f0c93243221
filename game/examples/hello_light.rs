//! Light that a system drives: a lamp that circles and changes its colour, and walls that answer it.
//! `cargo run --release --example hello_light`

use lightwell_game::prelude::*;

fn main() -> std::process::ExitCode {
    run(app)
}

/// The whole of it.
pub fn app() -> App {
    App::new(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/scenes/hello.scene.ron"))
        .title("Hello, light")
        .systems(FixedUpdate, circle)
        .systems(Update, tell)
}

/// The lamp goes around in eight seconds, its colour with it.
fn circle(time: Res<Time>, mut lamps: Query<(&mut Light, &mut Transform)>) {
    let angle = time.elapsed as f32 * std::f32::consts::TAU / 8.0;
    for (mut light, mut transform) in &mut lamps {
        transform.translation.x = 1.2 * angle.cos();
        transform.translation.z = 1.2 * angle.sin();
        let wave = |shift: f32| 0.55 + 0.45 * (angle + shift).cos();
        light.color = Vec3::new(wave(0.0), wave(2.1), wave(4.2));
    }
}

/// How bright it is where the probe of the scene measures, on the far side of the wall.
fn tell(hud: Res<Hud>, probes: Query<(&Name, &LightProbe)>) {
    for (name, probe) in &probes {
        let (direct, indirect) = (probe.direct.length(), probe.indirect.length());
        let text = format!("{}: direct {direct:.2}, indirect {indirect:.2} W/m²", name.0);
        hud.text(Align2::LEFT_BOTTOM, 4.0, text);
    }
}
