//! Light-emitting particles as the camera sees them: soft discs, from the farthest to the nearest.
//!
//! Each disc sends as much light to the eye as its sphere, radiance L over πr², and hides as much of what lies behind. Rays and methods of light meet the mesh that
//! stands for the particles instead, see [`Mesh::balls`](crate::assets::Mesh::balls).

use super::blend::color_format;
use crate::assets::Ball;
use crate::gpu::{Binding, Gpu, RasterKey};
use crate::graph::{Graph, Handle, PassContext, PassError, Texture, TextureDesc};
use crate::render::frame::Frame;
use crate::render::geometry::GBuffer;
use crate::render::haze::Haze;
use crate::render::settings::Layer;
use crate::scene::Primitive;
use glam::Vec3;
use wgpu::{BlendComponent, BlendFactor, BlendOperation, BlendState, TextureUsages};

const SHADER: &str = "transparency/particles.wgsl";

/// Declares the pass; the result is premultiplied radiance, and in alpha how much is hidden of the opaque image. None if no particle is in view, without a word
/// where the scene has none.
pub(in crate::render) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    gpu: &Gpu,
    haze: Option<Haze>,
) -> Option<Handle<Texture>> {
    let sources: Vec<&Primitive> = frame.scene.primitives.iter().filter(|p| p.is_particles()).collect();
    if sources.is_empty() {
        return None;
    }
    if !matches!(frame.settings.only, Layer::Total | Layer::Direct) {
        graph.skip("particle discs", "the layer that is shown holds no emitted light");
        return None;
    }
    let [width, height] = frame.view.size;
    let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING;
    let desc = TextureDesc::d2(width, height, color_format(gpu), usage);
    let light = graph.retained_texture("light of particles", desc);
    let mut pass = graph.pass("particle discs");
    pass.read(gbuffer.depth);
    haze.iter().for_each(|haze| pass.read(haze.buffer()));
    let light = pass.write(light);
    let revisions: Vec<_> = sources.iter().map(|p| (p.id.0, p.geometry_revision, p.material_revision)).collect();
    pass.key(&(frame.scene.identity, revisions, frame.view_key()));
    pass.key(&haze.map(|haze| (haze.key(), frame.media_key())));
    let work = Work { frame: frame.clone(), depth: gbuffer.depth, haze, light };
    pass.execute(move |cx| work.run(cx));
    Some(light)
}

struct Work<'a> {
    frame: Frame<'a>,
    depth: Handle<Texture>,
    haze: Option<Haze>,
    light: Handle<Texture>,
}

impl Work<'_> {
    fn run(&self, cx: &mut PassContext) -> Result<(), PassError> {
        let gpu = cx.gpu;
        let balls = self.balls();
        let (light, depth) = (cx.view(self.light), cx.view(self.depth));
        let pipeline = gpu.pipelines.raster(gpu, &self.raster_key(color_format(gpu)))?;
        let Some(raster) = pipeline.raster() else {
            return Err(PassError::message(format!("`{SHADER}` made no raster pipeline")));
        };
        let view = self.frame.view_uniform(gpu);
        // As large as they will ever be, so that the buffer stays: those that are not there have no size.
        let buffer = gpu.storage("balls", &balls, wgpu::BufferUsages::empty());
        let haze = self.haze.map(|haze| haze.bindings(cx, &self.frame)).unwrap_or_default();
        let mut group = vec![
            ("view", Binding::Buffer(&view)),
            ("balls", Binding::Buffer(&buffer)),
            ("depth", Binding::Texture(&depth)),
        ];
        group.extend(haze.iter().map(|(name, buffer)| (*name, Binding::Buffer(buffer))));
        let group = pipeline.bind(gpu, 0, &group)?;
        let counts = cx.counts();
        counts.draws += 1;
        counts.triangles += 2 * balls.len() as u64;
        let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT), store: wgpu::StoreOp::Store };
        let mut pass = cx.render_pass(&wgpu::RenderPassDescriptor {
            label: Some("particle discs"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &light,
                depth_slice: None,
                resolve_target: None,
                ops,
            })],
            ..Default::default()
        });
        pass.set_pipeline(raster);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..6, 0..balls.len() as u32);
        Ok(())
    }

    /// All balls in world space, from the farthest to the nearest.
    fn balls(&self) -> Vec<Ball> {
        let axis = self.frame.view.axis();
        let depth = |ball: &Ball| axis.dot(Vec3::from(ball.position).extend(1.0));
        let mut balls: Vec<Ball> = self.frame.scene.primitives.iter().flat_map(in_world).collect();
        balls.sort_by(|a, b| depth(b).total_cmp(&depth(a)));
        balls
    }

    fn raster_key(&self, format: wgpu::TextureFormat) -> RasterKey {
        let over = BlendComponent {
            src_factor: BlendFactor::One,
            dst_factor: BlendFactor::OneMinusSrcAlpha,
            operation: BlendOperation::Add,
        };
        RasterKey {
            shader: SHADER,
            vertex: "vertex",
            fragment: Some("fragment"),
            defs: self.haze.iter().flat_map(|_| Haze::defines(&self.frame)).collect(),
            vertex_buffers: Vec::new(),
            primitive: wgpu::PrimitiveState::default(),
            depth: None,
            targets: vec![Some(wgpu::ColorTargetState {
                format,
                blend: Some(BlendState { color: over, alpha: over }),
                write_mask: wgpu::ColorWrites::ALL,
            })],
        }
    }
}

/// The balls of a primitive, in world space.
fn in_world(primitive: &Primitive) -> impl Iterator<Item = Ball> {
    let place = primitive.world_from_object;
    let balls = primitive.mesh.balls.iter().flat_map(|balls| balls.iter());
    balls.map(move |ball| Ball { position: place.transform_point3(Vec3::from(ball.position)).to_array(), ..*ball })
}
