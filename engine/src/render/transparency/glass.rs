//! Glass that the camera sees: what passes it, refracted, and what it reflects, by rays. See `transparency/glass.wgsl`.
//!
//! The pass runs over the rectangle of pixels around all glass. Without rays, where a scene does not fit the device, glass is
//! drawn like a blended surface, which what lies straight behind shows through.

use super::glass_depth;
use crate::gpu::{ComputeKey, ShaderDef};
use crate::graph::{Graph, Handle, PieceWork, Texture, TextureDesc};
use crate::render::direct::{Region, region_around};
use crate::render::frame::{Frame, ViewUniform};
use crate::render::indirect::Scattered;
use crate::render::indirect::light_volumes::sweep::mirror_filter::{self, InGlass};
use crate::render::rays::RayScene;
use encase::ShaderType;
use glam::{UVec2, Vec3};

/// Paths of one submit: each may be a dozen rays and as many shadow rays.
const PATHS_A_SUBMIT: u64 = 1 << 15;
/// Rays of a pixel through rough glass, in an image that stands by itself.
const RAYS: u32 = 8;
/// The same where images or frames are averaged.
const RAYS_OF_MANY: u32 = 2;

/// `SeenThrough` of `transparency/glass.wgsl`.
#[derive(Clone, Copy, ShaderType)]
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
    (region, rays): (Region, &'a RayScene),
) -> Handle<Texture> {
    let mask = glass_depth::declare(graph, frame);
    let seen = graph.retained_texture("seen through glass", frame.image_desc());
    let rough = TextureDesc { format: wgpu::TextureFormat::Rgba32Uint, ..frame.image_desc() };
    let rough = graph.retained_texture("rough glass", rough);
    let glow = graph.retained_texture("glow of glass", frame.image_desc());
    let rays_a_pixel = if frame.number().is_some() || frame.images() >= 4 { RAYS_OF_MANY } else { RAYS };
    let mut pass = graph.compute("glass", ComputeKey::new("transparency/glass.wgsl", "main"));
    rays.bind_all(&mut pass);
    pass.define("RAYS", ShaderDef::Uint(rays_a_pixel));
    pass.define("LAYER", ShaderDef::Uint(frame.settings.only.index()));
    light.bind(&mut pass, frame);
    pass.read("depth", depth);
    pass.read("mask", mask);
    pass.read("opaque_depth", depth);
    pass.read("opaque_radiance", opaque);
    let seen = InGlass {
        seen: pass.write("seen_through", seen),
        glow: pass.write("glow_at_glass", glow),
        rough: pass.write("rough_glass", rough),
    };
    let work = PieceWork { units: region.size.x.into(), on_software: PATHS_A_SUBMIT };
    let uniform = uniform(frame, rays);
    pass.dispatch_rows(region.size.into(), work, "glass", move |rows| SeenThroughUniform {
        origin: region.origin + UVec2::new(0, rows.first),
        size: UVec2::new(region.size.x, rows.count),
        ..uniform
    });
    mirror_filter::declare_through_glass(graph, frame, seen, region)
}

fn uniform(frame: &Frame, rays: &RayScene) -> SeenThroughUniform {
    let scene = frame.scene;
    SeenThroughUniform {
        view: frame.view_values(),
        sky: scene.sky,
        sky_turn: scene.sky_map.as_ref().map_or(0.0, |map| map.turn),
        origin: UVec2::ZERO,
        size: UVec2::ZERO,
        root: rays.root(),
        light_count: rays.light_count,
        seed: frame.seed(),
        patch_size: frame.surfels.patch_size(),
    }
}
