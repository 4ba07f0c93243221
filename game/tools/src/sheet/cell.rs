//! Loading and drawing one model or scene, whatever it does.

use super::subject::Subject;
use crate::cli::SheetArgs;
use anyhow::Result;
use lightwell::gpu::Gpu;
use lightwell::scene::SceneView;
use lightwell_runtime::cli::{Common, LookArgs};
use lightwell_runtime::logging;
use lightwell_runtime::session::{Session, open_gpu};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, mpsc};
use std::time::{Duration, Instant};

/// The result of a model or scene.
#[derive(Clone, Debug, Default)]
pub struct Cell {
    /// What a screen shows, three sRGB bytes a pixel; none if it could not be drawn.
    pub rgb: Option<Vec<u8>>,
    /// Warnings while it was loaded and drawn.
    pub warnings: Vec<String>,
    /// Why it could not be loaded or drawn.
    pub error: Option<String>,
    /// Primitives in the scene.
    pub primitives: usize,
    /// Triangles of all primitives.
    pub triangles: u64,
    /// Time of loading.
    pub loading: Duration,
    /// Time of the first frame, with uploads and shaders.
    pub drawing: Duration,
}

/// Draws all, so many at a time; the cells are in the order of the subjects. `done` is told of each.
pub fn draw_all(
    subjects: &[Subject],
    args: &SheetArgs,
    common: &Common,
    workers: usize,
    done: &(dyn Fn() + Sync),
) -> Vec<Cell> {
    let next = AtomicUsize::new(0);
    let (sender, receiver) = mpsc::channel();
    let mut cells = vec![Cell::default(); subjects.len()];
    std::thread::scope(|scope| {
        for _ in 0..workers.min(subjects.len()) {
            let (sender, next) = (sender.clone(), &next);
            scope.spawn(move || {
                let mut device = None;
                while let Some((index, subject)) = take(subjects, next) {
                    let cell = draw(subject, args, common, &mut device);
                    done();
                    if sender.send((index, cell)).is_err() {
                        return;
                    }
                }
            });
        }
        drop(sender);
        for (index, cell) in receiver {
            cells[index] = cell;
        }
    });
    cells
}

fn take<'a>(subjects: &'a [Subject], next: &AtomicUsize) -> Option<(usize, &'a Subject)> {
    let index = next.fetch_add(1, Ordering::Relaxed);
    subjects.get(index).map(|subject| (index, subject))
}

/// Never fails: what went wrong is in the cell. The device is kept for the next one, unless it met an error.
fn draw(subject: &Subject, args: &SheetArgs, common: &Common, device: &mut Option<Arc<Gpu>>) -> Cell {
    log::info!("{}", subject.path.display());
    let mut cell = Cell::default();
    let (result, warnings) =
        logging::catching(|| catch_unwind(AssertUnwindSafe(|| attempt(subject, args, common, device, &mut cell))));
    // The cell says which file it is.
    let place = format!("{}: ", subject.path.display());
    cell.warnings = warnings.iter().map(|warning| warning.replace(&place, "")).collect();
    cell.error = match result {
        Ok(Ok(())) => None,
        Ok(Err(error)) => Some(format!("{error:#}").replace(&place, "")),
        Err(_) => Some("the program panicked: this is a defect of Lightwell".to_owned()),
    };
    cell
}

fn attempt(
    subject: &Subject,
    args: &SheetArgs,
    common: &Common,
    device: &mut Option<Arc<Gpu>>,
    cell: &mut Cell,
) -> Result<()> {
    let gpu = match device.take() {
        Some(gpu) => gpu,
        None => Arc::new(open_gpu(common)?),
    };
    let look = LookArgs { gi: args.gi, sets: args.sets.clone(), ..LookArgs::default() };
    let start = Instant::now();
    let opened = Session::open(gpu.clone(), &subject.path.to_string_lossy(), &look, common);
    cell.loading = start.elapsed();
    // A file that does not load has not touched the device.
    let mut session = opened.inspect_err(|_| *device = Some(gpu.clone()))?;
    cell.primitives = session.scene().primitives.len();
    cell.triangles = session.scene().primitives.iter().map(|p| p.mesh.indices.len() as u64 / 3).sum();
    session.set_seconds(args.time);
    let view = SceneView { camera: session.camera()?, size: args.size, jitter: [0.0; 2] };
    let start = Instant::now();
    session.render(&view, &session.display_settings())?;
    cell.rgb = Some(session.display_bytes()?.1);
    cell.drawing = start.elapsed();
    *device = Some(gpu);
    Ok(())
}
