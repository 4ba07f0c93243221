//! What measures scenes and makes files of them: all commands of the program `lightwell` but its window, as a library, so
//! that scene tests and benchmarks are tests like any other.
//!
//! In come the arguments of a command ([`cli`]); out go images, reports, tables and plots in files, lines on the output
//! stream, and an exit code where a check can fail.
//!
//! | to | look at |
//! | --- | --- |
//! | write images of a scene, or its animation | [`commands::render`], [`commands::animation`] |
//! | compare an image with a reference | [`commands::compare`] |
//! | test scenes | [`scene_test`] |
//! | measure time, memory and error of methods | [`bench`](mod@bench) |
//! | check what holds for every scene | [`stress`] |
//! | see many models at once | [`sheet`] |
//! | make a folder of a game | [`pack`] |
//! | know why a pass runs, and what the device can do | [`commands::explain`], [`commands::info`] |

pub mod bench;
mod capture;
pub mod cli;
pub mod commands;
mod jitter;
pub mod pack;
pub mod scene_test;
mod sequence;
pub mod sheet;
mod shot;
mod still;
pub mod stress;
