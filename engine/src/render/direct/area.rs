//! Direct light of lights with a surface: what each would bring without shadows, from its outline, times the share of it that
//! arrives. See `direct/area.wgsl`.

use super::area_shadows::{self, Shadows};
use super::{DirectLight, Region, comparison};
use crate::gpu::{ComputeKey, ShaderDef};
use crate::graph::{Counts, Graph, Handle, PassBindings, Texture};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::GBuffer;
use crate::render::rays::RayScene;
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
        (None, Some(rays)) if direct_light.may_be_filtered(frame) => {
            Share::Rays(area_shadows::declare(graph, frame, gbuffer, &direct_light, rays))
        }
        (None, _) => Share::Whole,
        (Some(_), Some(rays)) => Share::Rays(area_shadows::declare(graph, frame, gbuffer, &direct_light, rays)),
        (Some(map), None) => Share::Map(map.clone()),
    };
    let name = gbuffer.surfaces.name(&format!("direct {}", direct_light.light.pass_name()));
    // Glass may colour what comes by rays.
    let glass = frame.shadow_rays.filter(|_| direct_light.may_be_filtered(frame));
    let glass = glass.filter(|_| matches!(share, Share::Rays(_)));
    let mut pass = graph.compute(name, ComputeKey::new("direct/area.wgsl", "main"));
    match glass {
        Some(scene) => scene.bind_surfaces(&mut pass),
        None => frame.gpu_scene.bind_media(&mut pass),
    }
    let Region { origin, size } = direct_light.region;
    let (radius, root) = (share.radius(), glass.map_or(0, RayScene::root));
    frame.bind_view(&mut pass);
    pass.uniform("light", &LightUniform::new(direct_light.light));
    pass.uniform("area", &AreaUniform { origin, size, radius, root });
    pass.values_of("lobes", &(), || LOBES.to_vec());
    gbuffer.bind(&mut pass);
    share.bind(&mut pass);
    let radiance = pass.write("radiance", radiance);
    pass.count(Counts { lights: 1, ..Counts::default() });
    pass.dispatch_over(size.into());
    radiance
}

impl Share {
    /// Radius of the filter over shadow rays \[pixels\].
    fn radius(&self) -> u32 {
        if let Self::Rays(shadows) = self { shadows.radius } else { 0 }
    }

    fn bind(&self, pass: &mut PassBindings) {
        match self {
            Self::Whole => {}
            Self::Rays(shadows) => {
                pass.define("SHADOW_RAYS", ShaderDef::Flag(true));
                pass.read("arrived", shadows.arrived);
                pass.read("tiles", shadows.tiles);
            }
            Self::Map(shadow) => {
                pass.define("SHADOW_MAP", ShaderDef::Flag(true));
                pass.uniform("shadow", &shadow.uniform());
                pass.read_layers("shadow_map", shadow.map);
                pass.sampler("shadow_sampler", comparison());
            }
        }
    }
}
