//! A custom method of indirect light, hemisphere light, with settings that scenes hold.
//! `cargo run --release --example custom_method`, with `-- --edit` to change the settings by mouse, or with `-- --gi clpv`
//! to compare it with a method of the engine.

pub mod method;

use lightwell_game::prelude::*;

fn main() -> std::process::ExitCode {
    run(app)
}

/// The game: a scene that asks for the method by `gi: Hemisphere`.
pub fn app() -> App {
    App::new(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/custom_method/yard.scene.ron"))
        .title("Hemisphere light")
        .method(|| method::Hemisphere)
        .method_settings::<method::HemisphereLight>()
}
