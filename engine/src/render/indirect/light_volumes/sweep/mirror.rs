//! Mirror reflections: rays of their own for the specular lobes of smooth surfaces, of every pixel. See
//! `indirect/light_volumes/sweep/mirror.wgsl`.
//!
//! The gather has few rays, of which few follow a specular lobe, and evens out by its filter what they bring. Surfaces up to
//! a roughness of 0.25 show an image, which no filter may blur: theirs are the rays of this pass.

use super::gather;
use crate::gpu::{ComputeKey, ShaderDef};
use crate::graph::{Graph, Handle, PieceWork, Texture};
use crate::render::frame::{Frame, ViewUniform};
use crate::render::geometry::GBuffer;
use crate::render::indirect::Scattered;
use crate::render::rays::RayScene;
use crate::world::{Clpv, GatherRays};
use encase::ShaderType;
use glam::Vec3;

/// Paths of one submit: each may be five rays and as many shadow rays.
const PATHS_A_SUBMIT: u64 = 1 << 16;

/// `Mirror` of `indirect/light_volumes/sweep/mirror.wgsl`.
#[derive(Clone, Copy, ShaderType)]
pub(crate) struct MirrorUniform {
    view: ViewUniform,
    sky: Vec3,
    sky_turn: f32,
    root: u32,
    light_count: u32,
    seed: u32,
    first_row: u32,
    patch_size: f32,
}

/// Most rays of a pixel, over the usual ones, of what is round: no other pixel sees the same there, and no filter helps.
const MORE: u32 = 4;

/// Rays of a pixel that mirrors; none: the gather's rays bring what mirrors show.
pub(super) fn rays(frame: &Frame, settings: &Clpv, is_sparse: bool) -> Option<u32> {
    let is_needed = frame.rays.is_some_and(RayScene::has_mirrors) && !gather::are_paths(settings);
    let wanted = match settings.mirror_rays {
        GatherRays::Auto | GatherRays::Paths(_) => gather::wanted_rays(settings),
        GatherRays::Count(count) => count.min(gather::MAX_RAYS),
    };
    (is_needed && wanted > 0).then_some(if is_sparse { 1 } else { wanted })
}

/// Whether smooth surfaces alone have rays of their own, in windows of those that reflect more diffusely.
pub(super) fn are_smooth(frame: &Frame) -> bool {
    frame.number().is_some() || frame.rays.is_some_and(|rays| rays.emitter_count > 0)
}

/// Most rays of a pixel. In a mean of images those of the others make up for few.
fn most_rays(frame: &Frame, rays: u32) -> u32 {
    let stands_alone = frame.number().is_none() && frame.images() < 4;
    if stands_alone { (MORE * rays).min(gather::MAX_RAYS).max(rays) } else { rays }
}

/// What is traced.
#[derive(Clone, Copy)]
pub(in crate::render) struct Mirrors<'a> {
    /// What the rays meet.
    pub scene: &'a RayScene,
    /// Rays of a pixel that reflects by its specular lobe alone, where others see the same.
    pub rays: u32,
    /// Which surfaces mirror: those up to a roughness, by [`mirror_define`](crate::render::rays::mirror_define) or
    /// [`all_mirror_define`](crate::render::rays::all_mirror_define).
    pub define: (&'static str, ShaderDef),
}

/// Declares the pass; the result is the radiance \[W/(m² sr)\] that mirrors reflect, with the distance \[m\] of what they
/// show.
pub(in crate::render) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    light: Scattered,
    mirrors: Mirrors<'a>,
) -> Handle<Texture> {
    let mirrored = graph.retained_texture(gbuffer.surfaces.name("mirrored radiance"), frame.image_desc());
    let shader = ComputeKey::new("indirect/light_volumes/sweep/mirror.wgsl", "main");
    let mut pass = graph.compute(gbuffer.surfaces.name("mirror"), shader);
    mirrors.scene.bind_all(&mut pass);
    pass.define("RAYS", ShaderDef::Uint(mirrors.rays));
    pass.define("MOST_RAYS", ShaderDef::Uint(most_rays(frame, mirrors.rays)));
    let (name, value) = mirrors.define;
    pass.define(name, value);
    light.bind(&mut pass, frame);
    gbuffer.surfaces.define_for(&mut pass);
    gbuffer.bind(&mut pass);
    let mirrored = pass.write("mirrored", mirrored);
    let [width, height] = frame.view.size;
    let work = PieceWork { units: u64::from(width) * u64::from(mirrors.rays), on_software: PATHS_A_SUBMIT };
    let uniform = uniform(frame, mirrors.scene);
    pass.dispatch_rows([width, height], work, "mirror", move |rows| MirrorUniform { first_row: rows.first, ..uniform });
    mirrored
}

fn uniform(frame: &Frame, rays: &RayScene) -> MirrorUniform {
    let scene = frame.scene;
    MirrorUniform {
        view: frame.view_values(),
        sky: scene.sky,
        sky_turn: scene.sky_map.as_ref().map_or(0.0, |map| map.turn),
        root: rays.root(),
        light_count: rays.light_count,
        seed: frame.seed(),
        first_row: 0,
        patch_size: frame.surfels.patch_size(),
    }
}
