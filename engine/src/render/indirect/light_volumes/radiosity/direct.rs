//! Light straight from the lights at surfels. See `indirect/light_volumes/radiosity/direct.wgsl`.

use crate::gpu::{Binding, ShaderDef};
use crate::graph::{Buffer, BufferDesc, Graph, Handle, PassError};
use crate::render::frame::{Frame, linear_groups};
use crate::render::indirect::path_tracer::dispatch_rays;
use encase::ShaderType;
use wgpu::BufferUsages;

/// Most lights that a surfel looks at: a patch has eight surfels, and what they choose differs.
const MOST_SAMPLES: u32 = 2;
/// Rays of one submit.
const RAYS_A_SUBMIT: u64 = 1 << 18;

/// `Direct` of `indirect/light_volumes/radiosity/direct.wgsl`.
#[derive(ShaderType)]
pub(crate) struct DirectUniform {
    root: u32,
    light_count: u32,
    seed: u32,
    first: u32,
}

/// Declares the irradiance of the surfels straight from the lights [W/m²].
pub(super) fn declare<'a>(graph: &mut Graph<'a>, frame: &Frame<'a>, surfels: Handle<Buffer>) -> Handle<Buffer> {
    let count = frame.surfels.count();
    let desc = BufferDesc::new(16 * u64::from(count), BufferUsages::STORAGE);
    let lit = graph.retained_buffer("direct light at surfels", desc);
    let mut pass = graph.pass("direct light at surfels");
    pass.read(surfels);
    let lit = pass.write(lit);
    pass.key(&(frame.geometry_key(), frame.scene.revisions.lights));
    let frame = frame.clone();
    pass.execute(move |cx| {
        let rays = frame.rays.ok_or_else(|| PassError::message("the scene is not ready for rays".to_owned()))?;
        let samples = rays.light_count.clamp(1, MOST_SAMPLES);
        let [surfels, lit] = [surfels, lit].map(|handle| cx.buffer(handle).clone());
        cx.counts().paths += u64::from(count) * u64::from(samples);
        let key = rays
            .shader("indirect/light_volumes/radiosity/direct.wgsl", "main")
            .def("SAMPLES", ShaderDef::Uint(samples));
        let surfels_a_submit = (cx.work_a_submit(RAYS_A_SUBMIT) / u64::from(samples)).max(64);
        for first in (0..count).step_by(surfels_a_submit as usize) {
            let surfels_now = (count - first).min(surfels_a_submit as u32);
            cx.work(u64::from(surfels_now) * u64::from(samples), RAYS_A_SUBMIT);
            let uniform =
                DirectUniform { root: rays.root(), light_count: rays.light_count, seed: 0x165_667b1, first };
            let uniform = cx.gpu.uniform("direct", &uniform);
            let group = [
                ("direct", Binding::Buffer(&uniform)),
                ("surfels", Binding::Buffer(&surfels)),
                ("lit", Binding::Buffer(&lit)),
            ];
            dispatch_rays(cx, &key, &group, rays, linear_groups(surfels_now))?;
        }
        Ok(())
    });
    lit
}
