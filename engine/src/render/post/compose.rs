//! The sum of what each pixel shows, or one layer of it.

use crate::gpu::{Binding, ComputeKey, ShaderDef};
use crate::graph::{Graph, Handle, Texture, TextureDesc};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::GBuffer;
use crate::render::haze::Haze;
use crate::render::zero_texture::zero_texture;
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
    fn textures(&self) -> [Handle<Texture>; 3] {
        [self.reflected, self.gbuffer.normal, self.gbuffer.object]
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
    let mut pass = graph.pass(name);
    let inputs = [gbuffer.base_color, gbuffer.normal, gbuffer.emissive, gbuffer.depth];
    let read = [lights.direct, lights.indirect, lights.mirrored, lights.sky, lights.blended, lights.particles];
    inputs.into_iter().chain(read.into_iter().flatten()).for_each(|input| pass.read(input));
    lights.haze.iter().for_each(|haze| pass.read(haze.buffer()));
    lights.second_lobe.iter().flat_map(SecondLobe::textures).for_each(|input| pass.read(input));
    let radiance = pass.write(radiance);
    let sky = frame.scene.sky;
    let map = frame.scene.sky_map.as_deref();
    let sky_turn = map.map_or(0.0, |map| map.turn);
    let has_map = map.is_some();
    let disc = frame.scene.sun_disc;
    let sun = disc.map_or([0.0; 3], |sun| sun.radiance.to_array());
    let toward = disc.map_or([0.0; 3], |sun| sun.toward.to_array());
    let cosine = disc.map_or(2.0, |sun| sun.half_angle.cos());
    let layer = frame.settings.only.index();
    pass.key(&(
        sky.to_array().map(f32::to_bits),
        map.map(|map| map.id),
        (sun.map(f32::to_bits), toward.map(f32::to_bits), cosine.to_bits()),
        layer,
        frame.view_key(),
        read.map(|light| light.is_some()),
        lights.second_lobe.is_some(),
    ));
    pass.key(&lights.haze.map(|haze| (haze.key(), frame.media_key())));
    let frame = frame.clone();
    pass.execute(move |cx| {
        let gpu = cx.gpu;
        let [base_color, normal, emissive, depth] = inputs.map(|handle| cx.view(handle));
        let direct = lights.direct.map_or_else(|| zero_texture(gpu, 3), |handle| cx.view(handle));
        let indirect = lights.indirect.map_or_else(|| zero_texture(gpu, 1), |handle| cx.view(handle));
        let mirrored = lights.mirrored.map_or_else(|| zero_texture(gpu, 1), |handle| cx.view(handle));
        let second_lobe = lights.second_lobe.map(|lobe| lobe.textures().map(|handle| cx.view(handle)));
        let sky_light = lights.sky.map_or_else(|| zero_texture(gpu, 1), |handle| cx.view(handle));
        let blended = lights.blended.map_or_else(|| zero_texture(gpu, 1), |handle| cx.view(handle));
        let particles = lights.particles.map(|handle| cx.view(handle));
        let target = cx.view(radiance);
        let (sun_toward, sun_radiance) = (toward.into(), sun.into());
        let uniform = ComposeUniform { sky, sky_turn, sun_toward, sun_cosine: cosine, sun_radiance };
        cx.counts().texels += u64::from(width) * u64::from(height);
        let mut key = ComputeKey::new("post/compose.wgsl", "main").def("LAYER", ShaderDef::Uint(layer));
        if has_map {
            key = key.def("SKY_MAP", ShaderDef::Flag(true));
        }
        let haze = lights.haze.map(|haze| haze.bindings(cx, &frame)).unwrap_or_default();
        for (name, value) in lights.haze.iter().flat_map(|_| Haze::defines(&frame)) {
            key = key.def(name, value);
        }
        let (view, uniform) = (frame.view_uniform(gpu), gpu.uniform("compose", &uniform));
        let mut group = vec![
            ("view", Binding::Buffer(&view)),
            ("compose", Binding::Buffer(&uniform)),
            ("base_color", Binding::Texture(&base_color)),
            ("normal", Binding::Texture(&normal)),
            ("emissive", Binding::Texture(&emissive)),
            ("depth", Binding::Texture(&depth)),
            ("direct", Binding::Texture(&direct)),
            ("indirect", Binding::Texture(&indirect)),
            ("mirrored", Binding::Texture(&mirrored)),
            ("sky_light", Binding::Texture(&sky_light)),
            ("blended", Binding::Texture(&blended)),
            ("sky", Binding::Texture(frame.gpu_scene.sky())),
            ("radiance", Binding::Texture(&target)),
        ];
        if let Some(textures) = &second_lobe {
            key = key.def("SECOND_LOBE", ShaderDef::Flag(true));
            let names = ["second_lobe", "lobe_normal", "lobe_object"];
            group.extend(names.into_iter().zip(textures).map(|(name, view)| (name, Binding::Texture(view))));
        }
        if let Some(particles) = &particles {
            key = key.def("PARTICLES", ShaderDef::Flag(true));
            group.push(("particles", Binding::Texture(particles)));
        }
        group.extend(haze.iter().map(|(name, buffer)| (*name, Binding::Buffer(buffer))));
        cx.dispatch(&key, &group, [width.div_ceil(8), height.div_ceil(8), 1])
    });
    radiance
}
