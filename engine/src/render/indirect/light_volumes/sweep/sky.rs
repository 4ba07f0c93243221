//! Light of the sky alone: one sweep along few directions. Methods that contribute no light of the sky take it from here, and
//! glossy surfaces learn from it how much of the sky they see.

use super::directions::Directions;
use super::opacity::Obstacles;
use super::transport::{self, Kept, Sky};
use super::{BounceCount, Indirect, Level, grid, irradiance, opacity, surfels};
use crate::graph::Graph;
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::GBuffer;
use crate::render::indirect::Scattered;
use crate::render::indirect::light_volumes::{Field, Volume};
use crate::scene::Aabb;
use crate::world::{Precision, Quality};

/// The sky's part in names of passes and resources, in place of a cascade's number.
const NAME: &str = "sky";

/// The grid: it covers the scene.
pub(in crate::render) fn volume(bounds: &Aabb) -> Volume {
    grid::around_scene(bounds, Quality::Low)
}

/// Declares all passes; the result is what diffuse surfaces reflect, with no bounce in between.
pub(in crate::render) fn declare<'a>(graph: &mut Graph<'a>, frame: &Frame<'a>, gbuffer: &GBuffer) -> Indirect {
    let volume = volume(&frame.bounds);
    let surfels = surfels::declare(graph, frame);
    let obstacles = opacity::declare(graph, frame, surfels, NAME, &volume);
    let level = level(graph, frame, obstacles, &volume);
    let field = field_of(&level);
    let names = irradiance::Names { pass: "relight, sky", image: "sky radiance" };
    let radiance = irradiance::relight(graph, frame, gbuffer, names, 0.0, &[level]);
    Indirect {
        radiance,
        mirrored: None,
        is_glossy: false,
        sky: Some(field.clone()),
        field,
        scattered: Scattered::default(),
        change: None,
    }
}

/// Declares the sweep of the sky's light through a grid.
pub(super) fn level<'a>(graph: &mut Graph<'a>, frame: &Frame<'a>, obstacles: Obstacles, volume: &Volume) -> Level {
    let mut level = transport::level(graph, obstacles, NAME, volume, Precision::Single, Kept::OneSweep);
    send_nothing(graph, &mut level);
    let bounces = BounceCount { swept: 1, has_tail: false };
    let step = transport::Step { index: 0, bounce: 0, bounces };
    let mut levels = [level];
    transport::declare(graph, frame, &Directions::of(Quality::Medium), &mut levels, None, Sky::Scene, step);
    let [level] = levels;
    level
}

pub(super) fn field_of(level: &Level) -> Field {
    Field::Swept { volume: level.volume, buffers: [level.light().axes, level.light().facing, level.obstacles.opacity] }
}

/// Nothing inside the grid sends out light.
fn send_nothing(graph: &mut Graph<'_>, level: &mut Level) {
    level.emission = graph.clear("emit, sky", level.emission);
}
