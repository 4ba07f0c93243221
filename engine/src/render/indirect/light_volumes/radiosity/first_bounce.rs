//! The lights' first bounce as surfels see it. See `indirect/light_volumes/radiosity/first_bounce.wgsl`.

use super::links::{self, Links};
use super::{FIRST_BOUNCE, Rays, Turn};
use crate::gpu::{Binding, ShaderDef};
use crate::graph::{Buffer, BufferDesc, Graph, Handle, PassError};
use crate::render::frame::{Frame, linear_groups};
use crate::render::indirect::light_volumes::sweep::haze_cells::HazeCells;
use crate::render::rays::dispatch_rays;
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
    let mut pass = graph.pass(FIRST_BOUNCE);
    let lamp_light = lamps.map(|cells| cells.light);
    [links.links].into_iter().chain(lamp_light).for_each(|handle| pass.read(handle));
    let reflected = pass.write(reflected);
    pass.key(&(frame.geometry_key(), frame.surfels.revision(), frame.scene.revisions.lights, rays, turn));
    pass.key(&(frame.media_key(), HazeCells::key(lamps.as_ref())));
    let frame = frame.clone();
    pass.execute(move |cx| {
        let scene = frame.rays.ok_or_else(|| PassError::message("the scene is not ready for rays".to_owned()))?;
        let lights = scene.light_count;
        let samples = links::ends(rays.count);
        let [links, reflected] = [links.links, reflected].map(|handle| cx.buffer(handle).clone());
        let turns = turn.count(count);
        cx.counts().paths += u64::from(turns) * u64::from(samples);
        let casts = if lights <= FEW_LIGHTS { lights } else { 1 };
        cx.counts().rays += u64::from(turns) * u64::from(samples * casts);
        let mut key = scene
            .shader("indirect/light_volumes/radiosity/first_bounce.wgsl", "main")
            .def("RAYS", ShaderDef::Uint(rays.count));
        if (1..=FEW_LIGHTS).contains(&lights) {
            key = key.def("LIGHTS", ShaderDef::Uint(lights));
        }
        let haze = lamps.map(|cells| cells.bindings(cx));
        key = HazeCells::defined(lamps.as_ref(), key);
        let surfels_a_submit = (cx.work_a_submit(RAYS_A_SUBMIT) / u64::from(samples)).max(64);
        for first in (0..turns).step_by(surfels_a_submit as usize) {
            let surfels_now = (turns - first).min(surfels_a_submit as u32);
            cx.work(u64::from(surfels_now) * u64::from(samples), RAYS_A_SUBMIT)?;
            let uniform = FirstBounceUniform {
                root: scene.root(),
                light_count: scene.light_count,
                seed: rays.seed ^ 0x1656_67b1,
                first: first * turn.parts + turn.part,
                parts: turn.parts,
            };
            let uniform = cx.gpu.uniform("first_bounce", &uniform);
            let mut group = vec![
                ("first_bounce", Binding::Buffer(&uniform)),
                ("surfel_links", Binding::Buffer(&links)),
                ("reflected_light", Binding::Buffer(&reflected)),
            ];
            group.extend(haze.iter().flatten().map(|(name, buffer)| (*name, Binding::Buffer(buffer))));
            dispatch_rays(cx, &key, &group, scene, linear_groups(surfels_now))?;
        }
        Ok(())
    });
    reflected
}
