//! Where the cascades of the sweep lie.

use super::coverage;
use super::directions::Directions;
use super::shell;
use crate::render::RenderError;
use crate::render::indirect::light_volumes::volume::{self, Volume};
use crate::scene::{Aabb, SceneClpv, SceneView};
use crate::world::{CellSize, ClpvPlacement, Quality};
use glam::{U64Vec3, UVec3, Vec3};

/// Cells on each side beyond the scene's bounds: for what stops light behind its surfaces.
const MARGIN: f32 = 2.0;
/// How far ahead of the eye the finer cascades lie, as a part of their half extent.
const AHEAD: f32 = 0.6;
/// Most bytes of a storage binding, the portable limit.
pub(super) const BINDING: u64 = 128 << 20;
/// Most cells of a cascade: its opacity, 176 bytes a cell, fills a storage binding.
const MAX_CELLS: u32 = BINDING as u32 / 176;
/// Most cells along an axis: a texture that walls are drawn into has a texel for each part, and 8192 is the portable limit.
const MAX_EDGE: u32 = 8192 / coverage::PARTS;

/// The cascades of the settings for this view, finest first; `quality` is that of the volumes.
///
/// # Errors
/// Settings that make no volume; the message names the field, its value and the range.
pub fn volumes(
    clpv: &SceneClpv,
    quality: Quality,
    bounds: &Aabb,
    view: &SceneView,
) -> Result<Vec<Volume>, RenderError> {
    let settings = &clpv.settings;
    if settings.cell_size == CellSize::Auto && settings.placement == ClpvPlacement::Fixed {
        let forward = -Vec3::from(view.camera.world_from_view.matrix3.z_axis).normalize_or_zero();
        return Ok(around_camera(around_scene(bounds, quality), quality, settings.cascades, view.eye(), forward));
    }
    let cells: u32 = settings.cells.iter().product();
    if cells > MAX_CELLS {
        let cells = settings.cells;
        return Err(RenderError::method(format!(
            "Clpv component: `cells` is {cells:?}; the sweep takes at most {MAX_CELLS} together"
        )));
    }
    Ok(nested(volume::volumes(clpv, bounds, view)?))
}

/// A grid over the scene with finer ones before the camera in it, finest first.
fn around_camera(scene: Volume, quality: Quality, count: u32, eye: Vec3, forward: Vec3) -> Vec<Volume> {
    let mut cascades = vec![scene];
    for _ in 1..count {
        let outer = cascades[cascades.len() - 1];
        let Some(size) = finer_size(outer.cells, quality) else { break };
        let half = 0.5 * outer.cell * size.as_vec3();
        let center = eye + AHEAD * half * forward;
        let finer = Volume {
            origin: center - half,
            cell: 0.5 * outer.cell,
            cells: 2 * size,
            fade_center: center,
            fade_half: half - 0.5 * outer.cell,
        };
        cascades.push(finer);
    }
    cascades.reverse();
    nested(cascades)
}

/// How many cells of a cascade the next finer one covers: as near to a cube as it can be within the budget.
fn finer_size(outer: UVec3, quality: Quality) -> Option<UVec3> {
    let mut size = outer.checked_sub(UVec3::splat(2)).filter(|size| size.min_element() > 0)?;
    while !is_affordable(size, quality) {
        let longest = size.max_position();
        size[longest] -= 1;
    }
    Some(size)
}

/// Whether a cascade over so many cells of the next coarser one keeps to the budget, and what it is swept with to the
/// portable limits.
fn is_affordable(size: UVec3, quality: Quality) -> bool {
    let n = (2 * size).as_u64vec3();
    let slice = (n * U64Vec3::new(n.y, n.z, n.x)).max_element();
    let sets = [Directions::of(quality), Directions::of_further_bounces(quality)];
    n.element_product() <= u64::from(budget(quality))
        && n.max_element() <= u64::from(MAX_EDGE)
        && slice <= u64::from(largest_slice(quality))
        && sets.iter().all(|set| shell::shell_bytes(size, set) <= BINDING)
}

/// Moves each finer cascade to whole cells of the next coarser one, at least one of them from its border; what has no
/// room there is left out. Finest first.
fn nested(cascades: Vec<Volume>) -> Vec<Volume> {
    let mut fitting: Vec<Volume> = Vec::new();
    for finer in cascades.into_iter().rev() {
        match fitting.last() {
            None => fitting.push(finer),
            Some(outer) => match within(outer, finer) {
                Some(finer) => fitting.push(finer),
                None => break,
            },
        }
    }
    fitting.reverse();
    fitting
}

fn within(outer: &Volume, finer: Volume) -> Option<Volume> {
    let room = outer.cells.checked_sub(UVec3::splat(2))?;
    let size = (finer.cells / 2).min(room);
    if size.min_element() == 0 {
        return None;
    }
    let wanted = ((finer.origin - outer.origin) / outer.cell).round();
    let last = (outer.cells - size - 1).as_vec3();
    let low = wanted.clamp(Vec3::ONE, last);
    let moved = (low - wanted) * outer.cell;
    let origin = outer.origin + low * outer.cell;
    Some(Volume { origin, cells: 2 * size, fade_center: finer.fade_center + moved, ..finer })
}

/// The finest grid of a quality that covers the scene.
pub(super) fn around_scene(bounds: &Aabb, quality: Quality) -> Volume {
    fitted(bounds, Most { cells: budget(quality), slice: largest_slice(quality) })
}

/// The grid for all bounces but the last, over the whole scene, if one that is much coarser than the cascades does. Cells
/// that a user set are taken for all bounces.
///
/// With it a frame of `High` takes half the time.
pub(super) fn of_further_bounces(
    clpv: &SceneClpv,
    quality: Quality,
    bounds: &Aabb,
    volumes: &[Volume],
) -> Option<Volume> {
    let settings = &clpv.settings;
    let cells = match quality {
        Quality::Low => return None,
        Quality::Medium => 24 * 24 * 24,
        Quality::High => 40 * 40 * 40,
        Quality::Ultra => 52 * 52 * 52,
    };
    let grid = fitted(bounds, Most { cells, slice: largest_slice(quality) });
    let swept: u32 = volumes.iter().map(Volume::cell_count).sum();
    let is_free = settings.cell_size == CellSize::Auto && settings.placement == ClpvPlacement::Fixed;
    (is_free && swept >= 2 * grid.cell_count()).then_some(grid)
}

/// Limits of a grid.
#[derive(Clone, Copy)]
struct Most {
    cells: u32,
    /// Of a layer of cells across any axis.
    slice: u32,
}

/// Cells of a layer whose light along all directions of an axis, before and after the layer, fills a storage binding.
fn largest_slice(quality: Quality) -> u32 {
    let group = Directions::of(quality).group().max(Directions::of_further_bounces(quality).group());
    BINDING as u32 / (64 * group)
}

/// Cells of a grid that covers the scene.
fn budget(quality: Quality) -> u32 {
    match quality {
        Quality::Low => 24 * 24 * 24,
        Quality::Medium => 40 * 40 * 40,
        Quality::High => 64 * 64 * 64,
        Quality::Ultra => 88 * 88 * 88,
    }
}

/// The finest grid within the budget that covers the bounds with a margin. Cell sizes are (1 + k/16)·2ⁿ, so
/// that a small move of an object changes none.
fn fitted(bounds: &Aabb, most: Most) -> Volume {
    let size = bounds.size();
    let longest = size.max_element();
    let around = |cell: f32| {
        let low = (bounds.min / cell - MARGIN).floor();
        let high = (bounds.max / cell + MARGIN).ceil();
        Volume {
            origin: low * cell,
            cell,
            cells: (high - low).as_uvec3().max(UVec3::ONE),
            fade_center: 0.5 * (low + high) * cell,
            fade_half: 0.5 * (high - low) * cell,
        }
    };
    if !(longest.is_finite() && longest > 1e-12 && bounds.min.is_finite()) {
        let origin = bounds.center() - Vec3::splat(2.0);
        return Volume {
            origin,
            cell: 1.0,
            cells: UVec3::splat(4),
            fade_center: origin + 2.0,
            fade_half: Vec3::splat(2.0),
        };
    }
    let mut step = (16.0 * (longest / most.cells as f32).log2()).floor() as i32;
    loop {
        let volume = around(size_of(step));
        let cells = volume.cells.as_u64vec3();
        let slice = (cells * U64Vec3::new(cells.z, cells.x, cells.y)).max_element();
        let fits = cells.element_product() <= u64::from(most.cells) && slice <= u64::from(most.slice);
        if fits && volume.cells.max_element() <= MAX_EDGE {
            return volume;
        }
        step += 1;
    }
}

/// (1 + k/16)·2ⁿ for step 16·n + k.
fn size_of(step: i32) -> f32 {
    (1.0 + step.rem_euclid(16) as f32 / 16.0) * (step.div_euclid(16) as f32).exp2()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finer_cascades_lie_on_whole_cells_inside_the_coarser_ones() {
        let bounds = Aabb { min: Vec3::new(-30.0, -1.0, -8.0), max: Vec3::new(30.0, 9.0, 8.0) };
        let coarse = Volume { cells: UVec3::new(9, 4, 13), ..around_scene(&bounds, Quality::Low) };
        let eyes = [Vec3::ZERO, Vec3::new(29.9, 8.9, -7.9), Vec3::new(1e6, -40.0, 3.0), Vec3::new(-3.3, 0.1, 2.2)];
        for (scene, quality) in [(around_scene(&bounds, Quality::Low), Quality::Low), (coarse, Quality::Medium)] {
            for eye in eyes {
                for forward in [Vec3::X, Vec3::NEG_Y, Vec3::new(0.6, 0.0, -0.8)] {
                    let cascades = around_camera(scene, quality, 4, eye, forward);
                    assert!(cascades.len() >= 2, "{cascades:?}");
                    for pair in cascades.windows(2) {
                        let (finer, outer) = (pair[0], pair[1]);
                        assert_eq!((finer.cell, finer.cells % 2), (0.5 * outer.cell, UVec3::ZERO));
                        let low = (finer.origin - outer.origin) / outer.cell;
                        assert!((low - low.round()).abs().max_element() < 1e-3, "{low}");
                        let high = low.round().as_uvec3() + finer.cells / 2;
                        assert!(
                            low.round().min_element() >= 1.0 && high.cmplt(outer.cells).all(),
                            "{finer:?} in {outer:?}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn scenes_of_any_shape_fit_the_portable_limits() {
        for size in [
            Vec3::new(1.0, 0.0, 1.0),
            Vec3::new(0.0, 0.0, 7.0),
            Vec3::new(1e4, 1.0, 30.0),
            Vec3::splat(1e-3),
            Vec3::new(1e4, 1e-3, 1e-3),
            Vec3::new(4e2, 0.05, 4e2),
        ] {
            let bounds = Aabb { min: Vec3::new(-0.3, 2.0, 0.1), max: Vec3::new(-0.3, 2.0, 0.1) + size };
            for quality in [Quality::Low, Quality::Medium, Quality::High, Quality::Ultra] {
                let most = Most { cells: budget(quality), slice: largest_slice(quality) };
                let volume = fitted(&bounds, most);
                let n = volume.cells;
                assert!(n.element_product() <= most.cells && (n.x * n.y).max(n.y * n.z).max(n.z * n.x) <= most.slice);
                assert!(n.max_element() <= MAX_EDGE, "{volume:?}");
                for finer in around_camera(volume, quality, 4, Vec3::ZERO, Vec3::X) {
                    let n = finer.cells;
                    assert!((n.x * n.y).max(n.y * n.z).max(n.z * n.x) <= most.slice, "{finer:?}");
                    assert!(n.max_element() <= MAX_EDGE, "{finer:?}");
                    let shell = shell::shell_bytes(n / 2, &Directions::of(quality));
                    assert!(finer.cell == volume.cell || shell <= BINDING, "{finer:?}");
                }
                let covered = volume.bounds();
                assert!(covered.min.cmple(bounds.min).all() && covered.max.cmpge(bounds.max).all(), "{volume:?}");
            }
        }
    }
}
