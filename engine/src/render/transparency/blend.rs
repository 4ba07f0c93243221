//! Blended surfaces: drawn forward, over what the deferred passes made, from the farthest to the nearest.
//!
//! Their direct light is that of the deferred pass, shadow maps included. Indirect light is that of the surface's own patches,
//! or where there are none it is looked up in the light volumes at the surface's place; methods that light pixels alone (virtual point lights, stochastic light culling)
//! lend one irradiance to all of them, the mean of what the visible surfaces receive. In the lights' own views a
//! blended surface is there where it is more than half opaque. Where alpha reaches 1 it is drawn with the opaque ones.

use crate::gpu::{Binding, Gpu, Pipeline, RasterKey, ShaderDef};
use crate::graph::{Buffer, Graph, Handle, PassContext, PassError, Texture, TextureDesc};
use crate::render::direct::{DirectLight, comparison_sampler, layered_view, no_shadow_map};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::{GBuffer, depth_state};
use crate::render::haze::Haze;
use crate::render::indirect::light_volumes::Field;
use crate::render::scene_gpu::light_uniform::LightUniform;
use crate::render::scene_gpu::{DrawFilter, MaterialClass, Side};
use crate::render::settings::Layer;
use crate::render::shadows::shadow_map::{ShadowMap, ShadowUniform};
use encase::ShaderType;
use std::array::from_fn;
use wgpu::{BlendComponent, BlendFactor, BlendOperation, BlendState, TextureFormat};

/// Lights of one draw: as many shadow maps fit beside the textures of a material.
const LIGHTS_A_DRAW: usize = 4;

/// Name of the retained identities of the blended surfaces.
pub const OBJECTS: &str = "blend object";

/// `Blend` of `transparency/blend.wgsl`.
#[derive(ShaderType)]
pub(crate) struct BlendUniform {
    lights: [LightUniform; LIGHTS_A_DRAW],
    shadows: [ShadowUniform; LIGHTS_A_DRAW],
    light_count: u32,
    is_first: u32,
    has_emission: u32,
    patch_size: f32,
}

/// Where the indirect light of blended surfaces comes from.
#[derive(Clone)]
pub(in crate::render) enum Source {
    /// Irradiance of the patches of surfels \[W/m²\].
    Patches(Handle<Buffer>),
    /// Volumes.
    Field(Box<Field>),
    /// One irradiance for all.
    Ambient(Handle<Buffer>),
}

/// What the pass finds of light but for the lamps.
pub(in crate::render) struct Behind {
    /// Where indirect light comes from.
    pub source: Option<Source>,
    /// Light in the air.
    pub haze: Option<Haze>,
    /// What is seen through glass, see [`glass`](super::glass).
    pub seen_through: Option<Handle<Texture>>,
}

/// Whether the view has blended surfaces; if not, the report says so.
pub fn is_needed(graph: &mut Graph, frame: &Frame) -> bool {
    let frustum = frame.frustum();
    if !frame.settings.only.is_light() {
        graph.skip("blend", "the layer that is shown holds no blended surfaces");
    } else if !frame.gpu_scene.any_blended(&filter_of(&frustum)) {
        graph.skip("blend", "no blended surface is in view");
    } else {
        return true;
    }
    false
}

fn filter_of(frustum: &crate::scene::Frustum) -> DrawFilter<'_> {
    DrawFilter::seen(frustum)
}

/// Declares the pass; the result is premultiplied radiance, and in alpha how much is hidden of what lies behind.
pub(in crate::render) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    gpu: &Gpu,
    direct_lights: Vec<DirectLight<'a>>,
    Behind { source, haze, seen_through }: Behind,
) -> Handle<Texture> {
    let [width, height] = frame.view.size;
    let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING;
    let color = graph.retained_texture("blend color", TextureDesc::d2(width, height, color_format(gpu), usage));
    let object = graph.retained_texture(OBJECTS, TextureDesc::d2(width, height, TextureFormat::R32Uint, usage));
    let mut pass = graph.pass("blend");
    let depth = gbuffer.depth;
    pass.read(depth);
    for shadow in direct_lights.iter().filter_map(|direct_light| direct_light.shadow.as_ref()) {
        pass.read(shadow.map);
    }
    match &source {
        Some(Source::Field(field)) => field.buffers().iter().for_each(|&buffer| pass.read(buffer)),
        Some(Source::Patches(light) | Source::Ambient(light)) => pass.read(*light),
        None => {}
    }
    haze.iter().for_each(|haze| pass.read(haze.buffer()));
    seen_through.iter().for_each(|&seen| pass.read(seen));
    let (color, object) = (pass.write(color), pass.write(object));
    let lights: Vec<_> =
        direct_lights.iter().map(|direct_light| (direct_light.light.revision, direct_light.shadow.is_some())).collect();
    let clpv = frame.scene.revisions.clpv;
    let only = frame.settings.only;
    pass.key(&(frame.geometry_key(), frame.view_key(), lights, clpv, frame.settings.gi, only));
    pass.key(&haze.map(|haze| (haze.key(), frame.media_key())));
    pass.key(&(seen_through.is_some(), frame.surfels.revision()));
    let work = Work { frame: frame.clone(), direct_lights, source, haze, seen_through, depth, color, object };
    pass.execute(move |cx| work.run(cx));
    color
}

/// Half floats where the adapter cannot blend whole ones: radiance above 65504 is cut off.
pub(super) fn color_format(gpu: &Gpu) -> TextureFormat {
    if gpu.features.contains(wgpu::Features::FLOAT32_BLENDABLE) {
        TextureFormat::Rgba32Float
    } else {
        TextureFormat::Rgba16Float
    }
}

struct Work<'a> {
    frame: Frame<'a>,
    direct_lights: Vec<DirectLight<'a>>,
    source: Option<Source>,
    haze: Option<Haze>,
    seen_through: Option<Handle<Texture>>,
    depth: Handle<Texture>,
    color: Handle<Texture>,
    object: Handle<Texture>,
}

impl Work<'_> {
    fn run(&self, cx: &mut PassContext) -> Result<(), PassError> {
        let gpu = cx.gpu;
        let (color, object, depth) = (cx.view(self.color), cx.view(self.object), cx.view(self.depth));
        let cleared = |view| {
            let ops =
                wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT), store: wgpu::StoreOp::Store };
            Some(wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops })
        };
        let mut pass = cx
            .render_pass(&wgpu::RenderPassDescriptor {
                label: Some("blend"),
                color_attachments: &[cleared(&color), cleared(&object)],
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &depth,
                    depth_ops: None,
                    stencil_ops: None,
                }),
                ..Default::default()
            })
            .forget_lifetime();
        let maps: Vec<Option<wgpu::TextureView>> = self
            .direct_lights
            .iter()
            .map(|direct_light| direct_light.shadow.as_ref().map(|s| layered_view(cx.gpu, cx.texture(s.map))))
            .collect();
        let indirect = self.indirect_bindings(cx);
        let seen_through = self.seen_through.map(|seen| cx.view(seen));
        let view = self.frame.view_uniform(gpu);
        let camera = self.frame.view.camera.world_from_view;
        let order = (self.frame.view.eye(), camera.transform_vector3(glam::Vec3::NEG_Z));
        let format = color_format(gpu);
        cx.counts().lights += self.direct_lights.len() as u64;
        self.frame.gpu_scene.draw_blended(
            cx,
            &mut pass,
            &view,
            &filter_of(&self.frame.frustum()),
            order,
            |class, side| self.raster_key(class, side, format),
            |pipeline, pass| {
                let mut bindings: Vec<_> = indirect.iter().map(|(name, b)| (*name, Binding::Buffer(b))).collect();
                let seen = seen_through.iter().filter(|_| pipeline.declares(3, "seen_through"));
                bindings.extend(seen.map(|seen| ("seen_through", Binding::Texture(seen))));
                if let Some(Source::Patches(_)) = &self.source {
                    bindings.extend(self.frame.surfels.patches().bindings());
                    bindings.push(("primitive_ids", self.frame.surfels.primitive_ids()));
                }
                if !bindings.is_empty() {
                    pass.set_bind_group(3, &pipeline.bind(gpu, 3, &bindings)?, &[]);
                }
                self.light_groups(gpu, pipeline, &maps)
            },
        )
    }

    /// Group 3: what indirect light is looked up in, and haze.
    fn indirect_bindings(&self, cx: &PassContext) -> Vec<(&'static str, wgpu::Buffer)> {
        let mut bindings = match &self.source {
            Some(Source::Patches(light)) => vec![("patch_light", cx.buffer(*light).clone())],
            Some(Source::Field(field)) => field.bindings(cx),
            Some(Source::Ambient(ambient)) => vec![("ambient", cx.buffer(*ambient).clone())],
            None => Vec::new(),
        };
        bindings.extend(self.haze.iter().flat_map(|haze| haze.bindings(cx, &self.frame)));
        bindings
    }

    /// Group 2 of each draw of a surface: the lights, a few at a time.
    fn light_groups(
        &self,
        gpu: &Gpu,
        pipeline: &Pipeline,
        maps: &[Option<wgpu::TextureView>],
    ) -> Result<Vec<wgpu::BindGroup>, PassError> {
        let none = no_shadow_map(gpu);
        let sampler = comparison_sampler(gpu);
        let has_emission = self.frame.settings.only != Layer::Indirect;
        let draws = self.direct_lights.len().div_ceil(LIGHTS_A_DRAW).max(1);
        let mut groups = Vec::with_capacity(draws);
        for first in (0..draws).map(|draw| draw * LIGHTS_A_DRAW) {
            let direct_lights = self.direct_lights.get(first..).unwrap_or_default();
            let count = direct_lights.len().min(LIGHTS_A_DRAW);
            let uniform = BlendUniform {
                lights: from_fn(|i| {
                    direct_lights.get(i).map_or_else(LightUniform::none, |l| LightUniform::new(l.light))
                }),
                shadows: from_fn(|i| {
                    let shadow = direct_lights.get(i).and_then(|direct_light| direct_light.shadow.as_ref());
                    shadow.map_or_else(ShadowMap::none_uniform, ShadowMap::uniform)
                }),
                light_count: count as u32,
                is_first: u32::from(first == 0),
                has_emission: u32::from(has_emission && first == 0),
                patch_size: self.frame.surfels.patch_size(),
            };
            let uniform = gpu.uniform("blend", &uniform);
            let map = |i: usize| Binding::Texture(maps.get(first + i).and_then(Option::as_ref).unwrap_or(&none));
            let bindings = [
                ("blend", Binding::Buffer(&uniform)),
                ("shadow_first", map(0)),
                ("shadow_second", map(1)),
                ("shadow_third", map(2)),
                ("shadow_fourth", map(3)),
                ("shadow_sampler", Binding::Sampler(&sampler)),
            ];
            groups.push(pipeline.bind(gpu, 2, &bindings)?);
        }
        Ok(groups)
    }

    fn raster_key(&self, class: MaterialClass, side: Side, format: TextureFormat) -> RasterKey {
        let over = BlendComponent {
            src_factor: BlendFactor::One,
            dst_factor: BlendFactor::OneMinusSrcAlpha,
            operation: BlendOperation::Add,
        };
        let mut defs = class.defs_of_view();
        defs.push(("FORWARD", ShaderDef::Flag(true)));
        match &self.source {
            Some(Source::Patches(_)) => defs.push(("PATCHED", ShaderDef::Flag(true))),
            Some(Source::Field(field)) => defs.push((field.define(), ShaderDef::Flag(true))),
            Some(Source::Ambient(_)) => defs.push(("AMBIENT", ShaderDef::Flag(true))),
            None => {}
        }
        if class.glass {
            defs.push(("GLASS", ShaderDef::Flag(true)));
            defs.extend(self.seen_through.map(|_| ("SEEN_THROUGH", ShaderDef::Flag(true))));
        }
        defs.extend(self.haze.iter().flat_map(|_| Haze::defines(&self.frame)));
        RasterKey {
            shader: "transparency/blend.wgsl",
            vertex: "vertex",
            fragment: Some("fragment"),
            defs,
            vertex_buffers: class.vertex_buffers(),
            primitive: wgpu::PrimitiveState { cull_mode: Some(side.cull_mode()), ..class.primitive_state() },
            depth: Some(wgpu::DepthStencilState {
                depth_write_enabled: Some(false),
                // A decal right on a surface shows.
                depth_compare: Some(wgpu::CompareFunction::GreaterEqual),
                ..depth_state()
            }),
            targets: vec![
                Some(wgpu::ColorTargetState {
                    format,
                    blend: Some(BlendState { color: over, alpha: over }),
                    write_mask: wgpu::ColorWrites::ALL,
                }),
                Some(TextureFormat::R32Uint.into()),
            ],
        }
    }
}
