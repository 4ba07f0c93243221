//! One point of a curve: a scene is loaded and drawn.

use super::axis::{Axis, Series};
use super::figures::GrowthPoint;
use super::scene;
use crate::bench::results::Spread;
use anyhow::{Context, Result};
use lightwell_runtime::cli::{Common, LookArgs};
use lightwell_runtime::session::Session;

use lightwell::gpu::Gpu;
use lightwell::graph::FrameReport;
use lightwell::render::RenderSettings;
use lightwell::scene::SceneView;
use lightwell::world::{Name, Transform};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

/// Frames before the measured ones.
const WARM_UP: u32 = 2;

/// How everything is measured.
pub struct Course<'a> {
    /// The device.
    pub gpu: &'a Arc<Gpu>,
    /// Options of the command line.
    pub common: &'a Common,
    /// Folder for the scenes.
    pub folder: PathBuf,
    /// Frames measured.
    pub frames: u32,
    /// The short run.
    pub quick: bool,
}

/// A drawn frame.
pub struct Frame {
    /// Time from start to end [ms].
    pub wall: f64,
    /// Counts of its work.
    pub report: FrameReport,
}

impl Frame {
    /// Time on the device [ms].
    pub fn device(&self) -> f64 {
        self.report.gpu_ms().unwrap_or(self.wall)
    }

    /// Time to record its commands [ms].
    pub fn record(&self) -> f64 {
        self.report.passes.iter().map(|pass| pass.cpu_ms).sum()
    }
}

/// Draws a frame; without reuse everything is computed.
///
/// # Errors
/// If it cannot be drawn.
pub fn frame(session: &mut Session, size: [u32; 2], reuse: bool) -> Result<Frame> {
    let settings = RenderSettings { no_cache: !reuse, ..session.render_settings(true) };
    let start = Instant::now();
    let view = SceneView { camera: session.camera()?, size, jitter: [0.0; 2] };
    let report = session.render(&view, &settings)?;
    session.gpu.wait();
    Ok(Frame { wall: start.elapsed().as_secs_f64() * 1e3, report })
}

/// Median, least and greatest of a value of some frames.
pub fn spread(frames: &[Frame], value: fn(&Frame) -> f64) -> Spread {
    Spread::of(&frames.iter().map(value).collect::<Vec<_>>()).unwrap_or_default()
}

/// Measures a point; a scene that is refused is a point too, with the reason. `before` is what the process took before
/// the curve began.
///
/// # Errors
/// If the scene's file cannot be written.
pub fn point(course: &Course, axis: Axis, series: Series, count: u64, before: Option<u64>) -> Result<GrowthPoint> {
    let path = course.folder.join(format!("{}.scene.ron", axis.name()));
    std::fs::write(&path, scene::text(axis, series, count))
        .with_context(|| format!("cannot write {}", path.display()))?;
    let look = LookArgs { gi: Some(series.gi()), ..LookArgs::default() };
    let drawn = || -> Result<GrowthPoint> {
        let start = Instant::now();
        let mut session = Session::open(course.gpu.clone(), &path.to_string_lossy(), &look, course.common)?;
        let load_ms = start.elapsed().as_secs_f64() * 1e3;
        let size = scene::size(axis, count);
        let mut drawn = draw(&mut session, size, course.frames)?;
        drawn.process_bytes = before.zip(resident_bytes()).map(|(before, now)| now.saturating_sub(before));
        Ok(GrowthPoint { count, load_ms, ..drawn })
    };
    Ok(drawn().unwrap_or_else(|error| GrowthPoint {
        count,
        refused: Some(format!("{error:#}")),
        ..GrowthPoint::default()
    }))
}

fn draw(session: &mut Session, size: [u32; 2], count: u32) -> Result<GrowthPoint> {
    let mut all = Vec::new();
    for index in 0..WARM_UP + count {
        let drawn = frame(session, size, false)?;
        if index >= WARM_UP {
            all.push(drawn);
        }
    }
    let (mut still, mut moved) = (Vec::new(), Vec::new());
    // The first frame with reuse fills what is kept.
    frame(session, size, true)?;
    for step in 0..count {
        still.push(frame(session, size, true)?);
        let start = Instant::now();
        move_wall(session, step)?;
        let mut drawn = frame(session, size, true)?;
        drawn.wall = start.elapsed().as_secs_f64() * 1e3;
        moved.push(drawn);
    }
    let report = all.last().map(|frame| &frame.report);
    Ok(GrowthPoint {
        frame: spread(&all, |frame| frame.wall),
        device: spread(&all, Frame::device),
        record: spread(&all, Frame::record),
        still: spread(&still, |frame| frame.wall),
        moved: spread(&moved, |frame| frame.wall),
        draws: report.map_or(0, |report| report.total().draws),
        triangles: report.map_or(0, |report| report.total().triangles),
        target_bytes: report.map_or(0, |report| report.allocated_bytes),
        ..GrowthPoint::default()
    })
}

/// Moves one object, to and fro.
fn move_wall(session: &mut Session, step: u32) -> Result<()> {
    let world = &mut session.parts().world.ecs;
    let mut named = world.query::<(&Name, &mut Transform)>();
    let wall = named.iter_mut(world).find(|(name, _)| name.0 == "Wall");
    let (_, mut transform) = wall.context("the scene has no wall")?;
    transform.translation.y += if step.is_multiple_of(2) { 0.01 } else { -0.01 };
    session.set_ticks(0);
    Ok(())
}

/// Resident memory of the process [bytes], where the system tells.
pub fn resident_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib * 1024)
}
