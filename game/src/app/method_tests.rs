//! The command line of a game with a custom method of indirect light.

#[path = "../../examples/custom_method/method.rs"]
mod method;

use super::*;

#[test]
fn the_command_line_knows_the_methods_of_the_game() {
    let app = App::new("a.scene.ron").method(|| method::Hemisphere).method_settings::<method::HemisphereLight>();
    let chosen = |name: &str| -> Result<GameArgs, clap::Error> {
        GameArgs::from_arg_matches(&app.command().try_get_matches_from(["game", "--gi", name])?)
    };
    assert_eq!(chosen("hemisphere").ok().and_then(|args| args.gi), Some(method::Hemisphere::ID));
    let error = chosen("hemispheres").map(drop).map_err(|error| error.to_string());
    assert!(error.as_ref().is_err_and(|error| error.contains("slc") && error.contains("hemisphere")), "{error:?}");
}
