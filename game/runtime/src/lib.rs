//! What a game and the program `lightwell` both need to draw a scene: load it, draw it, show it in a window, read it back.
//!
//! In come scenes by file or name, choices of how they are looked at ([`cli`]), and a window if there is one; out go
//! frames, on the window or as [`writer::Picture`]s. There is no editor in it, and nothing that measures.
//!
//! | to | look at |
//! | --- | --- |
//! | draw a scene without a game | [`session::Session`] |
//! | draw a world that a game changes | [`session::RenderState`] |
//! | find a scene by its name | [`scene_path`] |
//! | add what every command line takes | [`cli::Common`], [`cli::LookArgs`] |
//! | change a value of a loaded scene by its path | [`set`] |
//! | draw in a window, with egui over it | [`window`] |
//! | count the steps of a game, light its probes | [`steps`], [`probe_light`] |
//! | notice files that change | [`watch::SceneWatcher`] |
//! | write frames while others are drawn | [`writer`] |
//! | log, print, show progress | [`logging`], [`say`], [`progress`] |

pub mod cli;
pub mod frame_budget;
pub mod logging;
pub mod output;
pub mod probe_light;
pub mod progress;
pub mod scene_path;
pub mod session;
pub mod set;
pub mod steps;
pub mod watch;
pub mod window;
pub mod window_figures;
pub mod writer;
