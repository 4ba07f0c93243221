//! The sum of what each pixel shows, or one layer of it.

use crate::gpu::{ComputeKey, ShaderDef};
use crate::graph::{Graph, Handle, PassBindings, Texture, TextureDesc, Tracked};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::GBuffer;
use crate::render::haze::Haze;
use crate::render::zero_texture::zero_texture;
use crate::scene::Scene;
use encase::ShaderType;
use glam::Vec3;

/// Name of the retained image of linear radiance.
pub const RADIANCE: &str = "radiance";

/// `Compose` of `post/compose.wgsl`.
#[derive(ShaderType)]
pub(crate) struct ComposeUniform {
    sky: Vec3,
    sky_turn: f32,
    sun_toward: Vec3,
    sun_cosine: f32,
    sun_radiance: Vec3,
}

impl ComposeUniform {
    fn of(scene: &Scene) -> Self {
        let sun = scene.sun_disc;
        Self {
            sky: scene.sky,
            sky_turn: scene.sky_map.as_deref().map_or(0.0, |map| map.turn),
            sun_toward: sun.map_or(Vec3::ZERO, |sun| sun.toward),
            sun_cosine: sun.map_or(2.0, |sun| sun.half_angle.cos()),
            sun_radiance: sun.map_or(Vec3::ZERO, |sun| sun.radiance),
        }
    }
}

/// The image of the sky, if it has one.
fn bind_sky<'a>(pass: &mut PassBindings<'_, 'a>, frame: &Frame<'a>) {
    let map = frame.scene.sky_map.as_deref();
    if map.is_some() {
        pass.define("SKY_MAP", ShaderDef::Flag(true));
    }
    pass.tracked("sky", Tracked::texture(frame.gpu_scene.sky(), &map.map(|map| map.id)));
}

/// Light that the layer is made of; what is missing counts as zero.
#[derive(Clone, Copy, Default)]
pub(in crate::render) struct Lights {
    /// Radiance from the direct passes, channels as layers.
    pub direct: Option<Handle<Texture>>,
    /// Radiance from the indirect method.
    pub indirect: Option<Handle<Texture>>,
    /// Radiance that mirrors reflect, where that is no part of `indirect`.
    pub mirrored: Option<Handle<Texture>>,
    /// What second lobes reflect beside the lights.
    pub second_lobe: Option<SecondLobe>,
    /// Radiance from the sky, where the indirect method has none of it.
    pub sky: Option<Handle<Texture>>,
    /// Blended surfaces: premultiplied radiance, and how much they hide of what lies behind.
    pub blended: Option<Handle<Texture>>,
    /// Particles: premultiplied radiance, and how much they hide of what lies behind.
    pub particles: Option<Handle<Texture>>,
    /// What media scatter on the way to the eye.
    pub haze: Option<Haze>,
}

/// Reflections of second lobes.
#[derive(Clone, Copy)]
pub(in crate::render) struct SecondLobe {
    /// Radiance \[W/(m² sr)\] over the tint of the lobes, see `tint_of_lobe` of `lib/layers.wgsl`.
    pub reflected: Handle<Texture>,
    /// Their G-buffer.
    pub gbuffer: GBuffer,
}

impl SecondLobe {
    fn bind(&self, pass: &mut PassBindings) {
        pass.define("SECOND_LOBE", ShaderDef::Flag(true));
        pass.read("second_lobe", self.reflected);
        pass.read("lobe_normal", self.gbuffer.normal);
        pass.read("lobe_object", self.gbuffer.object);
    }
}

/// What an image of radiance is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::render) enum Purpose {
    /// It is that of the frame.
    Final,
    /// The lens blurs it.
    Sharp,
    /// Glass shows parts of it.
    Opaque,
}

/// Declares the pass; the result is rgba32float radiance [W/(m² sr)].
pub(in crate::render) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    lights: Lights,
    purpose: Purpose,
) -> Handle<Texture> {
    let [width, height] = frame.view.size;
    let mut usage = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING;
    if frame.settings.particle_paths > 0 {
        usage |= wgpu::TextureUsages::RENDER_ATTACHMENT;
    }
    let desc = TextureDesc::d2(width, height, wgpu::TextureFormat::Rgba32Float, usage);
    let (radiance, name) = match purpose {
        Purpose::Final => (graph.retained_texture(RADIANCE, desc), "compose"),
        Purpose::Sharp => (graph.texture("sharp radiance", desc), "compose"),
        Purpose::Opaque => (graph.texture("opaque radiance", desc), "compose opaque"),
    };
    let mut pass = graph.compute(name, ComputeKey::new("post/compose.wgsl", "main"));
    pass.define("LAYER", ShaderDef::Uint(frame.settings.only.index()));
    frame.bind_view(&mut pass);
    pass.uniform("compose", &ComposeUniform::of(frame.scene));
    bind_sky(&mut pass, frame);
    pass.read("base_color", gbuffer.base_color);
    pass.read("normal", gbuffer.normal);
    pass.read("emissive", gbuffer.emissive);
    pass.read("depth", gbuffer.depth);
    match lights.direct {
        Some(direct) => pass.read("direct", direct),
        None => pass.stand_in("direct", |gpu| zero_texture(gpu, 3)),
    }
    let added = [
        ("indirect", lights.indirect),
        ("mirrored", lights.mirrored),
        ("sky_light", lights.sky),
        ("blended", lights.blended),
    ];
    for (name, light) in added {
        match light {
            Some(light) => pass.read(name, light),
            None => pass.stand_in(name, |gpu| zero_texture(gpu, 1)),
        }
    }
    if let Some(lobe) = &lights.second_lobe {
        lobe.bind(&mut pass);
    }
    if let Some(particles) = lights.particles {
        pass.define("PARTICLES", ShaderDef::Flag(true));
        pass.read("particles", particles);
    }
    if let Some(haze) = &lights.haze {
        haze.bind(&mut pass, frame);
    }
    let radiance = pass.write("radiance", radiance);
    pass.dispatch_over([width, height]);
    radiance
}
