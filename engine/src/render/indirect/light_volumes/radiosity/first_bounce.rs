//! The lights' first bounce as surfels see it. See `indirect/light_volumes/radiosity/first_bounce.wgsl`.

use super::links::{self, Links};
use super::{FIRST_BOUNCE, Rays, Turn};
use crate::gpu::{ComputeKey, ShaderDef};
use crate::graph::{Buffer, BufferDesc, Counts, Graph, Handle, PieceWork};
use crate::render::frame::Frame;
use crate::render::indirect::light_volumes::sweep::haze_cells::HazeCells;
use encase::ShaderType;
use wgpu::BufferUsages;

/// Lights up to which links look at all of them.
const FEW_LIGHTS: u32 = 4;
/// Rays of one submit: a submit of a second may cost the device on desktop drivers.
const RAYS_A_SUBMIT: u64 = 1 << 18;

/// `FirstBounce` of `indirect/light_volumes/radiosity/first_bounce.wgsl`.
#[derive(ShaderType)]
pub(crate) struct FirstBounceUniform {
    root: u32,
    light_count: u32,
    seed: u32,
    first: u32,
    parts: u32,
}

/// Declares the irradiance of the surfels of the lights' first bounce [W/m²]; `rays` is the number of links of a surfel.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    links: Links,
    (rays, turn): (Rays, Turn),
    lamps: Option<HazeCells>,
) -> Handle<Buffer> {
    let count = frame.surfels.count();
    let desc = BufferDesc::new(16 * u64::from(count), BufferUsages::STORAGE);
    let reflected = graph.retained_buffer("first bounce at surfels", desc);
    let (lights, root) = frame.rays.map_or((0, 0), |rays| (rays.light_count, rays.root()));
    let mut pass =
        graph.compute(FIRST_BOUNCE, ComputeKey::new("indirect/light_volumes/radiosity/first_bounce.wgsl", "main"));
    frame.bind_rays(&mut pass);
    pass.define("RAYS", ShaderDef::Uint(rays.count));
    if (1..=FEW_LIGHTS).contains(&lights) {
        pass.define("LIGHTS", ShaderDef::Uint(lights));
    }
    if let Some(lamps) = &lamps {
        lamps.bind(&mut pass);
    }
    pass.read("surfel_links", links.links);
    let reflected = pass.write("reflected_light", reflected);
    // Surfels that do not have their turn keep what they had.
    pass.depends_on(&(rays, turn));
    let (turns, samples) = (turn.count(count), links::ends(rays.count));
    let paths = u64::from(turns) * u64::from(samples);
    let casts = if lights <= FEW_LIGHTS { lights } else { 1 };
    pass.count(Counts { paths, rays: u64::from(turns) * u64::from(samples * casts), ..Counts::default() });
    let work = PieceWork { units: samples.into(), on_software: RAYS_A_SUBMIT };
    let seed = rays.seed ^ 0x1656_67b1;
    pass.dispatch_pieces(turns, work, "first_bounce", move |surfels| {
        let first = surfels.first * turn.parts + turn.part;
        vec![FirstBounceUniform { root, light_count: lights, seed, first, parts: turn.parts }]
    });
    reflected
}
