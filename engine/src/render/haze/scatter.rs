//! What media scatter towards the eye, slice by slice. See `haze/scatter.wgsl`.

use super::grid::Grid;
use crate::gpu::ComputeKey;
use crate::graph::{Buffer, BufferDesc, Counts, Graph, Handle, Texture};
use crate::render::direct::lamps::Lamps;
use crate::render::frame::Frame;
use crate::render::indirect::light_volumes::Field;
use wgpu::BufferUsages;

/// Declares the pass; the result is light over density, and optical depth, by column and slice.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    depth: Handle<Texture>,
    grid: &Grid,
    lamps: Option<Lamps<'a>>,
    field: Option<Field>,
) -> Handle<Buffer> {
    let scattered = graph.buffer("haze, light by slice", BufferDesc::new(grid.bytes(), BufferUsages::STORAGE));
    let mut pass = graph.compute("haze scatter", ComputeKey::new("haze/scatter.wgsl", "main"));
    frame.gpu_scene.bind_media(&mut pass);
    frame.bind_view(&mut pass);
    grid.bind(&mut pass);
    pass.read("depth", depth);
    let scattered = pass.write("scattered", scattered);
    pass.count(Counts { cells: grid.cells().into(), ..Counts::default() });
    // Apart from the lights: together they are more than Mesa's software driver (22.3) compiles without a crash.
    let lamps = lamps.filter(|lamps| !lamps.is_empty());
    if field.is_some() || lamps.is_none() {
        let mut step = pass.step("main");
        if let Some(field) = &field {
            step.flag(field.define(), true);
            // What surfaces look up by their normals is not asked for.
            field.bind(&mut step, |name| name != "facing");
        }
        step.over_items(grid.cells());
    }
    if let Some(lamps) = lamps {
        lamps.declare_steps(&mut pass, field.is_some(), grid.cells());
    }
    pass.finish();
    scattered
}
