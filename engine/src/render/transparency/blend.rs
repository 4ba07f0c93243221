//! Blended surfaces: drawn forward, over what the deferred passes made, from the farthest to the nearest.
//!
//! Their direct light is that of the deferred pass, shadow maps included. Indirect light is that of the surface's own patches,
//! or where there are none it is looked up in the light volumes at the surface's place; methods that light pixels alone (virtual point lights, stochastic light culling)
//! lend one irradiance to all of them, the mean of what the visible surfaces receive. In the lights' own views a
//! blended surface is there where it is more than half opaque. Where alpha reaches 1 it is drawn with the opaque ones.

use crate::gpu::{Binding, Gpu, Pipeline, RasterKey, ShaderDef, uniform_bytes};
use crate::graph::{
    Buffer, Contents, Counts, DrawBindings, Draws, Graph, Handle, PassBindings, PassContext, PassError, Texture,
    TextureDesc, hash,
};
use crate::render::direct::{DirectLight, comparison_sampler, layered_view, no_shadow_map};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::{GBuffer, depth_state};
use crate::render::haze::Haze;
use crate::render::indirect::light_volumes::Field;
use crate::render::scene_gpu::light_uniform::LightUniform;
use crate::render::scene_gpu::{DrawFilter, MaterialClass, Side};
use crate::render::settings::Layer;
use crate::render::shadows::shadow_map::{ShadowMap, ShadowUniform};
use crate::scene::Frustum;
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

fn filter_of(frustum: &Frustum) -> DrawFilter<'_> {
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
    let mut pass = graph.raster("blend");
    let (color, _) = (pass.color(color, Contents::Cleared), pass.color(object, Contents::Cleared));
    pass.test_depth(gbuffer.depth);
    frame.bind_view(&mut pass);
    pass.flag("FORWARD", true);
    source.iter().for_each(|source| bind_source(&mut pass, frame, source));
    if let Some(haze) = haze {
        haze.bind(&mut pass, frame);
    }
    seen_through.iter().for_each(|&seen| pass.read("seen_through", seen));
    for shadow in direct_lights.iter().filter_map(|direct_light| direct_light.shadow.as_ref()) {
        pass.read_in_draws(shadow.map);
    }
    pass.count(Counts { lights: direct_lights.len() as u64, ..Counts::default() });
    let (frustum, format) = (frame.frustum(), color_format(gpu));
    let sees_through = seen_through.is_some();
    pass.step().draws(BlendedDraws { frame: frame.clone(), direct_lights, frustum, format, sees_through });
    pass.finish();
    color
}

/// Binds, as part of group 3, what indirect light is looked up in.
fn bind_source<'a>(pass: &mut PassBindings<'_, 'a>, frame: &Frame<'a>, source: &Source) {
    match source {
        Source::Patches(light) => {
            pass.flag("PATCHED", true);
            pass.read("patch_light", *light);
            frame.bind_patches(pass);
            pass.tracked("primitive_ids", frame.surfels.primitive_ids(&frame.geometry_key()));
        }
        Source::Field(field) => {
            pass.flag(field.define(), true);
            field.bind(pass, |_| true);
        }
        Source::Ambient(light) => {
            pass.flag("AMBIENT", true);
            pass.read("ambient", *light);
        }
    }
}

/// Half floats where the adapter cannot blend whole ones: radiance above 65504 is cut off.
pub(super) fn color_format(gpu: &Gpu) -> TextureFormat {
    if gpu.features.contains(wgpu::Features::FLOAT32_BLENDABLE) {
        TextureFormat::Rgba32Float
    } else {
        TextureFormat::Rgba16Float
    }
}

/// The blended surfaces of a view, from the farthest to the nearest.
struct BlendedDraws<'a> {
    frame: Frame<'a>,
    direct_lights: Vec<DirectLight<'a>>,
    frustum: Frustum,
    format: TextureFormat,
    sees_through: bool,
}

impl Draws for BlendedDraws<'_> {
    fn key(&self) -> u64 {
        let scene = self.frame.gpu_scene;
        let lights: Vec<_> = self.light_uniforms().map(|uniform| uniform_bytes("blend", &uniform)).collect();
        let have_shadows: Vec<bool> = self.direct_lights.iter().map(|light| light.shadow.is_some()).collect();
        let moving = scene.moving(&[filter_of(&self.frustum)]);
        hash(&(scene.still_key(), moving, lights, have_shadows, self.pipeline(MaterialClass::SIMPLEST, Side::Front)))
    }

    fn is_empty(&self) -> bool {
        !self.frame.gpu_scene.any_blended(&filter_of(&self.frustum))
    }

    fn draw(
        &self,
        cx: &mut PassContext,
        pass: &mut wgpu::RenderPass<'_>,
        bound: &DrawBindings,
    ) -> Result<(), PassError> {
        let gpu = cx.gpu;
        let shadow = |light: &DirectLight| light.shadow.as_ref().map(|s| layered_view(gpu, cx.texture(s.map)));
        let maps: Vec<Option<wgpu::TextureView>> = self.direct_lights.iter().map(shadow).collect();
        let camera = self.frame.view.camera.world_from_view;
        let order = (self.frame.view.eye(), camera.transform_vector3(glam::Vec3::NEG_Z));
        let view: Vec<_> = bound.group.iter().filter(|(name, _)| *name == "view").copied().collect();
        let pipeline = |class, side| {
            let mut pipeline = self.pipeline(class, side);
            pipeline.defs.extend(bound.defines.iter().cloned());
            pipeline
        };
        let prepare = |pipeline: &Pipeline, pass: &mut wgpu::RenderPass<'_>| {
            let used = bound.group.iter().filter(|(name, _)| pipeline.declares(3, name));
            let used: Vec<_> = used.copied().collect();
            if !used.is_empty() {
                pass.set_bind_group(3, &pipeline.bind(gpu, 3, &used)?, &[]);
            }
            self.light_groups(gpu, pipeline, &maps)
        };
        self.frame.gpu_scene.draw_blended(cx, pass, &view, &filter_of(&self.frustum), order, pipeline, prepare)
    }
}

impl BlendedDraws<'_> {
    /// What the lights of each draw of a surface are, a few at a time.
    fn light_uniforms(&self) -> impl Iterator<Item = BlendUniform> + '_ {
        let has_emission = self.frame.settings.only != Layer::Indirect;
        let draws = self.direct_lights.len().div_ceil(LIGHTS_A_DRAW).max(1);
        (0..draws).map(move |draw| {
            let direct_lights = self.direct_lights.get(draw * LIGHTS_A_DRAW..).unwrap_or_default();
            BlendUniform {
                lights: from_fn(|i| {
                    direct_lights.get(i).map_or_else(LightUniform::none, |l| LightUniform::new(l.light))
                }),
                shadows: from_fn(|i| {
                    let shadow = direct_lights.get(i).and_then(|direct_light| direct_light.shadow.as_ref());
                    shadow.map_or_else(ShadowMap::none_uniform, ShadowMap::uniform)
                }),
                light_count: direct_lights.len().min(LIGHTS_A_DRAW) as u32,
                is_first: u32::from(draw == 0),
                has_emission: u32::from(has_emission && draw == 0),
                patch_size: self.frame.surfels.patch_size(),
            }
        })
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
        let group = |(draw, uniform): (usize, BlendUniform)| {
            let uniform = gpu.uniform("blend", &uniform);
            let map = |i: usize| {
                Binding::Texture(maps.get(draw * LIGHTS_A_DRAW + i).and_then(Option::as_ref).unwrap_or(&none))
            };
            let bindings = [
                ("blend", Binding::Buffer(&uniform)),
                ("shadow_first", map(0)),
                ("shadow_second", map(1)),
                ("shadow_third", map(2)),
                ("shadow_fourth", map(3)),
                ("shadow_sampler", Binding::Sampler(&sampler)),
            ];
            Ok(pipeline.bind(gpu, 2, &bindings)?)
        };
        self.light_uniforms().enumerate().map(group).collect()
    }

    fn pipeline(&self, class: MaterialClass, side: Side) -> RasterKey {
        let over = BlendComponent {
            src_factor: BlendFactor::One,
            dst_factor: BlendFactor::OneMinusSrcAlpha,
            operation: BlendOperation::Add,
        };
        let mut defs = class.defs_of_view();
        if class.glass {
            defs.push(("GLASS", ShaderDef::Flag(true)));
            defs.extend(self.sees_through.then_some(("SEEN_THROUGH", ShaderDef::Flag(true))));
        }
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
                    format: self.format,
                    blend: Some(BlendState { color: over, alpha: over }),
                    write_mask: wgpu::ColorWrites::ALL,
                }),
                Some(TextureFormat::R32Uint.into()),
            ],
        }
    }
}
