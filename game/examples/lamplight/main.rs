//! Lamplight: a ball rolls through a dark courtyard, whose only light is what walls throw back of the lamps that it
//! switches on. `cargo run --release --example lamplight`

mod game;

fn main() -> std::process::ExitCode {
    lightwell_game::run(game::app)
}
