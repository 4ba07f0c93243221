//! What surfels see. See `indirect/light_volumes/radiosity/links.wgsl`.

use crate::gpu::{Binding, ShaderDef};
use crate::graph::{Buffer, BufferDesc, Graph, Handle, PassContext, PassError};
use crate::render::frame::{Frame, linear_groups};
use crate::render::indirect::path_tracer::dispatch_rays;
use crate::render::rays::RayScene;
use encase::ShaderType;
use glam::Vec3;
use wgpu::BufferUsages;

/// Bytes of a link.
pub(super) const LINK_BYTES: u64 = 16;
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
    before: f32,
    far: f32,
}

/// The links of all surfels, and what shines on them.
#[derive(Clone, Copy)]
pub(super) struct Links {
    /// Those of a surfel follow each other.
    pub links: Handle<Buffer>,
    /// Irradiance of each surfel from emissive surfaces and the sky [W/m²].
    pub shone_on: Handle<Buffer>,
}

/// Declares the links of the surfels, so many rays each.
pub(super) fn declare<'a>(graph: &mut Graph<'a>, frame: &Frame<'a>, surfels: Handle<Buffer>, rays: u32) -> Links {
    let count = frame.surfels.count();
    let buffer = |bytes: u64| BufferDesc::new(bytes * u64::from(count), BufferUsages::STORAGE);
    let links = graph.retained_buffer("links of surfels", buffer(LINK_BYTES * u64::from(rays)));
    let shone_on = graph.retained_buffer("emitted light at surfels", buffer(16));
    let mut pass = graph.pass("surfel links");
    pass.read(surfels);
    let found = Links { links: pass.write(links), shone_on: pass.write(shone_on) };
    let scene = frame.scene;
    pass.key(&(frame.geometry_key(), frame.surfels.revision(), scene.revisions.settings, rays));
    let frame = frame.clone();
    pass.execute(move |cx| {
        let scene = frame.rays.ok_or_else(|| PassError::message("the scene is not ready for rays".to_owned()))?;
        cx.counts().paths += u64::from(count) * u64::from(rays);
        let surfels_a_submit = (cx.work_a_submit(RAYS_A_SUBMIT) / u64::from(rays)).max(64);
        for first in (0..count).step_by(surfels_a_submit as usize) {
            let surfels_now = (count - first).min(surfels_a_submit as u32);
            cx.work(u64::from(surfels_now) * u64::from(rays), RAYS_A_SUBMIT);
            dispatch(cx, &frame, scene, (surfels, found), rays, [first, surfels_now])?;
        }
        Ok(())
    });
    found
}

fn dispatch(
    cx: &mut PassContext,
    frame: &Frame,
    rays: &RayScene,
    (surfels, found): (Handle<Buffer>, Links),
    count: u32,
    [first, surfels_now]: [u32; 2],
) -> Result<(), PassError> {
    let scene = frame.scene;
    let uniform = LinksUniform {
        sky: scene.sky,
        sky_turn: scene.sky_map.as_ref().map_or(0.0, |map| map.turn),
        root: rays.root(),
        emitter_count: rays.emitter_count,
        seed: 0x7f4a_7c15,
        first,
        before: frame.surfels.before(),
        far: frame.surfels.patch_size(),
    };
    let uniform = cx.gpu.uniform("links", &uniform);
    let [surfels, links, shone_on] = [surfels, found.links, found.shone_on].map(|handle| cx.buffer(handle).clone());
    let mut key = rays
        .shader("indirect/light_volumes/radiosity/links.wgsl", "main")
        .def("RAYS", ShaderDef::Uint(count));
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
    dispatch_rays(cx, &key, &group, rays, linear_groups(surfels_now))
}
