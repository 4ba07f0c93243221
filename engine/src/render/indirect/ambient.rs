//! One irradiance for all, from what the visible surfaces receive.

use crate::gpu::ComputeKey;
use crate::graph::{Buffer, BufferDesc, Graph, Handle, Texture};
use crate::render::geometry::gbuffer::GBuffer;
use crate::render::zero_texture::zero_texture;
use wgpu::BufferUsages;

/// Declares the pass for the sum of at most two images; the result is the mean indirect irradiance of the visible surfaces [W/m²].
pub fn declare<'a>(graph: &mut Graph<'a>, gbuffer: &GBuffer, light: &[Handle<Texture>]) -> Handle<Buffer> {
    let ambient = graph.retained_buffer("ambient irradiance", BufferDesc::new(16, BufferUsages::STORAGE));
    let mut pass = graph.compute("ambient", ComputeKey::new("indirect/ambient.wgsl", "main"));
    pass.read("base_color", gbuffer.base_color);
    pass.read("depth", gbuffer.depth);
    for (index, name) in ["first", "second"].into_iter().enumerate() {
        match light.get(index) {
            Some(light) => pass.read(name, *light),
            None => pass.stand_in(name, |gpu| zero_texture(gpu, 1)),
        }
    }
    let ambient = pass.write("ambient", ambient);
    pass.dispatch_groups([1, 1, 1]);
    ambient
}
