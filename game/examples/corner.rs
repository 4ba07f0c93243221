//! Light the corner behind the screen by what the walls reflect, and keep the lamp out of its sight.

use lightwell_game::prelude::*;

fn main() -> std::process::ExitCode {
    run(app)
}

/// The scene, and what runs 60 times a second and before each frame.
pub fn app() -> App {
    App::new("game/examples/scenes/corner.scene.ron").systems(FixedUpdate, steer).systems(Update, score)
}

/// The lamp follows the mouse.
fn steer(input: Res<Input>, mut lamps: Query<&mut Transform, With<Light>>) {
    let pointer = input.pointer() - 0.5;
    for mut lamp in &mut lamps {
        lamp.translation = Vec3::new(5.6 * pointer.x, 0.6, 3.6 * pointer.y);
    }
}

/// Shows how much reflected light reaches the corner.
fn score(hud: Res<Hud>, probes: Query<&LightProbe>) {
    for probe in &probes {
        let text = if probe.direct == Vec3::ZERO { "Reflected light" } else { "The corner sees the lamp" };
        hud.text(Align2::LEFT_TOP, 5.0, format!("{text}: {:.3} W/m²", probe.indirect.max_element()));
    }
}
