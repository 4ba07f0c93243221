//! Links of surfels to the surfaces that they see. See `indirect/light_volumes/radiosity/links.wgsl`.

use super::{LINKS, Rays, Turn};
use crate::gpu::{ComputeKey, ShaderDef};
use crate::graph::{Buffer, BufferDesc, Counts, Graph, Handle, PieceWork};
use crate::render::frame::Frame;
use encase::ShaderType;
use glam::Vec3;
use wgpu::BufferUsages;

/// Bytes of a link: `surfel_links` of `links.wgsl`.
const LINK_BYTES: u64 = 8;
/// Bytes of where a link ended: `LinkEnd` of `lib/radiosity.wgsl`.
const END_BYTES: u64 = 24;
/// Most links of a surfel that remember where they ended, as `ENDS` there.
const MOST_ENDS: u32 = 8;
/// Rays of one submit: a submit of a second may cost the device on desktop drivers.
const RAYS_A_SUBMIT: u64 = 1 << 18;

/// `Links` of `indirect/light_volumes/radiosity/links.wgsl`.
#[derive(ShaderType, Clone, Copy)]
pub(crate) struct LinksUniform {
    sky: Vec3,
    sky_turn: f32,
    root: u32,
    emitter_count: u32,
    seed: u32,
    first: u32,
    first_ray: u32,
    far: f32,
    parts: u32,
    near: f32,
}

/// The links of all surfels, and what shines on them.
#[derive(Clone, Copy)]
pub(super) struct Links {
    /// Those of a surfel follow each other, and their ends them: see `lib/radiosity.wgsl`.
    pub links: Handle<Buffer>,
    /// Irradiance of each surfel from emissive surfaces and the sky [W/m²]; after all of them that by the rays of each part.
    pub shone_on: Handle<Buffer>,
}

/// How many links of a surfel remember where they ended, of so many.
pub(super) fn ends(links: u32) -> u32 {
    links.min(MOST_ENDS)
}

/// Bytes of so many links of a surfel, and of their ends.
pub(super) fn bytes_of_surfel(links: u32) -> u64 {
    LINK_BYTES * u64::from(links) + END_BYTES * u64::from(ends(links))
}

/// Declares the links of the surfels, so many rays each. `near` is the distance up to which they go on from what they meet
/// \[m\].
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    surfels: Handle<Buffer>,
    (rays, turn): (Rays, Turn),
    near: f32,
) -> Links {
    let count = frame.surfels.count();
    let buffer = |bytes: u64| BufferDesc::new(bytes * u64::from(count), BufferUsages::STORAGE);
    let links = graph.retained_buffer("links of surfels", buffer(bytes_of_surfel(rays.count)));
    let shone_on = graph.retained_buffer("emitted light at surfels", buffer(16 * (1 + u64::from(rays.parts()))));
    let scene = frame.scene;
    let (root, emitter_count) = frame.rays.map_or((0, 0), |rays| (rays.root(), rays.emitter_count));
    // A part of the rays is cast while objects move; else the links stay as they are.
    let turn = if rays.part.is_some() { turn } else { Turn::ALL };
    let mut pass = graph.compute(LINKS, ComputeKey::new("indirect/light_volumes/radiosity/links.wgsl", "main"));
    frame.bind_ray_surfaces(&mut pass);
    frame.bind_patches(&mut pass);
    frame.bind_sky(&mut pass);
    pass.define("RAYS", ShaderDef::Uint(rays.count));
    pass.define("AT_ONCE", ShaderDef::Uint(rays.at_once()));
    pass.flag("NOT_ABSORBED", true);
    pass.read("surfels", surfels);
    let found = Links { links: pass.write("surfel_links", links), shone_on: pass.write("shone_on", shone_on) };
    // Links that are not cast again keep what they found.
    pass.depends_on(&(rays, turn));
    let (turns, cast) = (turn.count(count), rays.cast());
    let rays_a_surfel = u64::from(cast.end - cast.start);
    let paths = u64::from(turns) * rays_a_surfel;
    let casts = 1 + u64::from(emitter_count > 0) + u64::from(scene.sky_map.is_some());
    pass.count(Counts { paths, rays: paths * casts, ..Counts::default() });
    let uniform = LinksUniform {
        sky: scene.sky,
        sky_turn: scene.sky_map.as_ref().map_or(0.0, |map| map.turn),
        root,
        emitter_count,
        seed: rays.seed,
        first: 0,
        first_ray: 0,
        far: frame.surfels.patch_size(),
        parts: turn.parts,
        near,
    };
    let work = PieceWork { units: rays_a_surfel, on_software: RAYS_A_SUBMIT };
    pass.dispatch_pieces(turns, work, "links", move |surfels| {
        let first = surfels.first * turn.parts + turn.part;
        let at_once = cast.clone().step_by(rays.at_once() as usize);
        at_once.map(|first_ray| LinksUniform { first, first_ray, ..uniform }).collect()
    });
    found
}
