//! The report's accumulation: the scene drawn once more for every virtual light.

use super::particles::{Lights, VirtualLights};
use super::shade::{range, surfaces_key};
use crate::gpu::{Binding, RasterKey, ShaderDef};
use crate::graph::{Graph, Handle, PassContext, PassError, Texture, TextureDesc};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::{GBuffer, depth_state};
use crate::render::indirect::gloss;
use crate::render::scene_gpu::{DrawFilter, MaterialClass};
use crate::world::{VirtualShading, VirtualVisibility};
use encase::ShaderType;
use wgpu::TextureFormat;

/// `Letter` of `indirect/instant_radiosity/published.wgsl`.
#[derive(ShaderType)]
pub(crate) struct LetterUniform {
    index: u32,
    root: u32,
    scale: f32,
    pad: u32,
}

/// Lights of one submit.
const LIGHTS_A_SUBMIT: u64 = 16;

/// Declares the pass; the result is reflected radiance.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    state: &'a VirtualLights,
    lights: Lights,
) -> Handle<Texture> {
    let [width, height] = frame.view.size;
    let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING;
    let desc = TextureDesc::d2(width, height, TextureFormat::Rgba32Float, usage);
    let indirect = graph.retained_texture("indirect radiance", desc);
    // By hand: there is a render pass for each light, whose number is known once the particles are traced.
    let mut pass = graph.pass("vpl letter");
    let inputs = [gbuffer.base_color, gbuffer.normal, gbuffer.object, gbuffer.depth];
    for input in inputs {
        pass.read(input);
    }
    pass.read(lights.buffer);
    let indirect = pass.write(indirect);
    let settings = &state.settings;
    pass.key(&(frame.view_key(), settings.visibility, settings.shading, frame.settings.virtual_light));
    pass.key(&surfaces_key(frame, settings));
    let work = Work { frame: frame.clone(), state, inputs, lights, indirect };
    pass.execute(move |cx| work.run(cx));
    indirect
}

struct Work<'a> {
    frame: Frame<'a>,
    state: &'a VirtualLights,
    inputs: [Handle<Texture>; 4],
    lights: Lights,
    indirect: Handle<Texture>,
}

impl Work<'_> {
    fn run(&self, cx: &mut PassContext) -> Result<(), PassError> {
        if !cx.gpu.features.contains(wgpu::Features::FLOAT32_BLENDABLE) {
            let message = "this adapter cannot blend 32-bit floats, which adding light by light needs: \
                           set `vpl.accumulation` to Batched, which gives the same image";
            return Err(PassError::message(message.to_owned()));
        }
        self.clear(cx);
        let lights = range(self.state, &self.lights, self.frame.settings.virtual_light)?;
        cx.counts().lights += u64::from(lights.end - lights.start);
        for index in lights {
            cx.work(1, LIGHTS_A_SUBMIT)?;
            self.draw(cx, index)?;
        }
        Ok(())
    }

    fn clear(&self, cx: &mut PassContext) {
        let target = cx.view(self.indirect);
        let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT), store: wgpu::StoreOp::Store };
        cx.render_pass(&wgpu::RenderPassDescriptor {
            label: Some("clear"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &target,
                depth_slice: None,
                resolve_target: None,
                ops,
            })],
            ..Default::default()
        });
    }

    /// The whole scene for one light.
    fn draw(&self, cx: &mut PassContext, index: u32) -> Result<(), PassError> {
        let gpu = cx.gpu;
        let [base_color, normal, object, depth] = self.inputs.map(|handle| cx.view(handle));
        let target = cx.view(self.indirect);
        let lights = cx.buffer(self.lights.buffer).clone();
        let pipeline = gpu.pipelines.raster(gpu, &self.raster_key(MaterialClass::SIMPLEST))?;
        let letter = LetterUniform { index, root: self.state.rays.root(), scale: 1.0, pad: 0 };
        let letter = gpu.uniform("letter", &letter);
        let surfaces = pipeline.bind(
            gpu,
            2,
            &[
                ("base_color", Binding::Texture(&base_color)),
                ("normal", Binding::Texture(&normal)),
                ("object", Binding::Texture(&object)),
                ("depth", Binding::Texture(&depth)),
                ("virtual_lights", Binding::Buffer(&lights)),
            ],
        )?;
        let light = pipeline.bind(gpu, 3, &[("letter", Binding::Buffer(&letter))])?;
        let rays = self.state.rays.bind(gpu, &pipeline)?;
        let mut pass = cx
            .render_pass(&wgpu::RenderPassDescriptor {
                label: Some("virtual light"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &target,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
                })],
                // Read only: the shader looks positions up in it.
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &depth,
                    depth_ops: None,
                    stencil_ops: None,
                }),
                ..Default::default()
            })
            .forget_lifetime();
        pass.set_bind_group(1, &rays, &[]);
        pass.set_bind_group(2, &surfaces, &[]);
        pass.set_bind_group(3, &light, &[]);
        let view = self.frame.view_uniform(gpu);
        let frustum = self.frame.frustum();
        let filter = DrawFilter::opaque(&frustum);
        self.frame
            .gpu_scene
            .draw(cx, &mut pass, &[("view", Binding::Buffer(&view))], &filter, |class| self.raster_key(class))
    }

    fn raster_key(&self, class: MaterialClass) -> RasterKey {
        let settings = &self.state.settings;
        let published = settings.shading == VirtualShading::AsPublished;
        let shadowed = settings.visibility == VirtualVisibility::ShadowRays && !published;
        let mut defs = if shadowed {
            self.state.rays.shader("indirect/instant_radiosity/published.wgsl", "add_light").defs
        } else {
            Vec::new()
        };
        let matte = !gloss::is_wanted(self.frame.scene);
        let flags = [("UNSHADOWED", !shadowed), ("PUBLISHED", published), ("MATTE", matte)];
        defs.extend(flags.into_iter().filter(|(_, set)| *set).map(|(name, _)| (name, ShaderDef::Flag(true))));
        let one = wgpu::BlendComponent {
            src_factor: wgpu::BlendFactor::One,
            dst_factor: wgpu::BlendFactor::One,
            operation: wgpu::BlendOperation::Add,
        };
        RasterKey {
            shader: "indirect/instant_radiosity/published.wgsl",
            vertex: "vertex",
            fragment: Some("add_light"),
            defs,
            vertex_buffers: class.vertex_buffers(),
            primitive: class.primitive_state(),
            depth: Some(wgpu::DepthStencilState {
                depth_write_enabled: Some(false),
                depth_compare: Some(wgpu::CompareFunction::Equal),
                ..depth_state()
            }),
            targets: vec![Some(wgpu::ColorTargetState {
                format: TextureFormat::Rgba32Float,
                blend: Some(wgpu::BlendState { color: one, alpha: one }),
                write_mask: wgpu::ColorWrites::ALL,
            })],
        }
    }
}
