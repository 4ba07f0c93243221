//! `bench --growth`: how cost grows with what a scene holds, and pairs of scenes whose ratio is bounded.
//!
//! ```text
//! axis (what grows, by which numbers) ─ scene (its text) ─ measure (load, draw) ─┬─ results.json
//! pairs (two scenes in turns) ───────────────────────────────────────────────────┘
//! ```

mod axis;
mod figures;
mod glb;
mod measure;
mod pairs;
mod scene;

pub use axis::{Axis, Series};
pub use figures::{Growth, GrowthPoint, Pair};
pub(super) use glb::container;
pub use measure::Course;

use super::results::Store;
use crate::cli::Grows;
use anyhow::{Context, Result};
use lightwell_runtime::progress::Bar;

/// Takes the measurements that are missing in the results.
///
/// # Errors
/// If a file cannot be written. A scene that is refused is a result.
pub fn run(grows: &[Grows], course: &Course, store: &mut Store, bar: &Bar) -> Result<()> {
    let folder = &course.folder;
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
    let wanted = |name: &str| grows.iter().any(|grows| grows.takes(name));
    for axis in Axis::ALL.into_iter().filter(|axis| wanted(axis.name())) {
        for &series in axis.series() {
            curve(course, axis, series, store, bar)?;
        }
    }
    if wanted("pairs") { pairs::measure(course, store, bar) } else { Ok(()) }
}

/// One curve; points that were measured already are kept.
fn curve(course: &Course, axis: Axis, series: Series, store: &mut Store, bar: &Bar) -> Result<()> {
    let before = measure::resident_bytes();
    for count in axis.counts(course.quick) {
        let curves = &mut store.results.growth;
        let curve = curves.iter().find(|curve| curve.is(axis.name(), series.name()));
        if curve.is_some_and(|curve| curve.points.iter().any(|point| point.count == count)) {
            continue;
        }
        bar.set_message(format!("{count} {}, {}", axis.name(), series.name()));
        bar.tick();
        let point = measure::point(course, axis, series, count, before)?;
        enter(&mut store.results.growth, axis, series, point);
        store.save()?;
    }
    Ok(())
}

fn enter(curves: &mut Vec<Growth>, axis: Axis, series: Series, point: GrowthPoint) {
    let index = curves.iter().position(|curve| curve.is(axis.name(), series.name())).unwrap_or_else(|| {
        curves.push(Growth { axis: axis.name().to_owned(), series: series.name().to_owned(), points: Vec::new() });
        curves.len() - 1
    });
    curves[index].points.push(point);
    curves[index].points.sort_by_key(|point| point.count);
}
