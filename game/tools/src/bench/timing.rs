//! Times, counts and memory. All variants take turns, frame by frame, so that a machine that drifts favours none.

use super::fixture::Fixture;
use super::machine;
use super::results::{CountMap, Mode, Spread, Timing};
use super::stage::{OTHER, stage_of};
use super::variant::Variant;
use crate::jitter;
use anyhow::{Context, Result};
use lightwell::graph::{FrameReport, PassState};
use lightwell::render::RenderSettings;
use lightwell::render::reference::TraceSettings;
use lightwell::scene::SceneView;
use lightwell_runtime::session::Session;
use std::collections::BTreeMap;
use std::time::Instant;

/// The subject of a timing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Course {
    /// Image size [pixels].
    pub size: [u32; 2],
    /// The part of a frame that is computed.
    pub mode: Mode,
    /// Images that are averaged where errors are taken.
    pub aa: u32,
    /// Frames before the measured ones.
    pub warm_up: u32,
    /// Frames measured, at most.
    pub frames: u32,
    /// Time after which a variant that was measured once takes no further part [ms].
    pub budget: f64,
}

/// Times of one frame [ms].
struct Sample {
    stages: BTreeMap<String, f64>,
    total: f64,
    wall: f64,
}

/// The results of one variant so far.
#[derive(Default)]
struct Samples {
    samples: Vec<Sample>,
    first: Option<FrameReport>,
    allocated_bytes: u64,
    /// Time of all frames so far [ms].
    spent: f64,
}

/// Frames that a variant takes part in: long ones in fewer, since they average over many samples by themselves.
pub fn rounds(variant: &Variant, frames: u32) -> u32 {
    if variant.is_traced() { frames.min((16 / variant.spp.max(1)).max(1)) } else { frames }
}

/// Times some of the variants round robin; keys are filled in by the caller. `progress` is told of each frame's variant.
///
/// # Errors
/// If a frame cannot be drawn.
pub fn measure(
    fixture: &mut Fixture,
    which: &[usize],
    course: &Course,
    progress: &mut dyn FnMut(&Variant),
) -> Result<Vec<Timing>> {
    let course = &started(course);
    let mut all: Vec<Samples> = which.iter().map(|_| Samples::default()).collect();
    for round in 0..course.warm_up + course.frames {
        for turn in 0..which.len() {
            // Each round begins with another variant: nobody always comes after the same neighbour.
            let slot = (turn + round as usize) % which.len();
            let (variant, session) = fixture.runner(which[slot]);
            let measured = round.checked_sub(course.warm_up);
            let warm_up = if variant.is_traced() { course.warm_up.min(1) } else { course.warm_up };
            let takes_part = match measured {
                Some(round) => round < rounds(variant, course.frames),
                None => round < warm_up,
            };
            let samples = &all[slot];
            let enough = samples.spent > course.budget && (measured.is_none() || !samples.samples.is_empty());
            if !takes_part || enough {
                continue;
            }
            session.set_ticks(if course.mode == Mode::Shifted { 0 } else { u64::from(round) });
            let (sample, report) = frame(session, variant, course, (round, measured.is_none()))?;
            progress(variant);
            let samples = &mut all[slot];
            samples.spent += sample.wall;
            if let Some(report) = report {
                samples.allocated_bytes = samples.allocated_bytes.max(report.allocated_bytes);
                if measured.is_some() && samples.first.is_none() {
                    samples.first = Some(report);
                }
            }
            if measured.is_some() {
                samples.samples.push(sample);
            }
        }
    }
    let scene = fixture.name();
    let timing = |(samples, &index): (Samples, &usize)| {
        summary(&scene, &fixture.runners[index].0, course, &samples).context("no frame was timed")
    };
    all.into_iter().zip(which).map(timing).collect()
}

/// Images that are averaged follow a first one.
fn started(course: &Course) -> Course {
    Course { warm_up: course.warm_up.max(u32::from(course.mode == Mode::Shifted)), ..*course }
}

fn frame(
    session: &mut Session,
    variant: &Variant,
    course: &Course,
    (round, warm_up): (u32, bool),
) -> Result<(Sample, Option<FrameReport>)> {
    let is_shifted = course.mode == Mode::Shifted;
    let jitter = if is_shifted { jitter::shift(round % course.aa, course.aa) } else { [0.0; 2] };
    let view = SceneView { camera: session.camera()?, size: course.size, jitter };
    if variant.is_traced() {
        let spp = if warm_up { 1 } else { variant.spp };
        return Ok((trace(session, &view, variant, spp)?, None));
    }
    let images = if is_shifted { course.aa } else { 1 };
    let settings = RenderSettings { no_cache: course.mode == Mode::Full, images, ..session.render_settings(true) };
    let start = Instant::now();
    let report = session.render(&view, &settings)?;
    session.gpu.wait();
    let wall = start.elapsed().as_secs_f64() * 1e3;
    let mut stages = BTreeMap::new();
    for pass in &report.passes {
        if let Some(ms) = pass.gpu_ms {
            *stages.entry(stage_of(&pass.name).unwrap_or(OTHER).to_owned()).or_insert(0.0) += ms;
        }
    }
    let total = report.gpu_ms().unwrap_or(wall);
    Ok((Sample { stages, total, wall }, Some(report)))
}

/// Path tracing waits for each of its pieces, so that the clock on the wall tells its time.
fn trace(session: &mut Session, view: &SceneView, variant: &Variant, spp: u32) -> Result<Sample> {
    let settings = TraceSettings { bounces: variant.bounces, seed: 0 };
    let start = Instant::now();
    session.begin_trace(view, &settings)?.0.tracer.restart();
    let (mut tracing, _) = session.begin_trace(view, &settings)?;
    let begun = start.elapsed().as_secs_f64() * 1e3;
    tracing.advance_to(spp, &mut |_| {})?;
    let wall = start.elapsed().as_secs_f64() * 1e3;
    let stages = BTreeMap::from([("BVH".to_owned(), begun), ("TRC".to_owned(), wall - begun)]);
    Ok(Sample { stages, total: wall, wall })
}

fn summary(scene: &str, variant: &Variant, course: &Course, samples: &Samples) -> Option<Timing> {
    let of = |value: &dyn Fn(&Sample) -> f64| Spread::of(&samples.samples.iter().map(value).collect::<Vec<_>>());
    let mut names: Vec<&String> = samples.samples.iter().flat_map(|sample| sample.stages.keys()).collect();
    names.sort();
    names.dedup();
    // A stage that did not run in a frame took no time.
    let stage = |name: &String| Some((name.clone(), of(&|sample| sample.stages.get(name).copied().unwrap_or(0.0))?));
    let mut timing = Timing {
        key: String::new(),
        scene: scene.to_owned(),
        variant: variant.name.clone(),
        size: course.size,
        mode: course.mode,
        frames: samples.samples.len(),
        stages: names.into_iter().filter_map(stage).collect(),
        total: of(&|sample| sample.total)?,
        wall: of(&|sample| sample.wall)?,
        counts: BTreeMap::new(),
        merges: None,
        unknown_passes: Vec::new(),
        allocated_bytes: samples.allocated_bytes,
        peak_bytes: machine::peak_bytes(),
    };
    if let Some(report) = &samples.first {
        count(report, &mut timing);
    }
    Some(timing)
}

/// Counts that do not depend on the machine.
fn count(report: &FrameReport, timing: &mut Timing) {
    for pass in report.passes.iter().filter(|pass| pass.state == PassState::Ran) {
        let stage = stage_of(&pass.name).unwrap_or_else(|| {
            timing.unknown_passes.push(pass.name.clone());
            OTHER
        });
        let counts: &mut CountMap = timing.counts.entry(stage.to_owned()).or_default();
        for (name, count) in pass.counts.named().into_iter().filter(|(_, count)| *count > 0) {
            *counts.entry(name.to_owned()).or_default() += count;
        }
    }
    timing.merges = merges(report);
}

/// Merges of blocker volumes: a cascade merges each view's volume but its first.
fn merges(report: &FrameReport) -> Option<u64> {
    let passes = report.passes.iter().filter(|pass| pass.state == PassState::Ran && pass.name.starts_with("blockers,"));
    passes.map(|pass| pass.counts.merges).reduce(|a, b| a + b)
}
