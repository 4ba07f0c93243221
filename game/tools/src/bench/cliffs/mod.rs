//! `bench --cliffs`: what one small thing of each kind adds to the cost of a plain room, pass by pass.
//!
//! ```text
//! things (a room and what is put into it, as scenes) ─ measure (in turns, everything computed) ─ cliffs.json, cliffs.md
//! ```

mod report;
mod things;

use super::machine;
use super::results::{self, Header};
use crate::cli::BenchArgs;
use anyhow::{Context, Result};
use lightwell::graph::{Counts, PassState};
use lightwell::render::RenderSettings;
use lightwell::scene::SceneView;
use lightwell_runtime::cli::{Common, LookArgs};
use lightwell_runtime::progress;
use lightwell_runtime::session::Session;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Instant;
use things::{THINGS, Thing};

/// Image, unless another is asked for [pixels].
const SIZE: [u32; 2] = [64, 64];
/// Frames that are measured, unless another number is asked for.
const FRAMES: u32 = 3;

/// The results of a run.
#[derive(Serialize, Deserialize)]
struct Results {
    header: Header,
    /// Image [pixels].
    size: [u32; 2],
    /// Frames measured of each room.
    frames: u32,
    /// The plain room first.
    rooms: Vec<Room>,
}

/// The cost of a room with one thing in it.
#[derive(Clone, Default, Serialize, Deserialize)]
struct Room {
    name: String,
    /// Pipelines that the first frame made beside those of the rooms before it.
    pipelines: u64,
    /// Time of the first frame, with the making of pipelines [ms].
    first_ms: f64,
    /// Passes that ran, in the order of the frame.
    passes: Vec<Pass>,
}

/// The cost of a pass.
#[derive(Clone, Default, Serialize, Deserialize)]
struct Pass {
    name: String,
    /// Least time on the device over all frames: what a busy machine adds is left out [ms].
    ms: f64,
    /// Those that are not 0.
    counts: BTreeMap<String, u64>,
}

impl Room {
    /// Time on the device of all passes [ms].
    fn ms(&self) -> f64 {
        self.passes.iter().map(|pass| pass.ms).sum()
    }

    fn pass(&self, name: &str) -> Option<&Pass> {
        self.passes.iter().find(|pass| pass.name == name)
    }

    /// Takes the times of a frame, and its counts.
    fn add(&mut self, frame: &lightwell::graph::FrameReport) {
        for pass in frame.passes.iter().filter(|pass| pass.state == PassState::Ran) {
            let ms = pass.gpu_ms.unwrap_or(pass.cpu_ms);
            match self.passes.iter_mut().find(|known| known.name == pass.name) {
                Some(known) => known.ms = known.ms.min(ms),
                None => self.passes.push(Pass { name: pass.name.clone(), ms, counts: named(&pass.counts) }),
            }
        }
    }
}

fn named(counts: &Counts) -> BTreeMap<String, u64> {
    let counts = counts.named().into_iter().filter(|(_, count)| *count > 0);
    counts.map(|(name, count)| (name.to_owned(), count)).collect()
}

/// Measures all rooms in turns and writes results and report; gives the report's path.
///
/// # Errors
/// If a scene cannot be written or drawn, or a file not be written.
pub fn run(args: &BenchArgs, common: &Common) -> Result<PathBuf> {
    let gpu = super::fixture::open_gpu(common)?;
    let size = args.time_size.first().copied().unwrap_or(SIZE);
    let frames = args.frames.unwrap_or(FRAMES);
    let header = machine::header(&gpu, format!("{}×{} pixels, {frames} frames", size[0], size[1]))?;
    let folder = args.output.join("rooms");
    std::fs::create_dir_all(&folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
    things::write_textures(&folder)?;
    let bar = progress::bar((THINGS.len() as u64) * u64::from(frames + 1), "cliffs");
    let mut rooms = Vec::new();
    let mut sessions = Vec::new();
    for thing in &THINGS {
        bar.set_message(format!("first frame: {}", thing.name));
        let scene = folder.join(thing.write(&folder)?);
        let open = || Session::open(gpu.clone(), &scene.to_string_lossy(), &LookArgs::default(), common);
        let mut session = open().with_context(|| format!("the room with `{}`", thing.name))?;
        rooms.push(first_frame(&mut session, thing, size)?);
        sessions.push(session);
        bar.inc(1);
    }
    for round in 0..frames as usize {
        for turn in 0..THINGS.len() {
            // Each round begins with another room: none always comes after the same neighbour.
            let index = (turn + round) % THINGS.len();
            bar.set_message(format!("round {}: {}", round + 1, THINGS[index].name));
            rooms[index].add(&draw(&mut sessions[index], size)?);
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    let results = Results { header, size, frames, rooms };
    results::write_whole(&args.output.join("cliffs.json"), serde_json::to_string_pretty(&results)?.as_bytes())?;
    let path = args.output.join("cliffs.md");
    results::write_whole(&path, report::text(&results).as_bytes())?;
    Ok(path)
}

/// Draws the frame in which pipelines are made.
fn first_frame(session: &mut Session, thing: &Thing, size: [u32; 2]) -> Result<Room> {
    let before = session.gpu.pipelines.len();
    let start = Instant::now();
    draw(session, size)?;
    let first_ms = start.elapsed().as_secs_f64() * 1e3;
    let pipelines = (session.gpu.pipelines.len() - before) as u64;
    Ok(Room { name: thing.name.to_owned(), pipelines, first_ms, passes: Vec::new() })
}

/// Draws a frame in which nothing is reused.
fn draw(session: &mut Session, size: [u32; 2]) -> Result<lightwell::graph::FrameReport> {
    let settings = RenderSettings { no_cache: true, ..session.render_settings(true) };
    let view = SceneView { camera: session.camera()?, size, jitter: [0.0; 2] };
    let report = session.render(&view, &settings)?;
    session.gpu.wait();
    Ok(report)
}
