//! How much of a light with a surface arrives at each pixel, by shadow rays. See `direct/area_shadows.wgsl`.

use super::{DirectLight, Region, area_tiles};
use crate::gpu::{ComputeKey, ShaderDef};
use crate::graph::{Buffer, Counts, Graph, Handle, PieceWork, Texture};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::GBuffer;
use crate::render::rays::RayScene;
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
    rays: &'a RayScene,
) -> Shadows {
    let name = |what: &str| gbuffer.surfaces.name(&format!("{what} {}", direct_light.light.pass_name()));
    let samples = if frame.number().is_some() { SAMPLES_OF_MANY } else { SAMPLES };
    let work = Work { frame, gbuffer, direct_light, rays, samples };
    let first = graph.texture(name("direct first shadow rays"), frame.image_desc());
    let first = work.declare(graph, name("direct first shadow rays"), first, None);
    let tiles = area_tiles::declare(graph, frame, first, direct_light, &name("direct shadow tiles"));
    let arrived = graph.retained_texture(name("direct shadow rays"), frame.image_desc());
    let arrived = work.declare(graph, name("direct shadow rays"), arrived, Some((first, tiles)));
    Shadows { arrived, tiles, radius: radius(frame) }
}

/// Shadow rays of a light.
struct Work<'w, 'a> {
    frame: &'w Frame<'a>,
    gbuffer: &'w GBuffer,
    direct_light: &'w DirectLight<'a>,
    rays: &'a RayScene,
    samples: u32,
}

impl<'a> Work<'_, 'a> {
    /// Declares the first rays of each pixel, or those that follow where they are needed after the first.
    fn declare(
        &self,
        graph: &mut Graph<'a>,
        name: String,
        output: Handle<Texture>,
        before: Option<(Handle<Texture>, Handle<Buffer>)>,
    ) -> Handle<Texture> {
        let Self { frame, rays, .. } = *self;
        let mut pass = graph.compute(name, ComputeKey::new("direct/area_shadows.wgsl", "main"));
        rays.bind_surfaces(&mut pass);
        pass.define("SAMPLES", ShaderDef::Uint(self.samples));
        frame.bind_view(&mut pass);
        pass.uniform("light", &LightUniform::new(self.direct_light.light));
        self.gbuffer.bind(&mut pass);
        if let Some((samples, tiles)) = before {
            pass.define("FURTHER", ShaderDef::Flag(true));
            pass.read("before", samples);
            pass.read("tiles", tiles);
        }
        let output = pass.write("arrived", output);
        let Region { origin, size } = self.direct_light.region;
        // At most: tiles whose first rays agree need no more.
        let rays_a_pixel = if before.is_some() { self.samples - 1 } else { 1 };
        let work = PieceWork { units: u64::from(size.x) * u64::from(rays_a_pixel), on_software: RAYS_A_SUBMIT };
        pass.count(Counts { rays: work.units * u64::from(size.y), ..Counts::default() });
        let seed = frame.seed() ^ (self.direct_light.light.id.0 as u32).wrapping_mul(0x9e37_79b9);
        let root = rays.root();
        pass.dispatch_rows(size.into(), work, "shadows", move |rows| ShadowsUniform {
            origin: origin + UVec2::new(0, rows.first),
            size: UVec2::new(size.x, rows.count),
            root,
            seed,
        });
        output
    }
}
