//! Costs of frames on the host alone: they are recorded for a device that does nothing.

use super::machine;
use super::report::markdown;
use super::results::{self, Header};
use crate::cli::BenchArgs;
use anyhow::{Context, Result};
use glam::Vec3;
use lightwell::assets::{Material, Shape};
use lightwell::gpu::{Gpu, HostCounts};
use lightwell::graph::Timing;
use lightwell::scene::SceneView;
use lightwell::world::{MeshRenderer, Transform};
use lightwell_runtime::cli::{Common, LookArgs, Switch};
use lightwell_runtime::say;
use lightwell_runtime::session::{self, Session};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

/// What is measured of each scene.
const MOTIONS: [Motion; 5] =
    [Motion::Boxes(0), Motion::Boxes(1), Motion::Boxes(10), Motion::Boxes(100), Motion::Playing];
/// Frames of a second of a scene that plays.
const RATE: f64 = 60.0;
/// Frames before those that are measured: pipelines compile, and dynamic objects are found.
const WARM_UP: u32 = 4;
/// Image, unless another is asked for [pixels].
const SIZE: [u32; 2] = [1920, 1080];

/// All runs in a folder.
#[derive(Default, Serialize, Deserialize)]
struct Results {
    runs: Vec<HostRun>,
}

/// The results of one program.
#[derive(Serialize, Deserialize)]
struct HostRun {
    /// Its name in the report.
    label: String,
    header: Header,
    cases: Vec<Case>,
}

/// What moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Motion {
    /// So many small boxes, while the scene's own time stands still.
    Boxes(u32),
    /// All that the scene moves, and nothing else.
    Playing,
}

impl std::fmt::Display for Motion {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Boxes(count) => write!(f, "{count}"),
            Self::Playing => f.write_str("as it plays"),
        }
    }
}

/// A scene in which something moves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Case {
    pub(super) scene: String,
    pub(super) moving: Motion,
    pub(super) size: [u32; 2],
    pub(super) frames: u32,
    /// Time to bring world and scene up to date, median [ms].
    pub(super) update_ms: f64,
    /// Time to record and submit a frame, median [ms].
    pub(super) frame_ms: f64,
    /// The shortest and the longest [ms].
    pub(super) least_ms: f64,
    pub(super) most_ms: f64,
    /// Requests of a frame to the device: the median of each.
    pub(super) counts: BTreeMap<String, u64>,
}

/// Measures the host's part of frames, and writes `host.json` and `host.md`; gives the latter's path.
///
/// # Errors
/// If a scene cannot be loaded or drawn, or a file not be written.
pub(super) fn run(args: &BenchArgs, scenes: &[String], lenient: bool, common: &Common) -> Result<PathBuf> {
    let gpu = Arc::new(Gpu::noop(&session::gpu_options(common))?);
    let size = args.time_size.first().copied().unwrap_or(SIZE);
    let frames = args.frames.unwrap_or(20);
    let mut cases = Vec::new();
    for scene in scenes {
        for moving in MOTIONS {
            match measure(&gpu, scene, moving, size, frames, common) {
                Ok(case) => cases.push(case),
                Err(error) if lenient => {
                    log::warn!("`{scene}` was left out: {error:#}");
                    break;
                }
                Err(error) => return Err(error.context(format!("scene `{scene}`"))),
            }
        }
    }
    let settings = format!("host alone, {}, {frames} frames", markdown::size(size));
    let run = HostRun { label: args.label.clone(), header: machine::header(&gpu, settings)?, cases };
    write(&args.output, run)
}

/// Adds the run to those that the folder holds, in the place of one with its label.
fn write(folder: &Path, run: HostRun) -> Result<PathBuf> {
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let [data, report] = ["host.json", "host.md"].map(|name| folder.join(name));
    let mut results: Results = match std::fs::read_to_string(&data) {
        Ok(text) => serde_json::from_str(&text)
            .with_context(|| format!("{} is of another version; choose another folder with -o", data.display()))?,
        Err(_) => Results::default(),
    };
    match results.runs.iter_mut().find(|known| known.label == run.label) {
        Some(known) => *known = run,
        None => results.runs.push(run),
    }
    results::write_whole(&data, serde_json::to_string_pretty(&results)?.as_bytes())?;
    let text = report_of(&results);
    say!("{text}");
    results::write_whole(&report, text.as_bytes())?;
    Ok(report)
}

/// Draws frames in which something moves, and nothing else does.
pub(super) fn measure(
    gpu: &Arc<Gpu>,
    scene: &str,
    moving: Motion,
    size: [u32; 2],
    frames: u32,
    common: &Common,
) -> Result<Case> {
    // As in a window on a graphics card.
    let look = LookArgs { average: Some(Switch::On), ..LookArgs::default() };
    let mut session = Session::open(Arc::clone(gpu), scene, &look, common)?;
    session.rendering.renderer.set_timing(Timing::Late);
    let (count, step) = match moving {
        Motion::Boxes(count) => (count, 0.0),
        Motion::Playing => (0, 1.0 / RATE),
    };
    let boxes = Boxes::spawn(&mut session, count)?;
    let view = SceneView { camera: session.camera()?, size, jitter: [0.0; 2] };
    let settings = session.display_settings();
    let (mut updates, mut times, mut counts) = (Vec::new(), Vec::new(), Vec::new());
    for frame in 0..WARM_UP + frames {
        let start = Instant::now();
        boxes.put(&mut session, frame);
        session.set_seconds(f64::from(frame) * step);
        let update = start.elapsed().as_secs_f64() * 1e3;
        let report = session.render(&view, &settings)?;
        if frame >= WARM_UP {
            updates.push(update);
            times.push(report.host_ms);
            counts.push(report.host);
        }
    }
    Ok(Case {
        scene: session.name(),
        moving,
        size,
        frames,
        update_ms: median(&mut updates),
        frame_ms: median(&mut times),
        least_ms: times.first().copied().unwrap_or_default(),
        most_ms: times.last().copied().unwrap_or_default(),
        counts: median_counts(&counts),
    })
}

/// Sorts the values and gives the one in the middle.
fn median<T: Copy + PartialOrd + Default>(values: &mut [T]) -> T {
    values.sort_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
    values.get(values.len() / 2).copied().unwrap_or_default()
}

fn median_counts(frames: &[HostCounts]) -> BTreeMap<String, u64> {
    let names = HostCounts::default().named().map(|(name, _)| name);
    let of = |index: usize| median(&mut frames.iter().map(|counts| counts.named()[index].1).collect::<Vec<_>>());
    names.into_iter().enumerate().map(|(index, name)| (name.to_owned(), of(index))).collect()
}

/// Boxes of 20 cm that circle above the middle of a scene.
struct Boxes {
    entities: Vec<bevy_ecs::entity::Entity>,
    center: Vec3,
    radius: f32,
}

impl Boxes {
    fn spawn(session: &mut Session, count: u32) -> Result<Self> {
        let bounds = session.scene().bounds();
        let mesh = Arc::new(Shape::Box { size: [0.2; 3] }.mesh()?);
        let material = Arc::new(Material::diffuse("moving box", Vec3::new(0.7, 0.4, 0.2)));
        let world = session.parts().world;
        let spawn = |index| {
            let entity = world.spawn(&format!("Moving box {index}"), None);
            let (mesh, material) = (Arc::clone(&mesh), Arc::clone(&material));
            let renderer = MeshRenderer { mesh, material, casts_shadow: true, visible: true };
            world.ecs.entity_mut(entity).insert((Transform::default(), renderer));
            entity
        };
        let entities = (0..count).map(spawn).collect();
        let boxes = Self { entities, center: bounds.center(), radius: 0.25 * bounds.size().min_element() };
        boxes.put(session, 0);
        session.set_seconds(0.0);
        Ok(boxes)
    }

    /// Moves them on by a frame.
    fn put(&self, session: &mut Session, frame: u32) {
        let world = session.parts().world;
        for (index, &entity) in self.entities.iter().enumerate() {
            let angle = 2.4 * index as f32 + 0.02 * frame as f32;
            let height = 0.1 * (index % 7) as f32 - 0.3;
            let at = self.center + self.radius * Vec3::new(angle.cos(), height, angle.sin());
            world.ecs.entity_mut(entity).insert(Transform::from_translation(at));
        }
    }
}

fn report_of(results: &Results) -> String {
    let mut text = String::from(
        "# The host's part of a frame\n\nFrames are recorded and submitted for a device that does nothing (wgpu's `noop`), as \
         in a window on a graphics card: averaged, camera at rest. Small boxes move while the scene's time stands still, or the \
         scene itself as it plays, 60 frames a second. Times are the median, the least and the most of the frames; counts are \
         medians. What is read back is zeros.\n\n",
    );
    for run in &results.runs {
        let Header { system, commit, date, settings, .. } = &run.header;
        let commit = commit.as_deref().unwrap_or("unknown commit");
        text += &format!("- {}: {settings}; {commit}, {date}, {system}\n", run.label);
    }
    text.push('\n');
    let head = [
        "scene",
        "moving",
        "run",
        "update [ms]",
        "frame [ms]",
        "least [ms]",
        "most [ms]",
        "dispatches",
        "compute passes",
        "render passes",
        "submits",
        "bind groups made",
        "buffers made",
        "bytes uploaded",
        "waits",
    ];
    let mut keys: Vec<(&str, Motion)> = Vec::new();
    for case in results.runs.iter().flat_map(|run| &run.cases) {
        if !keys.contains(&(&case.scene, case.moving)) {
            keys.push((&case.scene, case.moving));
        }
    }
    let rows = keys.iter().flat_map(|(scene, moving)| {
        let found =
            |run: &&HostRun| run.cases.iter().any(|case| (case.scene.as_str(), case.moving) == (*scene, *moving));
        let runs: Vec<&HostRun> = results.runs.iter().filter(found).collect();
        runs.into_iter()
            .flat_map(|run| {
                let cases = run.cases.iter().filter(|case| (case.scene.as_str(), case.moving) == (*scene, *moving));
                cases.map(|case| row(case, &run.label, &head[7..])).collect::<Vec<_>>()
            })
            .collect::<Vec<_>>()
    });
    text + &markdown::table(&head, &rows.collect::<Vec<_>>())
}

fn row(case: &Case, label: &str, counts: &[&str]) -> Vec<String> {
    let mut row = vec![case.scene.clone(), case.moving.to_string(), label.to_owned()];
    row.extend([case.update_ms, case.frame_ms, case.least_ms, case.most_ms].map(markdown::ms));
    let count = |name: &&str| case.counts.get(*name).map_or(markdown::NONE.to_owned(), |count| markdown::whole(*count));
    row.extend(counts.iter().map(count));
    row
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn frames_are_counted_without_a_device_and_runs_stand_side_by_side() {
        let dir = tempfile::tempdir().unwrap();
        let common = Common::default();
        let gpu = Arc::new(Gpu::noop(&session::gpu_options(&common)).unwrap());
        let case = measure(&gpu, "cornell", Motion::Boxes(3), [64, 48], 3, &common).unwrap();
        assert!(
            case.counts["dispatches"] > 0 && case.counts["submits"] > 0 && case.counts["render passes"] > 0,
            "{case:?}"
        );
        assert!(case.frame_ms >= case.least_ms && case.least_ms > 0.0, "{case:?}");
        let run = |label: &str| HostRun {
            label: label.to_owned(),
            header: machine::header(&gpu, String::new()).unwrap(),
            cases: vec![case.clone()],
        };
        for label in ["before", "after", "after"] {
            write(dir.path(), run(label)).unwrap();
        }
        let read = |name: &str| std::fs::read_to_string(dir.path().join(name)).unwrap();
        let results: Results = serde_json::from_str(&read("host.json")).unwrap();
        let labels: Vec<&str> = results.runs.iter().map(|run| run.label.as_str()).collect();
        assert_eq!(labels, ["before", "after"]);
        // Times lose their last bit on the way through the file.
        assert_eq!((results.runs[1].cases.len(), &results.runs[1].cases[0].counts), (1, &case.counts));
        let report = read("host.md");
        assert_eq!(report.lines().filter(|line| line.starts_with("| cornell | 3 |")).count(), 2, "{report}");
    }
}
