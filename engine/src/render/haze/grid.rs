//! The grid before the camera.

use crate::graph::PassBindings;
use crate::render::frame::Frame;
use crate::scene::{MediumShape, SceneMedium};
use encase::ShaderType;
use glam::{UVec2, Vec2, Vec3};

/// `SLICES` of `lib/haze.wgsl`.
const SLICES: u32 = 40;
/// Columns of an image of usual height, from top to bottom.
const ROWS: u32 = 72;
/// Widest column \[pixels\].
const MAX_TILE: u32 = 8;
/// Optical depth beyond which nothing is seen.
const OPAQUE: f32 = 14.0;

/// `Haze` of `lib/haze.wgsl`.
#[derive(Clone, Copy, ShaderType)]
pub(crate) struct HazeUniform {
    columns: UVec2,
    tile: f32,
    begin: f32,
    length: f32,
    power: f32,
    shift: Vec2,
    depth_shift: f32,
    padding: f32,
}

/// Columns of pixels, cut into slices by distance. Other frames of those that are averaged have it shifted, so that their mean
/// shows no steps.
#[derive(Clone, Copy)]
pub(super) struct Grid {
    uniform: HazeUniform,
}

impl Grid {
    /// That of a frame.
    pub fn of(frame: &Frame) -> Self {
        let [width, height] = frame.view.size;
        let tile = (height / ROWS).clamp(1, MAX_TILE);
        let (begin, end) = reach(frame);
        let length = (end - begin).max(1e-3);
        // Where media begin at the eye, slices grow with the distance.
        let power = if begin < 0.05 * length { 2.0 } else { 1.0 };
        let [x, y, z] = shift(frame);
        Self {
            uniform: HazeUniform {
                columns: UVec2::new(width.div_ceil(tile), height.div_ceil(tile)).max(UVec2::ONE),
                tile: tile as f32,
                begin,
                length,
                power,
                shift: Vec2::new(x, y),
                depth_shift: z,
                padding: 0.0,
            },
        }
    }

    pub fn bind(&self, pass: &mut PassBindings) {
        pass.uniform("haze", &self.uniform);
    }

    pub fn columns(&self) -> u32 {
        self.uniform.columns.element_product()
    }

    pub fn cells(&self) -> u32 {
        self.columns() * SLICES
    }

    /// Bytes of a buffer of a vector for each cell, and what lies behind the last of each column.
    pub fn bytes(&self) -> u64 {
        16 * u64::from(self.columns()) * u64::from(SLICES + 2)
    }
}

/// Three numbers within ±1/2: of images that are averaged other ones each, spread as evenly as their shifts are, since whole
/// multiples of a lattice's coordinates make a lattice again. The image that stands for itself has none of it.
fn shift(frame: &Frame) -> [f32; 3] {
    let [x, y] = frame.view.jitter;
    let turn = frame.number().map_or(0.0, |number| (f64::from(number) * 0.618_033_988_75).fract() as f32);
    [3.0 * x + 7.0 * y, 7.0 * x + 2.0 * y, 5.0 * x + 3.0 * y + turn].map(|sum| sum - sum.round())
}

/// Distances between which media are seen \[m\].
fn reach(frame: &Frame) -> (f32, f32) {
    let eye = frame.view.eye();
    let of_scene = match frame.bounds.is_empty() {
        true => 100.0,
        false => frame.bounds.corners().iter().fold(1.0, |far: f32, corner| far.max(corner.distance(eye))),
    };
    let media = &frame.scene.media;
    let spans = media.iter().map(|medium| span(medium, eye, of_scene));
    let (begin, end) = spans.fold((f32::MAX, 0.0_f32), |(low, high), (begin, end)| (low.min(begin), high.max(end)));
    let even = media.iter().filter(|medium| medium.shape == MediumShape::Everywhere && medium.falloff == 0.0);
    let extinction = even.map(|medium| medium.extinction).sum::<f32>();
    let visible = if extinction > 0.0 { OPAQUE / extinction } else { f32::MAX };
    let begin = begin.clamp(0.0, 1e6);
    (begin, end.min(visible).clamp(begin, 1e7))
}

/// Distances from the eye between which a medium lies; what is everywhere reaches as far as the scene.
fn span(medium: &SceneMedium, eye: Vec3, of_scene: f32) -> (f32, f32) {
    if medium.shape == MediumShape::Everywhere {
        return (0.0, of_scene);
    }
    let world_from_local = medium.local_from_world.inverse();
    let corner = match medium.shape {
        MediumShape::Box => 1.0,
        _ => 0.57735,
    };
    let axes = world_from_local.matrix3;
    let radius = corner * (axes.x_axis.length() + axes.y_axis.length() + axes.z_axis.length());
    let distance = Vec3::from(world_from_local.translation).distance(eye);
    ((distance - radius).max(0.0), distance + radius)
}
