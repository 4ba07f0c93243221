//! How much of a light with a surface arrives at each pixel, by shadow rays. See `direct/area_shadows.wgsl`.

use super::{DirectLight, Region, area_tiles};
use crate::gpu::{Binding, ShaderDef};
use crate::graph::{Buffer, Graph, Handle, PassContext, PassError, Texture};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::GBuffer;
use crate::render::rays::{RayScene, dispatch_rays};
use crate::render::scene_gpu::light_uniform::LightUniform;
use encase::ShaderType;
use glam::UVec2;

/// Shadow rays of a pixel of an image that stands by itself: with the filter over 4×4 pixels that is 64 points of the light.
const SAMPLES: u32 = 4;
/// The same in a window, whose frames are averaged.
const SAMPLES_OF_MANY: u32 = 2;
/// Rays of one submit.
const RAYS_A_SUBMIT: u64 = 1 << 18;

/// `Shadows` of `direct/area_shadows.wgsl`.
#[derive(ShaderType)]
pub(crate) struct ShadowsUniform {
    origin: UVec2,
    size: UVec2,
    root: u32,
    seed: u32,
}

/// What arrives of a light.
#[derive(Clone, Copy)]
pub(super) struct Shadows {
    /// Sums of samples with and without shadows, diffuse and specular.
    pub(super) arrived: Handle<Texture>,
    /// Which kinds of samples there are in each tile.
    pub(super) tiles: Handle<Buffer>,
    /// Radius of the filter over them \[pixels\]: less where images are averaged.
    pub(super) radius: u32,
}

fn radius(frame: &Frame) -> u32 {
    let is_single = frame.number().is_none();
    match frame.images() {
        64.. if is_single => 0,
        8.. if is_single => 1,
        _ => 2,
    }
}

/// Declares the passes of a light.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    direct_light: &DirectLight<'a>,
) -> Shadows {
    let name = |what: &str| gbuffer.surfaces.name(&format!("{what} {}", direct_light.light.pass_name()));
    let inputs = [gbuffer.base_color, gbuffer.normal, gbuffer.object, gbuffer.depth];
    let work = |output, before| {
        let samples = if frame.number().is_some() { SAMPLES_OF_MANY } else { SAMPLES };
        Work { frame: frame.clone(), direct_light: direct_light.clone(), inputs, before, output, samples }
    };
    let first = graph.texture(name("direct first shadow rays"), frame.image_desc());
    let first = work(first, None).declare(graph, name("direct first shadow rays"));
    let tiles = area_tiles::declare(graph, frame, first, direct_light, &name("direct shadow tiles"));
    let arrived = graph.retained_texture(name("direct shadow rays"), frame.image_desc());
    let arrived = work(arrived, Some((first, tiles))).declare(graph, name("direct shadow rays"));
    Shadows { arrived, tiles, radius: radius(frame) }
}

/// Shadow rays: the first of each pixel, or those that follow where they are needed.
struct Work<'a> {
    frame: Frame<'a>,
    direct_light: DirectLight<'a>,
    inputs: [Handle<Texture>; 4],
    /// What the first found.
    before: Option<(Handle<Texture>, Handle<Buffer>)>,
    output: Handle<Texture>,
    samples: u32,
}

impl<'a> Work<'a> {
    fn declare(mut self, graph: &mut Graph<'a>, name: String) -> Handle<Texture> {
        let mut pass = graph.pass(name);
        self.inputs.into_iter().for_each(|input| pass.read(input));
        if let Some((samples, tiles)) = self.before {
            pass.read(samples);
            pass.read(tiles);
        }
        self.output = pass.write(self.output);
        let (output, frame) = (self.output, &self.frame);
        let light = self.direct_light.light;
        pass.key(&(
            frame.geometry_key(),
            frame.media_key(),
            light.revision,
            frame.view_key(),
            frame.seed(),
            self.samples,
        ));
        pass.execute(move |cx| self.run(cx));
        output
    }
}

impl Work<'_> {
    fn run(&self, cx: &mut PassContext) -> Result<(), PassError> {
        let scene =
            self.frame.shadow_rays.ok_or_else(|| PassError::message("the scene is not ready for rays".to_owned()))?;
        let Region { origin, size } = self.direct_light.region;
        // At most: tiles whose first rays agree need no more.
        let rays = if self.before.is_some() { self.samples - 1 } else { 1 };
        let rays_a_row = u64::from(size.x) * u64::from(rays);
        cx.counts().texels += u64::from(size.x) * u64::from(size.y);
        cx.counts().rays += rays_a_row * u64::from(size.y);
        // Whole workgroups, eight rows high.
        let step = (cx.work_a_submit(RAYS_A_SUBMIT) / rays_a_row / 8).clamp(1, 1 << 16) as usize * 8;
        for first_row in (0..size.y).step_by(step) {
            let rows = (size.y - first_row).min(step as u32);
            cx.work(u64::from(rows) * rays_a_row, RAYS_A_SUBMIT)?;
            let part = Region { origin: origin + UVec2::new(0, first_row), size: UVec2::new(size.x, rows) };
            self.dispatch(cx, scene, part)?;
        }
        Ok(())
    }

    fn dispatch(&self, cx: &mut PassContext, scene: &RayScene, part: Region) -> Result<(), PassError> {
        let gpu = cx.gpu;
        let view = self.frame.view_uniform(gpu);
        let light = LightUniform::buffer(gpu, self.direct_light.light);
        let seed = self.frame.seed() ^ (self.direct_light.light.id.0 as u32).wrapping_mul(0x9e37_79b9);
        let uniform = ShadowsUniform { origin: part.origin, size: part.size, root: scene.root(), seed };
        let shadows = gpu.uniform("shadows", &uniform);
        let [base_color, normal, object, depth] = self.inputs.map(|handle| cx.view(handle));
        let target = cx.view(self.output);
        let mut group = vec![
            ("view", Binding::Buffer(&view)),
            ("light", Binding::Buffer(&light)),
            ("shadows", Binding::Buffer(&shadows)),
            ("base_color", Binding::Texture(&base_color)),
            ("normal", Binding::Texture(&normal)),
            ("object", Binding::Texture(&object)),
            ("depth", Binding::Texture(&depth)),
            ("arrived", Binding::Texture(&target)),
        ];
        let key = scene.shader("direct/area_shadows.wgsl", "main").def("SAMPLES", ShaderDef::Uint(self.samples));
        let groups = [part.size.x.div_ceil(8), part.size.y.div_ceil(8), 1];
        let Some((samples, tiles)) = self.before else { return dispatch_rays(cx, &key, &group, scene, groups) };
        let (samples, tiles) = (cx.view(samples), cx.buffer(tiles).clone());
        group.extend([("before", Binding::Texture(&samples)), ("tiles", Binding::Buffer(&tiles))]);
        dispatch_rays(cx, &key.def("FURTHER", ShaderDef::Flag(true)), &group, scene, groups)
    }
}
