//! What second lobes reflect beside the lights, those of clear coats and stretched highlights: rays of their own for every pixel that
//! shows one, by the pass of mirrors, however rough they are.

use super::Scattered;
use super::light_volumes::sweep::{mirror, mirror_filter};
use super::mirror_average;
use crate::graph::{Graph, Handle, Texture};
use crate::render::frame::Frame;
use crate::render::geometry::GBuffer;
use crate::render::rays::all_mirror_define;

/// Rays of a pixel that reflects all light in an image that stands by itself; others have as much less as they reflect.
const RAYS: u32 = 8;
/// The same where images are averaged.
const RAYS_OF_MANY: u32 = 4;
/// The same in frames of a window.
const RAYS_OF_FRAMES: u32 = 1;

/// Declares the passes; the result is the radiance \[W/(m² sr)\] that second lobes reflect over their tint, none without rays.
pub(in crate::render) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    lobes: &GBuffer,
    light: Scattered,
) -> Option<Handle<Texture>> {
    let Some(scene) = frame.rays else {
        graph.skip(lobes.surfaces.name("mirror"), "the scene is not ready for rays");
        let warn = |why| format!("clear coats and stretched highlights reflect lights alone: {why}");
        frame.refused_rays.iter().for_each(|why| graph.warn(warn(why)));
        return None;
    };
    let rays = match frame.number() {
        Some(_) => RAYS_OF_FRAMES,
        None if frame.images() >= 4 => RAYS_OF_MANY,
        None => RAYS,
    };
    let mirrors = mirror::Mirrors { scene, rays, define: all_mirror_define() };
    let mirrored = mirror::declare(graph, frame, lobes, light, mirrors);
    let filtered = mirror_filter::declare(graph, frame, lobes, mirrored);
    Some(mirror_average::declare(graph, frame, lobes, filtered))
}
