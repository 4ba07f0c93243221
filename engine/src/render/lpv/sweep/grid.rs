//! Where the cascades of the sweep lie.

use super::super::volume::{self, Volume};
use super::directions::Directions;
use super::transport;
use crate::render::RenderError;
use crate::scene::{Aabb, SceneClpv, SceneView};
use crate::world::{CellSize, ClpvPlacement, Quality};
use glam::{U64Vec3, UVec3, Vec3};

/// Cells on each side beyond the scene's bounds: for what stops light behind its surfaces.
const MARGIN: f32 = 2.0;
/// Most cells of a cascade: its opacity, 176 bytes a cell, fills a storage binding of 128 MiB, the portable limit.
const MAX_CELLS: u32 = (128 << 20) / 176;

/// The cascades of the settings for this view, finest first.
///
/// # Errors
/// Settings that make no volume; the message names the field, its value and the range.
pub fn volumes(clpv: &SceneClpv, bounds: &Aabb, view: &SceneView) -> Result<Vec<Volume>, RenderError> {
    let settings = &clpv.settings;
    if settings.cell_size == CellSize::Auto && settings.placement == ClpvPlacement::Fixed {
        return Ok(vec![around_scene(bounds, settings.quality)]);
    }
    let cells: u32 = settings.cells.iter().product();
    if cells > MAX_CELLS {
        let cells = settings.cells;
        return Err(RenderError::Clpv(format!("`cells` is {cells:?}; the sweep takes at most {MAX_CELLS} together")));
    }
    // The coarsest covers most; finer ones inside it are not swept.
    Ok(volume::volumes(clpv, bounds, view)?.split_off(settings.cascades.max(1) as usize - 1))
}

/// The finest grid of a quality that covers the scene.
pub(super) fn around_scene(bounds: &Aabb, quality: Quality) -> Volume {
    fitted(bounds, Most { cells: budget(quality), slice: largest_slice(quality) })
}

/// What a grid may have at most.
#[derive(Clone, Copy)]
struct Most {
    cells: u32,
    /// Of a layer of cells across any axis.
    slice: u32,
}

/// Cells of a layer whose light along all directions of an axis fills a storage binding.
fn largest_slice(quality: Quality) -> u32 {
    let group = Directions::of(quality).group().max(Directions::of_further_bounces(quality).group());
    (128 << 20) / (transport::FRONT_BYTES as u32 * group)
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
        if cells.element_product() <= u64::from(most.cells) && slice <= u64::from(most.slice) {
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
    fn scenes_of_any_shape_fit_the_portable_limits() {
        for size in [Vec3::new(1.0, 0.0, 1.0), Vec3::new(0.0, 0.0, 7.0), Vec3::new(1e4, 1.0, 30.0), Vec3::splat(1e-3)] {
            let bounds = Aabb { min: Vec3::new(-0.3, 2.0, 0.1), max: Vec3::new(-0.3, 2.0, 0.1) + size };
            for quality in [Quality::Low, Quality::Medium, Quality::High, Quality::Ultra] {
                let most = Most { cells: budget(quality), slice: largest_slice(quality) };
                let volume = fitted(&bounds, most);
                let n = volume.cells;
                assert!(n.element_product() <= most.cells && (n.x * n.y).max(n.y * n.z).max(n.z * n.x) <= most.slice);
                let covered = volume.bounds();
                assert!(covered.min.cmple(bounds.min).all() && covered.max.cmpge(bounds.max).all(), "{volume:?}");
            }
        }
    }
}
