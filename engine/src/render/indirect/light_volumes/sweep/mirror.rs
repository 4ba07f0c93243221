//! Mirror reflections: rays of their own for the specular lobes of smooth surfaces, of every pixel. See
//! `indirect/light_volumes/sweep/mirror.wgsl`.
//!
//! The gather has few rays, of which few follow a specular lobe, and evens out by its filter what they bring. Surfaces up to
//! a roughness of 0.25 show an image, which no filter may blur: theirs are the rays of this pass.

use super::gather;
use super::haze_cells::HazeCells;
use crate::gpu::{Binding, ShaderDef};
use crate::graph::{Graph, Handle, PassContext, PassError, Texture};
use crate::render::frame::{Frame, ViewUniform};
use crate::render::geometry::GBuffer;
use crate::render::indirect::Scattered;
use crate::render::rays::{RayScene, dispatch_rays};
use crate::render::surfaces::Surfaces;
use crate::world::{Clpv, GatherRays};
use encase::ShaderType;
use glam::Vec3;

/// Paths of one submit: each may be five rays and as many shadow rays.
const PATHS_A_SUBMIT: u64 = 1 << 16;

/// `Mirror` of `indirect/light_volumes/sweep/mirror.wgsl`.
#[derive(ShaderType)]
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
pub(in crate::render) struct Mirrors {
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
    mirrors: Mirrors,
) -> Handle<Texture> {
    let mirrored = graph.retained_texture(gbuffer.surfaces.name("mirrored radiance"), frame.image_desc());
    let mut pass = graph.pass(gbuffer.surfaces.name("mirror"));
    let inputs = [gbuffer.base_color, gbuffer.normal, gbuffer.object, gbuffer.depth];
    inputs.into_iter().for_each(|handle| pass.read(handle));
    light.handles().for_each(|light| pass.read(light));
    let mirrored = pass.write(mirrored);
    let most_rays = most_rays(frame, mirrors.rays);
    pass.key(&(
        mirrors.rays,
        most_rays,
        frame.seed(),
        frame.view_key(),
        light.patches.is_some(),
        frame.surfels.revision(),
    ));
    let revisions = &frame.scene.revisions;
    pass.key(&(frame.geometry_key(), revisions.lights, revisions.settings));
    pass.key(&(frame.media_key(), HazeCells::key(light.haze.as_ref())));
    let work = Work { frame: frame.clone(), surfaces: gbuffer.surfaces, inputs, light, mirrored, mirrors, most_rays };
    pass.execute(move |cx| work.run(cx));
    mirrored
}

struct Work<'a> {
    frame: Frame<'a>,
    surfaces: Surfaces,
    inputs: [Handle<Texture>; 4],
    light: Scattered,
    mirrored: Handle<Texture>,
    mirrors: Mirrors,
    most_rays: u32,
}

impl Work<'_> {
    fn run(&self, cx: &mut PassContext) -> Result<(), PassError> {
        let scene = self.frame.rays.ok_or_else(|| PassError::message("the scene is not ready for rays".to_owned()))?;
        let [width, height] = self.frame.view.size;
        cx.counts().texels += u64::from(width) * u64::from(height);
        let paths_a_row = u64::from(width) * u64::from(self.mirrors.rays);
        let rows_a_submit = cx.work_a_submit(PATHS_A_SUBMIT) / paths_a_row;
        // Whole workgroups, eight rows high.
        let step = (rows_a_submit / 8).clamp(1, 1 << 16) as usize * 8;
        for first_row in (0..height).step_by(step) {
            let rows = (height - first_row).min(step as u32);
            cx.work(u64::from(rows) * paths_a_row, PATHS_A_SUBMIT)?;
            self.dispatch(cx, scene, first_row, [width.div_ceil(8), rows.div_ceil(8), 1])?;
        }
        Ok(())
    }

    fn dispatch(
        &self,
        cx: &mut PassContext,
        scene: &RayScene,
        first_row: u32,
        groups: [u32; 3],
    ) -> Result<(), PassError> {
        let uniform = cx.gpu.uniform("mirror", &self.uniform(scene, first_row));
        let views = self.inputs.map(|handle| cx.view(handle));
        let target = cx.view(self.mirrored);
        let (name, value) = self.mirrors.define;
        let key = scene
            .shader("indirect/light_volumes/sweep/mirror.wgsl", "main")
            .def("RAYS", ShaderDef::Uint(self.mirrors.rays))
            .def("MOST_RAYS", ShaderDef::Uint(self.most_rays))
            .def(name, value);
        let key = self.surfaces.define(self.light.defined(&self.frame, key));
        let light = self.light.buffers(cx);
        let mut group = vec![("mirror", Binding::Buffer(&uniform)), ("mirrored", Binding::Texture(&target))];
        let names = ["base_color", "normal", "object", "depth"];
        group.extend(names.into_iter().zip(&views).map(|(name, view)| (name, Binding::Texture(view))));
        group.extend(self.light.bindings(&self.frame, &light));
        dispatch_rays(cx, &key, &group, scene, groups)
    }

    fn uniform(&self, rays: &RayScene, first_row: u32) -> MirrorUniform {
        let scene = self.frame.scene;
        MirrorUniform {
            view: self.frame.view_values(),
            sky: scene.sky,
            sky_turn: scene.sky_map.as_ref().map_or(0.0, |map| map.turn),
            root: rays.root(),
            light_count: rays.light_count,
            seed: self.frame.seed(),
            first_row,
            patch_size: self.frame.surfels.patch_size(),
        }
    }
}
