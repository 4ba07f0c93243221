//! A component of one's own: in the scene's file, in the systems, and in the editor.
//! `cargo run --release --example custom_component`, and the same with `-- --edit` to change it by mouse.

use lightwell_game::prelude::*;

fn main() -> std::process::ExitCode {
    run(app)
}

/// The whole of it.
pub fn app() -> App {
    App::new(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/scenes/lift.scene.ron"))
        .title("Lifts")
        .component::<Lift>()
        .systems(FixedUpdate, ride)
}

/// Rides up and down between two heights.
#[derive(Component, SceneData, Clone)]
pub struct Lift {
    /// Lower end [m].
    low: f32,
    /// Upper end [m].
    high: f32,
    /// Time from one end to the other, 0.1 to 10 [s].
    duration: f32,
    /// How it gets there.
    way: Way,
}

/// How a lift gets from one end to the other.
#[derive(SceneData, Clone, Default)]
enum Way {
    /// At even speed.
    Even,
    /// Slow at the ends.
    #[default]
    Smooth,
    /// Waits at each end.
    Waiting {
        /// How long [s].
        pause: f32,
    },
}

/// What a scene does not say.
impl Default for Lift {
    fn default() -> Self {
        Self { low: 0.25, high: 2.0, duration: 2.0, way: Way::default() }
    }
}

fn ride(time: Res<Time>, mut lifts: Query<(&Lift, &mut Transform)>) {
    for (lift, mut transform) in &mut lifts {
        let duration = lift.duration.max(0.1);
        let pause = if let Way::Waiting { pause } = lift.way { pause.max(0.0) } else { 0.0 };
        let cycle = (time.elapsed as f32 / (duration + pause)) % 2.0;
        let t = (cycle.fract() * (duration + pause) / duration).min(1.0);
        let t = if cycle < 1.0 { t } else { 1.0 - t };
        let t = if let Way::Smooth = lift.way { t * t * (3.0 - 2.0 * t) } else { t };
        transform.translation.y = lift.low + (lift.high - lift.low) * t;
    }
}
