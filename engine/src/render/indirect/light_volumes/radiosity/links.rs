//! Links of surfels to the surfaces that they see. See `indirect/light_volumes/radiosity/links.wgsl`.

use super::{LINKS, Rays, Turn};
use crate::gpu::{Binding, ShaderDef};
use crate::graph::{Buffer, BufferDesc, Graph, Handle, PassContext, PassError};
use crate::render::frame::{Frame, linear_groups};
use crate::render::rays::{RayScene, dispatch_rays};
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
#[derive(ShaderType)]
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
    let mut pass = graph.pass(LINKS);
    pass.read(surfels);
    let found = Links { links: pass.write(links), shone_on: pass.write(shone_on) };
    let scene = frame.scene;
    pass.key(&(frame.geometry_key(), frame.surfels.revision(), scene.revisions.settings, rays, frame.media_key()));
    pass.key(&frame.rays.map(RayScene::has_area_lights));
    // A part of the rays is cast while objects move; else the links stay as they are.
    let turn = if rays.part.is_some() { turn } else { Turn::ALL };
    pass.key(&(turn, near.to_bits()));
    let frame = frame.clone();
    pass.execute(move |cx| {
        let scene = frame.rays.ok_or_else(|| PassError::message("the scene is not ready for rays".to_owned()))?;
        let cast = rays.cast();
        let rays_a_surfel = u64::from(cast.end - cast.start);
        let turns = turn.count(count);
        cx.counts().paths += u64::from(turns) * rays_a_surfel;
        let casts = 1 + u64::from(scene.emitter_count > 0) + u64::from(frame.scene.sky_map.is_some());
        cx.counts().rays += u64::from(turns) * rays_a_surfel * casts;
        let surfels_a_submit = (cx.work_a_submit(RAYS_A_SUBMIT) / rays_a_surfel).max(64);
        let written = Written { surfels, found };
        for first in (0..turns).step_by(surfels_a_submit as usize) {
            let surfels_now = (turns - first).min(surfels_a_submit as u32);
            cx.work(u64::from(surfels_now) * rays_a_surfel, RAYS_A_SUBMIT)?;
            for first_ray in cast.clone().step_by(rays.at_once() as usize) {
                dispatch(cx, &frame, scene, written, (rays, turn, near), [first, surfels_now, first_ray])?;
            }
        }
        Ok(())
    });
    found
}

/// Resources of the pass.
#[derive(Clone, Copy)]
struct Written {
    surfels: Handle<Buffer>,
    found: Links,
}

fn dispatch(
    cx: &mut PassContext,
    frame: &Frame,
    scene_rays: &RayScene,
    Written { surfels, found }: Written,
    (rays, turn, near): (Rays, Turn, f32),
    [first, surfels_now, first_ray]: [u32; 3],
) -> Result<(), PassError> {
    let scene = frame.scene;
    let uniform = LinksUniform {
        sky: scene.sky,
        sky_turn: scene.sky_map.as_ref().map_or(0.0, |map| map.turn),
        root: scene_rays.root(),
        emitter_count: scene_rays.emitter_count,
        seed: rays.seed,
        first: first * turn.parts + turn.part,
        first_ray,
        far: frame.surfels.patch_size(),
        parts: turn.parts,
        near,
    };
    let uniform = cx.gpu.uniform("links", &uniform);
    let [surfels, links, shone_on] = [surfels, found.links, found.shone_on].map(|handle| cx.buffer(handle).clone());
    let mut key = scene_rays
        .shader("indirect/light_volumes/radiosity/links.wgsl", "main")
        .def("RAYS", ShaderDef::Uint(rays.count))
        .def("AT_ONCE", ShaderDef::Uint(rays.at_once()))
        .def("NOT_ABSORBED", ShaderDef::Flag(true));
    let mut group = vec![
        ("links", Binding::Buffer(&uniform)),
        ("surfels", Binding::Buffer(&surfels)),
        ("surfel_links", Binding::Buffer(&links)),
        ("shone_on", Binding::Buffer(&shone_on)),
    ];
    group.extend(frame.surfels.patches().bindings());
    if scene.sky_map.is_some() {
        group.push(("sky", Binding::Texture(frame.gpu_scene.sky())));
    } else {
        key = key.def("EVEN_SKY", ShaderDef::Flag(true));
    }
    dispatch_rays(cx, &key, &group, scene_rays, linear_groups(surfels_now))
}
