//! Splatting: the third way of finding the lights of a pixel, for comparison.

use super::{ACCEPTED, Method, Shaded, Sources, TESTED, image_desc};
use crate::gpu::{Binding, ComputeKey, Gpu, RasterKey};
use crate::graph::{Graph, Handle, PassContext, PassError, Texture, TextureDesc};
use crate::render::frame::Frame;
use crate::render::geometry::gbuffer::GBuffer;
use wgpu::{BlendComponent, BlendFactor, BlendOperation, BlendState, TextureFormat, TextureUsages};

/// Vertices of an icosahedron of single triangles.
const VERTICES: u32 = 60;

/// Whether the adapter can add what is drawn.
pub(super) fn is_possible(gpu: &Gpu) -> bool {
    gpu.features.contains(wgpu::Features::FLOAT32_BLENDABLE)
}

/// Declares the drawing of all lights, and the way back from the atlas of subsets to the image.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    method: &Method,
    sources: Sources,
) -> Shaded {
    let atlas = declare_atlas(graph, frame, gbuffer, method, sources);
    let diffuse = graph.retained_texture(TESTED, image_desc(frame));
    let specular = graph.retained_texture(ACCEPTED, image_desc(frame));
    let mut pass = graph.pass("slc gather");
    pass.read(atlas.diffuse);
    pass.read(atlas.specular);
    let shaded = Shaded { diffuse: pass.write(diffuse), specular: pass.write(specular) };
    pass.key(&method.key(frame));
    let (frame, method) = (frame.clone(), method.clone());
    pass.execute(move |cx| {
        let [width, height] = frame.view.size;
        let images = [atlas.diffuse, atlas.specular, shaded.diffuse, shaded.specular].map(|handle| cx.view(handle));
        cx.dispatch(
            &ComputeKey::new("indirect/light_culling/splat.wgsl", "gather"),
            &[
                ("culling", Binding::Buffer(&method.uniform(cx.gpu, &frame, 0))),
                ("diffuse_atlas", Binding::Texture(&images[0])),
                ("specular_atlas", Binding::Texture(&images[1])),
                ("diffuse", Binding::Texture(&images[2])),
                ("specular", Binding::Texture(&images[3])),
            ],
            [width.div_ceil(8), height.div_ceil(8), 1],
        )
    });
    shaded
}

fn declare_atlas<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    method: &Method,
    sources: Sources,
) -> Shaded {
    let n = method.settings.interleave;
    let part = frame.view.size.map(|size| size.div_ceil(n));
    let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING;
    let desc = TextureDesc::d2(n * part[0], n * part[1], TextureFormat::Rgba32Float, usage);
    let diffuse = graph.retained_texture("slc diffuse atlas", desc.clone());
    let specular = graph.retained_texture("slc specular atlas", desc);
    let mut pass = graph.pass("slc splat");
    let surfaces = [gbuffer.base_color, gbuffer.normal, gbuffer.object, gbuffer.depth, sources.texels];
    surfaces.into_iter().for_each(|handle| pass.read(handle));
    let buffers = [sources.ranges, sources.bound];
    buffers.into_iter().for_each(|handle| pass.read(handle));
    let atlas = Shaded { diffuse: pass.write(diffuse), specular: pass.write(specular) };
    pass.key(&method.key(frame));
    let (frame, method) = (frame.clone(), method.clone());
    pass.execute(move |cx| {
        for row in 0..n {
            cx.work(1, 1);
            draw_row(cx, &frame, &method, [surfaces.as_slice(), &[atlas.diffuse, atlas.specular]], buffers, row, part)?;
        }
        Ok(())
    });
    atlas
}

/// Draws the lights of one row of subsets.
fn draw_row(
    cx: &mut PassContext,
    frame: &Frame,
    method: &Method,
    [surfaces, targets]: [&[Handle<Texture>]; 2],
    buffers: [Handle<crate::graph::Buffer>; 2],
    row: u32,
    part: [u32; 2],
) -> Result<(), PassError> {
    let gpu = cx.gpu;
    let n = method.settings.interleave;
    let surfaces: Vec<wgpu::TextureView> = surfaces.iter().map(|handle| cx.view(*handle)).collect();
    let targets: Vec<wgpu::TextureView> = targets.iter().map(|handle| cx.view(*handle)).collect();
    let buffers = buffers.map(|handle| cx.buffer(handle).clone());
    let pipeline = gpu.pipelines.raster(gpu, &raster_key())?;
    let Some(raster) = pipeline.raster() else {
        return Err(PassError::message("`indirect/light_culling/splat.wgsl` made no raster pipeline".to_owned()));
    };
    let mut groups = Vec::new();
    for column in 0..n {
        let culling = method.uniform(gpu, frame, row * n + column);
        let group = [
            ("culling", Binding::Buffer(&culling)),
            ("base_color", Binding::Texture(&surfaces[0])),
            ("normal", Binding::Texture(&surfaces[1])),
            ("object", Binding::Texture(&surfaces[2])),
            ("depth", Binding::Texture(&surfaces[3])),
            ("light_texels", Binding::Texture(&surfaces[4])),
            ("ranges", Binding::Buffer(&buffers[0])),
            ("bound", Binding::Buffer(&buffers[1])),
        ];
        groups.push(pipeline.bind(gpu, 0, &group)?);
    }
    let counts = cx.counts();
    counts.draws += u64::from(n);
    counts.triangles += u64::from(n) * u64::from(VERTICES / 3) * 2 * u64::from(method.lights);
    let load = if row == 0 { wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT) } else { wgpu::LoadOp::Load };
    let attachment = |view| {
        let ops = wgpu::Operations { load, store: wgpu::StoreOp::Store };
        Some(wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops })
    };
    let mut pass = cx.render_pass(&wgpu::RenderPassDescriptor {
        label: Some("slc splat"),
        color_attachments: &[attachment(&targets[0]), attachment(&targets[1])],
        ..Default::default()
    });
    pass.set_pipeline(raster);
    for (column, group) in (0..n).zip(&groups) {
        let [x, y] = [column * part[0], row * part[1]];
        pass.set_viewport(x as f32, y as f32, part[0] as f32, part[1] as f32, 0.0, 1.0);
        pass.set_scissor_rect(x, y, part[0], part[1]);
        pass.set_bind_group(0, group, &[]);
        pass.draw(0..VERTICES, 0..2 * method.lights);
    }
    Ok(())
}

fn raster_key() -> RasterKey {
    let add =
        BlendComponent { src_factor: BlendFactor::One, dst_factor: BlendFactor::One, operation: BlendOperation::Add };
    let target = wgpu::ColorTargetState {
        format: TextureFormat::Rgba32Float,
        blend: Some(BlendState { color: add, alpha: add }),
        write_mask: wgpu::ColorWrites::ALL,
    };
    RasterKey {
        shader: "indirect/light_culling/splat.wgsl",
        vertex: "vertex",
        fragment: Some("fragment"),
        defs: Vec::new(),
        vertex_buffers: Vec::new(),
        primitive: wgpu::PrimitiveState { cull_mode: Some(wgpu::Face::Front), ..Default::default() },
        depth: None,
        targets: vec![Some(target.clone()), Some(target)],
    }
}
