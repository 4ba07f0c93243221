//! `lightwell bench`: time against error of the methods of indirect light.
//!
//! ```text
//! plan (scenes × variants × tasks) ─ fixture (a scene on the device) ─ timing, error, flicker, throughput
//!                                                                └─ results.json ─ report.md, plots, images
//! ```
//! With `--rooms` the scenes are random rooms, and errors over many of them are what counts: see `rooms`.
//! Every measurement has a key of all that it depends on. One that `results.json` holds already is not taken again.

mod cliffs;
mod error;
mod fixture;
mod flicker;
mod growth;
mod host;
mod instant_radiosity;
mod light_culling;
mod machine;
mod noise;
mod pareto;
mod picture;
mod plan;
pub mod plot;
mod published_figures;
mod reference;
mod reference_file;
mod report;
mod response;
mod results;
mod rooms;
mod run;
mod stage;
mod thesis;
mod timing;
mod variant;
mod window;

#[cfg(test)]
mod tests;

pub(crate) use picture::Canvas;
pub(crate) use plot::text_width;
pub use run::run;
