//! Light-emitting particles as the camera sees them: soft discs, from the farthest to the nearest.
//!
//! Each disc sends as much light to the eye as its sphere, radiance L over πr², and hides as much of what lies behind. Rays and methods of light meet the mesh that
//! stands for the particles instead, see [`Mesh::balls`](crate::assets::Mesh::balls).

use super::blend::color_format;
use crate::assets::Ball;
use crate::gpu::{Gpu, RasterKey};
use crate::graph::{Contents, Graph, Handle, Texture, TextureDesc};
use crate::render::frame::Frame;
use crate::render::geometry::GBuffer;
use crate::render::haze::Haze;
use crate::render::settings::Layer;
use crate::scene::Primitive;
use glam::{Vec3, Vec4};
use wgpu::{BlendComponent, BlendFactor, BlendOperation, BlendState, TextureUsages};

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
    let revisions: Vec<_> = sources.iter().map(|p| (p.id.0, p.geometry_revision, p.material_revision)).collect();
    // As many as there will ever be, so that the buffer stays: those that are not there have no size.
    let count = sources.iter().map(|p| p.mesh.balls.as_ref().map_or(0, |balls| balls.len())).sum::<usize>() as u32;
    let (scene, axis) = (frame.scene, frame.view.axis());
    let mut pass = graph.raster("particle discs");
    let light = pass.color(light, Contents::Cleared);
    frame.bind_view(&mut pass);
    let seen = (scene.identity, revisions, frame.view_key());
    pass.values_of("balls", &seen, move || balls(&scene.primitives, axis));
    pass.read("depth", gbuffer.depth);
    if let Some(haze) = haze {
        haze.bind(&mut pass, frame);
    }
    pass.step().draw(pipeline(color_format(gpu)), [6, count]);
    pass.finish();
    Some(light)
}

/// All balls in world space, from the farthest to the nearest.
fn balls(primitives: &[Primitive], axis: Vec4) -> Vec<Ball> {
    let depth = |ball: &Ball| axis.dot(Vec3::from(ball.position).extend(1.0));
    let mut balls: Vec<Ball> = primitives.iter().flat_map(in_world).collect();
    balls.sort_by(|a, b| depth(b).total_cmp(&depth(a)));
    balls
}

fn pipeline(format: wgpu::TextureFormat) -> RasterKey {
    let over = BlendComponent {
        src_factor: BlendFactor::One,
        dst_factor: BlendFactor::OneMinusSrcAlpha,
        operation: BlendOperation::Add,
    };
    RasterKey {
        shader: "transparency/particles.wgsl",
        vertex: "vertex",
        fragment: Some("fragment"),
        defs: Vec::new(),
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

/// The balls of a primitive, in world space.
fn in_world(primitive: &Primitive) -> impl Iterator<Item = Ball> {
    let place = primitive.world_from_object;
    let balls = primitive.mesh.balls.iter().flat_map(|balls| balls.iter());
    balls.map(move |ball| Ball { position: place.transform_point3(Vec3::from(ball.position)).to_array(), ..*ball })
}
