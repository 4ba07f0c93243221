//! Glass that the camera sees: what passes it, refracted, and what it reflects, by rays. See `transparency/glass.wgsl`.
//!
//! The pass runs over the rectangle of pixels around all glass. Without rays, where a scene does not fit the device, glass is
//! drawn like a blended surface, which what lies straight behind shows through.

use super::glass_depth;
use crate::gpu::{Binding, ShaderDef};
use crate::graph::{Graph, Handle, PassContext, PassError, Texture, TextureDesc};
use crate::render::direct::{Region, region_around};
use crate::render::frame::{Frame, ViewUniform};
use crate::render::indirect::Scattered;
use crate::render::indirect::light_volumes::sweep::HazeCells;
use crate::render::indirect::light_volumes::sweep::mirror_filter::{self, InGlass};
use crate::render::rays::{RayScene, dispatch_rays};
use encase::ShaderType;
use glam::{UVec2, Vec3};

/// Paths of one submit: each may be a dozen rays and as many shadow rays.
const PATHS_A_SUBMIT: u64 = 1 << 15;
/// Rays of a pixel through rough glass, in an image that stands by itself.
const RAYS: u32 = 8;
/// The same where images or frames are averaged.
const RAYS_OF_MANY: u32 = 2;

/// `SeenThrough` of `transparency/glass.wgsl`.
#[derive(ShaderType)]
pub(crate) struct SeenThroughUniform {
    view: ViewUniform,
    sky: Vec3,
    sky_turn: f32,
    origin: UVec2,
    size: UVec2,
    root: u32,
    light_count: u32,
    seed: u32,
    patch_size: f32,
}

/// The pixels that may show glass; none, with the reason in the report, where there are none or no rays.
pub(in crate::render) fn region(graph: &mut Graph, frame: &Frame) -> Option<Region> {
    if !frame.gpu_scene.has_glass() {
        graph.skip("glass", "no surface is of glass");
    } else if !frame.settings.only.is_light() {
        graph.skip("glass", "the layer that is shown holds no glass");
    } else if let Some(why) = frame.refused_rays {
        graph.skip("glass", "the scene does not fit the device as rays need it");
        graph.warn(format!("glass does not refract: {why}"));
    } else if let Some(region) = frame.shadow_rays.and_then(|rays| region_around(rays.glass_bounds(), frame.view)) {
        return Some(region);
    } else {
        graph.skip("glass", "no glass is in view");
    }
    None
}

/// Declares the pass. The result is the radiance \[W/(m² sr)\] that is seen through the nearest glass of each pixel and in it, and
/// how far that is from the near plane \[m\], 0 for none; outside of the region it is not defined. `opaque` is the radiance of all
/// opaque surfaces.
pub(in crate::render) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    depth: Handle<Texture>,
    opaque: Handle<Texture>,
    light: Scattered,
    region: Region,
) -> Handle<Texture> {
    let mask = glass_depth::declare(graph, frame);
    let seen = graph.retained_texture("seen through glass", frame.image_desc());
    let rough = TextureDesc { format: wgpu::TextureFormat::Rgba32Uint, ..frame.image_desc() };
    let rough = graph.retained_texture("rough glass", rough);
    let glow = graph.retained_texture("glow of glass", frame.image_desc());
    let mut pass = graph.pass("glass");
    [depth, mask, opaque].into_iter().for_each(|input| pass.read(input));
    light.handles().for_each(|light| pass.read(light));
    let seen = InGlass { seen: pass.write(seen), glow: pass.write(glow), rough: pass.write(rough) };
    let rays = if frame.number().is_some() || frame.images() >= 4 { RAYS_OF_MANY } else { RAYS };
    let revisions = &frame.scene.revisions;
    pass.key(&(rays, frame.seed(), frame.view_key(), light.patches.is_some(), frame.surfels.revision()));
    pass.key(&(frame.geometry_key(), revisions.lights, revisions.settings, frame.settings.only));
    pass.key(&(frame.media_key(), HazeCells::key(light.haze.as_ref())));
    let work = Work { frame: frame.clone(), depth, mask, opaque, light, seen, region, rays };
    pass.execute(move |cx| work.run(cx));
    mirror_filter::declare_through_glass(graph, frame, seen, region)
}

struct Work<'a> {
    frame: Frame<'a>,
    depth: Handle<Texture>,
    mask: Handle<Texture>,
    opaque: Handle<Texture>,
    light: Scattered,
    seen: InGlass,
    region: Region,
    rays: u32,
}

impl Work<'_> {
    fn run(&self, cx: &mut PassContext) -> Result<(), PassError> {
        let scene =
            self.frame.shadow_rays.ok_or_else(|| PassError::message("the scene is not ready for rays".to_owned()))?;
        let Region { origin, size } = self.region;
        cx.counts().texels += u64::from(size.x) * u64::from(size.y);
        let paths_a_row = u64::from(size.x);
        // Whole workgroups, eight rows high.
        let step = (cx.work_a_submit(PATHS_A_SUBMIT) / paths_a_row / 8).clamp(1, 1 << 16) as usize * 8;
        for first_row in (0..size.y).step_by(step) {
            let rows = (size.y - first_row).min(step as u32);
            cx.work(u64::from(rows) * paths_a_row, PATHS_A_SUBMIT)?;
            let part = Region { origin: origin + UVec2::new(0, first_row), size: UVec2::new(size.x, rows) };
            self.dispatch(cx, scene, part)?;
        }
        Ok(())
    }

    fn dispatch(&self, cx: &mut PassContext, scene: &RayScene, part: Region) -> Result<(), PassError> {
        let uniform = cx.gpu.uniform("glass", &self.uniform(scene, part));
        let InGlass { seen, glow, rough } = self.seen;
        let targets = [seen, glow, rough].map(|handle| cx.view(handle));
        let [depth, mask, opaque] = [self.depth, self.mask, self.opaque].map(|handle| cx.view(handle));
        let key = scene
            .shader("transparency/glass.wgsl", "main")
            .def("RAYS", ShaderDef::Uint(self.rays))
            .def("LAYER", ShaderDef::Uint(self.frame.settings.only.index()));
        let key = self.light.defined(&self.frame, key);
        let light = self.light.buffers(cx);
        let mut group = vec![
            ("glass", Binding::Buffer(&uniform)),
            ("seen_through", Binding::Texture(&targets[0])),
            ("glow_at_glass", Binding::Texture(&targets[1])),
            ("rough_glass", Binding::Texture(&targets[2])),
            ("depth", Binding::Texture(&depth)),
            ("mask", Binding::Texture(&mask)),
            ("opaque_depth", Binding::Texture(&depth)),
            ("opaque_radiance", Binding::Texture(&opaque)),
        ];
        group.extend(self.light.bindings(&self.frame, &light));
        let groups = [part.size.x.div_ceil(8), part.size.y.div_ceil(8), 1];
        dispatch_rays(cx, &key, &group, scene, groups)
    }

    fn uniform(&self, rays: &RayScene, part: Region) -> SeenThroughUniform {
        let scene = self.frame.scene;
        SeenThroughUniform {
            view: self.frame.view_values(),
            sky: scene.sky,
            sky_turn: scene.sky_map.as_ref().map_or(0.0, |map| map.turn),
            origin: part.origin,
            size: part.size,
            root: rays.root(),
            light_count: rays.light_count,
            seed: self.frame.seed(),
            patch_size: self.frame.surfels.patch_size(),
        }
    }
}
