//! The final gather: rays from the visible surfaces, to the light of patches. See `indirect/light_volumes/sweep/gather.wgsl`.

use super::gather_filter::{self, Gathered};
use super::gather_shift::{self, Seen};
use super::gather_upsample;
use super::haze_cells::HazeCells;
use super::interleave::{Interleave, InterleaveUniform};
use super::mirror;
use super::rsm_samples::{self, RsmSamples};
use super::strays::Strays;
use crate::gpu::{ComputeKey, ShaderDef};
use crate::graph::{Buffer, ComputeBuilder, Counts, Graph, Handle, PieceWork, Texture};
use crate::render::frame::{Frame, ViewUniform};
use crate::render::geometry::gbuffer::GBuffer;
use crate::render::rays::{RayScene, mirror_define};
use crate::world::{Bounces, Clpv, GatherRays, Quality, Transport};
use encase::ShaderType;
use glam::Vec3;

/// Most rays of a pixel: lavapipe ends all loops of a thread after 65,535 turns together, without a word, and a ray
/// takes some thousand of them in a large scene.
pub(super) const MAX_RAYS: u32 = 16;
/// Widest filter \[pixels\].
const MAX_FILTER: u32 = 32;
/// Most rays of all kinds of a gathered pixel that stands for four: 1.25 a pixel.
const RAYS_A_SQUARE: u32 = 5;
/// Rays that follow the first of a path: by chance far fewer do.
const MOST_OF_A_PATH: u32 = 64;
/// Rays of one submit: a submit of a second may cost the device on desktop drivers.
const RAYS_A_SUBMIT: u64 = 1 << 18;

/// Distance within which light is not known well enough [edges of a patch]. From there rays go on, which takes a bounce more
/// than was computed: only where all are counted.
const NEAR: f32 = 2.1;

/// `Gather` of `indirect/light_volumes/sweep/gather.wgsl`.
#[derive(ShaderType)]
pub(crate) struct GatherUniform {
    view: ViewUniform,
    sky: Vec3,
    sky_turn: f32,
    root: u32,
    light_count: u32,
    emitter_count: u32,
    seed: u32,
    first: u32,
    nearest: f32,
    points_low: Vec3,
    point_count: u32,
    points_high: Vec3,
    #[shader(align(16))]
    interleave: InterleaveUniform,
}

/// Declares the gather and its filter; the result is reflected radiance. `light` is that of the patches, if
/// more than one bounce counts and rays end in it, `haze` that in the air, if there are media. `shown` is the image that
/// takes its light from this one, if it is another.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    seen: Seen<'_, 'a>,
    shown: Option<Seen<'_, 'a>>,
    settings: &Clpv,
    (light, haze): (Option<Handle<Buffer>>, Option<HazeCells>),
    lit: Option<RsmSamples>,
    interleave: Interleave,
) -> Handle<Texture> {
    let Seen { frame, gbuffer } = seen;
    let gathered = Gathered {
        diffuse: graph.retained_texture("gathered diffuse", interleave.image_desc(frame)),
        specular: graph.retained_texture("gathered specular", interleave.image_desc(frame)),
    };
    let paths = paths(settings);
    let is_known_near = light.is_none() || settings.bounces != Bounces::Converged;
    let nearest = match paths {
        Some(_) => f32::MAX,
        None if is_known_near => 0.0,
        None => NEAR * frame.surfels.patch_size(),
    };
    let rays = Rays {
        frame: frame.clone(),
        gbuffer: *gbuffer,
        light,
        haze,
        nearest,
        paths,
        lit,
        rays: rays(frame, settings, interleave),
        points: points(settings, interleave),
        has_mirrors: mirror::rays(frame, settings, interleave.is_sparse()).is_some(),
        interleave,
    };
    let gathered = rays.clone().declare_gather(graph, gathered);
    let radius = filter_radius(settings, gathered_images(frame, settings, interleave));
    if shown.is_none() && !interleave.is_sparse() {
        return gather_filter::declare(graph, frame, gbuffer, gathered, interleave, radius);
    }
    let filtered = gather_filter::declare_apart(graph, frame, gbuffer, gathered, interleave, radius);
    let (indirect, strays) = match shown {
        Some(shown) => gather_shift::declare(graph, shown, seen, filtered),
        None => gather_upsample::declare(graph, frame, gbuffer, filtered, interleave),
    };
    let Seen { frame, gbuffer } = shown.unwrap_or(seen);
    let rays = Rays { frame: frame.clone(), gbuffer: *gbuffer, ..rays };
    rays.declare_strays(graph, strays, indirect)
}

/// The rays of the pixels of an image.
#[derive(Clone)]
struct Rays<'a> {
    frame: Frame<'a>,
    gbuffer: GBuffer,
    light: Option<Handle<Buffer>>,
    haze: Option<HazeCells>,
    /// Distance \[m\] from the beginning of a ray within which that is not known.
    nearest: f32,
    paths: Option<u32>,
    lit: Option<RsmSamples>,
    rays: u32,
    points: u32,
    /// Whether a pass of its own brings what smooth surfaces mirror.
    has_mirrors: bool,
    interleave: Interleave,
}

impl<'a> Rays<'a> {
    /// Begins a pass that casts them.
    fn begin<'g>(&self, graph: &'g mut Graph<'a>, name: &str, entry: &'static str) -> ComputeBuilder<'g, 'a> {
        let frame = &self.frame;
        let mut pass = graph.compute(name, ComputeKey::new("indirect/light_volumes/sweep/gather.wgsl", entry));
        frame.bind_rays(&mut pass);
        frame.bind_sky(&mut pass);
        self.gbuffer.bind(&mut pass);
        pass.define("RAYS", ShaderDef::Uint(self.rays));
        if let Some(haze) = &self.haze {
            haze.bind(&mut pass);
        }
        match self.light {
            Some(light) => {
                pass.read("patch_light", light);
                frame.bind_patches(&mut pass);
            }
            None => pass.flag("ONE_BOUNCE", true),
        }
        if self.has_mirrors {
            let (name, value) = mirror_define(mirror::are_smooth(frame));
            pass.define(name, value);
        }
        if let Some(further) = self.paths {
            pass.define("PATHS", ShaderDef::Uint(further));
        }
        if let Some(lit) = &self.lit {
            pass.define("POINTS", ShaderDef::Uint(self.points));
            pass.read("rsm_samples", lit.points);
        }
        pass
    }

    /// Declares the gather.
    fn declare_gather(self, graph: &mut Graph<'a>, gathered: Gathered) -> Gathered {
        let mut pass = self.begin(graph, "gather", "main");
        let diffuse = pass.write("diffuse", gathered.diffuse);
        let specular = pass.write("specular", gathered.specular);
        let [width, height] = self.interleave.texels();
        let pixels = u64::from(width) * u64::from(height);
        let rays = u64::from(self.rays * casts_a_ray(&self.frame) + self.points_cast());
        pass.count(Counts { paths: pixels * u64::from(self.rays), rays: pixels * rays, ..Counts::default() });
        let work = PieceWork { units: u64::from(width) * u64::from(self.rays), on_software: RAYS_A_SUBMIT };
        pass.dispatch_rows([width, height], work, "gather", move |rows| self.uniform(rows.first));
        Gathered { diffuse, specular }
    }

    /// Declares the rays of the pixels of a queue; the result is the image with their reflected radiance.
    fn declare_strays(self, graph: &mut Graph<'a>, strays: Strays, indirect: Handle<Texture>) -> Handle<Texture> {
        let mut pass = self.begin(graph, "gather strays", "strays");
        strays.bind(&mut pass);
        let indirect = pass.write("indirect", indirect);
        for (first, most) in strays.slices() {
            let mut step = pass.step("strays");
            step.uniform("gather", &self.uniform(first));
            step.work(u64::from(most * self.rays), RAYS_A_SUBMIT);
            strays.dispatch(step, first, most);
        }
        pass.finish();
        indirect
    }

    /// Shadow rays to points of lit surfaces.
    fn points_cast(&self) -> u32 {
        if self.lit.is_some() { self.points } else { 0 }
    }

    fn uniform(&self, first: u32) -> GatherUniform {
        let (scene, rays) = (self.frame.scene, self.frame.rays);
        GatherUniform {
            view: self.frame.view_values(),
            sky: scene.sky,
            sky_turn: scene.sky_map.as_ref().map_or(0.0, |map| map.turn),
            root: rays.map_or(0, RayScene::root),
            light_count: rays.map_or(0, |rays| rays.light_count),
            emitter_count: rays.map_or(0, |rays| rays.emitter_count),
            seed: self.frame.seed(),
            first,
            nearest: self.nearest,
            points_low: self.lit.map_or(Vec3::ZERO, |lit| lit.reach.min),
            point_count: rsm_samples::POINTS,
            points_high: self.lit.map_or(Vec3::ZERO, |lit| lit.reach.max),
            interleave: self.interleave.uniform(),
        }
    }
}

/// How many whole images the rays in the mean amount to that a frame is for. Sparse frames cast a part of the rays.
fn gathered_images(frame: &Frame, settings: &Clpv, interleave: Interleave) -> f32 {
    let images = frame.images().max(1) as f32;
    let share = rays(frame, settings, interleave) as f32 / wanted_rays(settings).max(1) as f32;
    1.0 + (images - 1.0) * share * interleave.share()
}

/// Radius of the filter \[pixels\] where so many images are averaged. Most of what a filter gets wrong lies at edges of the
/// light, where the squared error grows with its radius r; that of the noise of n images falls with 1/(n·r²). Their sum is
/// least for r ∝ n^(−1/3).
fn filter_radius(settings: &Clpv, images: f32) -> f32 {
    settings.gather_filter.min(MAX_FILTER) as f32 / images.max(1.0).cbrt()
}

/// Whether the light is gathered; else the reason is in the report.
pub(super) fn is_possible(graph: &mut Graph, frame: &Frame, settings: &Clpv) -> bool {
    match (is_wanted(settings), frame.refused_rays) {
        (false, _) => graph.skip("gather", "no rays are asked for: surfaces look the volumes up themselves"),
        (true, Some(why)) => graph.skip("gather", why),
        (true, None) => return true,
    }
    false
}

/// Whether rays are wanted.
pub(in crate::render) fn is_wanted(settings: &Clpv) -> bool {
    settings.transport == Transport::Sweep && wanted_rays(settings) > 0
}

/// Whether rays go on as paths.
pub(super) fn are_paths(settings: &Clpv) -> bool {
    paths(settings).is_some()
}

/// Rays of a path that may follow its first, if rays go on as paths.
fn paths(settings: &Clpv) -> Option<u32> {
    let further = match settings.bounces {
        Bounces::Converged => MOST_OF_A_PATH,
        Bounces::Count(count) => count.saturating_sub(1),
    };
    matches!(settings.gather_rays, GatherRays::Paths(_)).then_some(further)
}

/// Rays of a gathered pixel that are asked for.
pub(super) fn wanted_rays(settings: &Clpv) -> u32 {
    match (settings.gather_rays, settings.quality) {
        (GatherRays::Count(count) | GatherRays::Paths(count), _) => count.min(MAX_RAYS),
        (GatherRays::Auto, Quality::Low) => 0,
        (GatherRays::Auto, Quality::Medium) => 4,
        (GatherRays::Auto, Quality::High) => 8,
        (GatherRays::Auto, Quality::Ultra) => 16,
    }
}

/// Rays of a gathered pixel. One that stands for four has no more than [`RAYS_A_SQUARE`] allow: the mean over frames makes up
/// for them.
fn rays(frame: &Frame, settings: &Clpv, interleave: Interleave) -> u32 {
    let wanted = wanted_rays(settings);
    if !interleave.is_sparse() {
        return wanted;
    }
    let possible = (RAYS_A_SQUARE - points(settings, interleave)) / casts_a_ray(frame);
    wanted.min(possible.max(1))
}

/// Rays that are cast for each that gathers: itself, and those to a light, an emissive surface and the sky.
fn casts_a_ray(frame: &Frame) -> u32 {
    let (lights, emitters) = frame.rays.map_or((0, 0), |rays| (rays.light_count, rays.emitter_count));
    1 + [lights > 0, emitters > 0, frame.scene.sky_map.is_some()].map(u32::from).iter().sum::<u32>()
}

/// Points of lit surfaces that a gathered pixel samples.
pub(super) fn points(settings: &Clpv, interleave: Interleave) -> u32 {
    let wanted = match settings.gather_points {
        GatherRays::Auto => wanted_rays(settings).div_ceil(4),
        GatherRays::Count(count) | GatherRays::Paths(count) => count.min(MAX_RAYS),
    };
    if interleave.is_sparse() { wanted.min(1) } else { wanted }
}

/// What the volumes are swept with. Light that rays gather needs less: what the volumes get wrong is evened out over all that a
/// pixel sees, and where surfaces are nearer to each other than cells they are not looked up.
pub(in crate::render) fn quality_of_volumes(settings: &Clpv, is_gathered: bool) -> Quality {
    match settings.quality {
        quality if !is_gathered => quality,
        Quality::Low | Quality::Medium => Quality::Low,
        Quality::High => Quality::Medium,
        Quality::Ultra => Quality::High,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A radius of one pixel filters nothing, so it must not be reached by rounding.
    #[test]
    fn the_filter_narrows_with_every_image() {
        let radius = |images: f32| filter_radius(&Clpv::default(), images);
        assert_eq!(radius(1.0), 8.0);
        assert!((radius(8.0) - 4.0).abs() < 1e-5 && (radius(64.0) - 2.0).abs() < 1e-5);
        assert!((1..500).all(|images| radius(images as f32) > radius(images as f32 + 1.0)));
        assert!(radius(500.0) > 1.0);
    }
}
