//! Where the cascades lie: nested boxes of cells.

use crate::render::RenderError;
use crate::scene::{Aabb, SceneClpv, SceneView};
use crate::world::{CellSize, ClpvPlacement};
use encase::ShaderType;
use glam::{UVec3, Vec3};

/// Most cascades, and so most volumes that the relight pass binds.
pub const MAX_CASCADES: usize = 4;
/// Most cells along an axis: 128³ cells of light fill a 128 MiB buffer, the portable limit, by three quarters.
pub const MAX_CELLS: u32 = 128;
/// Most propagation steps.
pub const MAX_STEPS: u32 = 1024;

/// One light propagation volume in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Volume {
    /// Lower corner \[m\].
    pub origin: Vec3,
    /// Edge of a cell \[m\].
    pub cell: f32,
    /// Cells along each axis.
    pub cells: UVec3,
    /// Centre of the box before it was snapped to whole cells \[m\].
    pub fade_center: Vec3,
    /// Half extent within which the unsnapped box always lies inside the snapped one \[m\].
    pub fade_half: Vec3,
}

/// `Volume` of `lib/volume.wgsl`.
#[derive(ShaderType, Clone, Copy)]
pub(crate) struct VolumeUniform {
    origin: Vec3,
    cell: f32,
    cells: UVec3,
    padding: u32,
}

impl Volume {
    pub(in crate::render) fn uniform(&self) -> VolumeUniform {
        VolumeUniform { origin: self.origin, cell: self.cell, cells: self.cells, padding: 0 }
    }

    /// The box \[m\].
    pub fn bounds(&self) -> Aabb {
        Aabb { min: self.origin, max: self.origin + self.cells.as_vec3() * self.cell }
    }

    /// Number of cells.
    pub fn cell_count(&self) -> u32 {
        self.cells.element_product()
    }

    /// Number of corners of cells: where blockers lie.
    pub fn corner_count(&self) -> u32 {
        (self.cells + 1).element_product()
    }

    /// All that the content of the volume depends on, for cache keys.
    pub(in crate::render) fn key(&self) -> ([u32; 4], [u32; 3]) {
        (self.origin.extend(self.cell).to_array().map(f32::to_bits), self.cells.to_array())
    }
}

/// The cascades of the settings for this view, finest first. `bounds` are the scene's.
///
/// # Errors
/// Settings that make no volume; the message names the field, its value and the range.
pub fn volumes(clpv: &SceneClpv, bounds: &Aabb, view: &SceneView) -> Result<Vec<Volume>, RenderError> {
    let settings = &clpv.settings;
    let wrong = |what: String| Err(RenderError::method(format!("Clpv component: {what}")));
    if !(1..=MAX_CASCADES as u32).contains(&settings.cascades) {
        return wrong(format!("`cascades` is {}; give 1 to {MAX_CASCADES}", settings.cascades));
    }
    if settings.cells.iter().any(|cells| !(1..=MAX_CELLS).contains(cells)) {
        return wrong(format!("`cells` is {:?}; give 1 to {MAX_CELLS} along each axis", settings.cells));
    }
    if settings.steps > MAX_STEPS {
        return wrong(format!("`steps` is {}; give at most {MAX_STEPS}", settings.steps));
    }
    let cells = UVec3::from(settings.cells);
    let levels = 1..settings.cascades;
    let finest = match settings.cell_size {
        CellSize::Meters(size) if size > 0.0 && size.is_finite() => size,
        CellSize::Meters(size) => return wrong(format!("`cell_size` is {size} m; give a length above 0, or Auto")),
        CellSize::Auto => automatic_cell(bounds, cells) / 2.0_f32.powi(levels.len() as i32),
    };
    let coarsest = finest * 2.0_f32.powi(levels.len() as i32);
    let automatic = settings.cell_size == CellSize::Auto;
    let cascade = |level: u32| {
        let cell = finest * 2.0_f32.powi(level as i32);
        let half = 0.5 * cells.as_vec3() * cell;
        // A cascade snaps to the cells of the next coarser one, so that their faces coincide.
        let snap = if level + 1 < settings.cascades { 2.0 * cell } else { cell };
        match settings.placement {
            ClpvPlacement::Fixed if automatic => snapped(bounds.center(), half, cell, cells, coarsest),
            ClpvPlacement::Fixed => {
                Volume { origin: clpv.center - half, cell, cells, fade_center: clpv.center, fade_half: half }
            }
            ClpvPlacement::Camera { ahead } => {
                let forward = -Vec3::from(view.camera.world_from_view.matrix3.z_axis);
                let ahead = if ahead.is_finite() { ahead.clamp(0.0, 1.0) } else { 0.0 };
                snapped(view.eye() + forward * half * ahead, half, cell, cells, snap)
            }
        }
    };
    Ok((0..settings.cascades).map(cascade).collect())
}

fn snapped(center: Vec3, half: Vec3, cell: f32, cells: UVec3, unit: f32) -> Volume {
    let origin = ((center - half) / unit).round() * unit;
    Volume { origin, cell, cells, fade_center: center, fade_half: half - 0.5 * unit }
}

/// The cell with which a grid of that many cells covers the bounds with room to snap, rounded up to the next eighth
/// of a power of two so that a small move of an object does not change it.
fn automatic_cell(bounds: &Aabb, cells: UVec3) -> f32 {
    let room = (cells.as_vec3() - 1.0).max(Vec3::splat(0.5));
    let needed = (bounds.size() / room).max_element();
    if !(needed.is_finite() && needed > 1e-12) {
        return 1.0;
    }
    let power = needed.log2().floor().exp2();
    (needed / power * 8.0).ceil() / 8.0 * power
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{SceneCamera, SceneId, ViewProjection};
    use crate::world::Clpv;
    use glam::Affine3A;

    const BOUNDS: Aabb = Aabb { min: Vec3::new(-3.0, 0.0, -2.0), max: Vec3::new(3.0, 5.0, 9.0) };

    fn view(eye: Vec3) -> SceneView {
        let camera = SceneCamera {
            id: SceneId(1),
            name: "camera".into(),
            world_from_view: Affine3A::from_translation(eye),
            projection: ViewProjection::Perspective { vertical_fov: 1.0 },
            near: 0.1,
            far: None,
            primary: true,
            lens: Default::default(),
            grading: None,
        };
        SceneView { camera, size: [64, 64], jitter: [0.0; 2] }
    }

    fn placed(settings: Clpv, eye: Vec3) -> Vec<Volume> {
        volumes(&SceneClpv { settings, center: Vec3::ONE }, &BOUNDS, &view(eye)).expect("valid settings")
    }

    #[test]
    fn automatic_volumes_cover_the_scene() {
        for cascades in 1..=4 {
            let all = placed(Clpv { cascades, ..Default::default() }, Vec3::ZERO);
            let coarsest = all.last().expect("a volume").bounds();
            assert!(coarsest.min.cmple(BOUNDS.min).all() && coarsest.max.cmpge(BOUNDS.max).all(), "{coarsest:?}");
        }
    }

    #[test]
    fn cascades_that_follow_the_camera_move_by_whole_cells_of_the_next_coarser() {
        let settings = Clpv {
            cascades: 3,
            cell_size: CellSize::Meters(0.3),
            placement: ClpvPlacement::Camera { ahead: 0.5 },
            ..Default::default()
        };
        let base = placed(settings.clone(), Vec3::ZERO);
        for step in 1..50 {
            let moved = placed(settings.clone(), Vec3::splat(0.07 * step as f32));
            for (a, (b, unit)) in base.iter().zip(moved.iter().zip([0.6, 1.2, 1.2])) {
                let cells = (b.origin - a.origin) / unit;
                assert!((cells - cells.round()).abs().max_element() < 1e-3, "{cells}");
                let margin = (b.fade_half - (b.fade_center - b.bounds().center()).abs()) - b.fade_half;
                assert!(margin.abs().max_element() <= 0.5 * unit + 1e-4);
            }
        }
    }

    #[test]
    fn settings_that_make_no_volume_are_refused_by_name() {
        for (settings, field) in [
            (Clpv { cascades: 0, ..Default::default() }, "cascades"),
            (Clpv { cells: [0, 8, 8], ..Default::default() }, "cells"),
            (Clpv { cells: [8, 8, 4000], ..Default::default() }, "cells"),
            (Clpv { cell_size: CellSize::Meters(0.0), ..Default::default() }, "cell_size"),
            (Clpv { cell_size: CellSize::Meters(f32::NAN), ..Default::default() }, "cell_size"),
            (Clpv { steps: 100_000, ..Default::default() }, "steps"),
        ] {
            let clpv = SceneClpv { settings, center: Vec3::ZERO };
            let error = volumes(&clpv, &BOUNDS, &view(Vec3::ZERO)).expect_err(field).to_string();
            assert!(error.contains(field), "{error}");
        }
    }
}
