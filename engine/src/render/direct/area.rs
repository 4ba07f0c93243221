//! Direct light of lights with a surface: what each would bring without shadows, from its outline, times the share of it that
//! arrives. See `direct/area.wgsl`.

use super::area_shadows::{self, Shadows};
use super::{DirectLight, Region, comparison_sampler, layered_view};
use crate::gpu::{Binding, ComputeKey, ShaderDef};
use crate::graph::{Graph, Handle, PassContext, PassError, Texture};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::GBuffer;
use crate::render::rays::{RayScene, dispatch_rays};
use crate::render::scene_gpu::light_uniform::LightUniform;
use crate::render::shadows::shadow_map::ShadowMap;
use encase::ShaderType;
use glam::UVec2;

/// Lobes as linearly transformed cosines, by `examples/fit_lobes.rs`: numbers of four little-endian bytes.
const LOBES: &[u8] = include_bytes!("lobes.bin");

/// `Area` of `direct/area.wgsl`.
#[derive(ShaderType)]
pub(crate) struct AreaUniform {
    origin: UVec2,
    size: UVec2,
    radius: u32,
    root: u32,
}

/// How it is found what of the light arrives.
enum Share {
    /// All of it.
    Whole,
    /// By rays to its surface.
    Rays(Shadows),
    /// By the shadow map of its middle.
    Map(ShadowMap),
}

/// Declares the passes of a light, which add to the radiance.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    radiance: Handle<Texture>,
    direct_light: DirectLight<'a>,
) -> Handle<Texture> {
    let share = match (&direct_light.shadow, frame.shadow_rays) {
        (None, Some(_)) if direct_light.may_be_filtered(frame) => {
            Share::Rays(area_shadows::declare(graph, frame, gbuffer, &direct_light))
        }
        (None, _) => Share::Whole,
        (Some(_), Some(_)) => Share::Rays(area_shadows::declare(graph, frame, gbuffer, &direct_light)),
        (Some(map), None) => Share::Map(map.clone()),
    };
    let mut pass = graph.pass(gbuffer.surfaces.name(&format!("direct {}", direct_light.light.pass_name())));
    let inputs = [gbuffer.base_color, gbuffer.normal, gbuffer.object, gbuffer.depth];
    inputs.into_iter().for_each(|input| pass.read(input));
    match &share {
        Share::Whole => {}
        Share::Rays(shadows) => {
            pass.read(shadows.arrived);
            pass.read(shadows.tiles);
        }
        Share::Map(shadow) => pass.read(shadow.map),
    }
    let radiance = pass.write(radiance);
    let kind = match &share {
        Share::Whole => 0,
        Share::Rays(shadows) => 1 + shadows.radius,
        Share::Map(_) => u32::MAX,
    };
    pass.key(&(frame.media_key(), direct_light.light.revision, kind, frame.view_key()));
    pass.key(&direct_light.may_be_filtered(frame).then(|| frame.geometry_key()));
    let work = Work { frame: frame.clone(), direct_light, share, inputs, radiance };
    pass.execute(move |cx| work.run(cx));
    radiance
}

struct Work<'a> {
    frame: Frame<'a>,
    direct_light: DirectLight<'a>,
    share: Share,
    inputs: [Handle<Texture>; 4],
    radiance: Handle<Texture>,
}

impl<'a> Work<'a> {
    /// The scene for rays, if glass may colour the light.
    fn glass(&self) -> Option<&'a RayScene> {
        self.frame.shadow_rays.filter(|_| self.direct_light.may_be_filtered(&self.frame))
    }

    fn run(&self, cx: &mut PassContext) -> Result<(), PassError> {
        let gpu = cx.gpu;
        let Region { origin, size } = self.direct_light.region;
        let counts = cx.counts();
        counts.lights += 1;
        counts.texels += u64::from(size.x) * u64::from(size.y);
        let [base_color, normal, object, depth] = self.inputs.map(|handle| cx.view(handle));
        let target = cx.view(self.radiance);
        let view = self.frame.view_uniform(gpu);
        let light = LightUniform::buffer(gpu, self.direct_light.light);
        let radius = if let Share::Rays(shadows) = &self.share { shadows.radius } else { 0 };
        let area =
            gpu.uniform("area", &AreaUniform { origin, size, radius, root: self.glass().map_or(0, RayScene::root) });
        let lobes = gpu.constants("lobes", LOBES);
        let mut group = vec![
            ("view", Binding::Buffer(&view)),
            ("light", Binding::Buffer(&light)),
            ("area", Binding::Buffer(&area)),
            ("base_color", Binding::Texture(&base_color)),
            ("normal", Binding::Texture(&normal)),
            ("object", Binding::Texture(&object)),
            ("depth", Binding::Texture(&depth)),
            ("lobes", Binding::Buffer(&lobes)),
            ("radiance", Binding::Texture(&target)),
        ];
        let media = self.frame.gpu_scene.media_binding(gpu);
        group.extend(media.iter().map(|(name, buffer)| (*name, Binding::Buffer(buffer))));
        let key = self.frame.gpu_scene.with_media(ComputeKey::new("direct/area.wgsl", "main"));
        let groups = [size.x.div_ceil(8), size.y.div_ceil(8), 1];
        match &self.share {
            Share::Whole => cx.dispatch(&key, &group, groups),
            Share::Rays(shadows) => {
                let (arrived, tiles) = (cx.view(shadows.arrived), cx.buffer(shadows.tiles).clone());
                group.extend([("arrived", Binding::Texture(&arrived)), ("tiles", Binding::Buffer(&tiles))]);
                let flag = ("SHADOW_RAYS", ShaderDef::Flag(true));
                match self.glass() {
                    Some(scene) => {
                        let key = scene.shader("direct/area.wgsl", "main").def(flag.0, flag.1);
                        let group: Vec<_> = group.into_iter().filter(|(name, _)| *name != "media").collect();
                        dispatch_rays(cx, &key, &group, scene, groups)
                    }
                    None => cx.dispatch(&key.def(flag.0, flag.1), &group, groups),
                }
            }
            Share::Map(shadow) => {
                let (uniform, map) =
                    (gpu.uniform("shadow", &shadow.uniform()), layered_view(gpu, cx.texture(shadow.map)));
                let sampler = comparison_sampler(gpu);
                group.extend([
                    ("shadow", Binding::Buffer(&uniform)),
                    ("shadow_map", Binding::Texture(&map)),
                    ("shadow_sampler", Binding::Sampler(&sampler)),
                ]);
                cx.dispatch(&key.def("SHADOW_MAP", ShaderDef::Flag(true)), &group, groups)
            }
        }
    }
}
