//! One irradiance for all, from what the visible surfaces receive.

use crate::gpu::{Binding, ComputeKey};
use crate::graph::{Buffer, BufferDesc, Graph, Handle, Texture};
use crate::render::geometry::gbuffer::GBuffer;
use crate::render::zero_texture::zero_texture;
use wgpu::BufferUsages;

/// Declares the pass for the sum of at most two images; the result is the mean indirect irradiance of the visible surfaces [W/m²].
pub fn declare<'a>(graph: &mut Graph<'a>, gbuffer: &GBuffer, light: &[Handle<Texture>]) -> Handle<Buffer> {
    let ambient = graph.retained_buffer("ambient irradiance", BufferDesc::new(16, BufferUsages::STORAGE));
    let mut pass = graph.pass("ambient");
    let inputs = [gbuffer.base_color, gbuffer.depth];
    let light: [Option<Handle<Texture>>; 2] = std::array::from_fn(|i| light.get(i).copied());
    for input in inputs.into_iter().chain(light.into_iter().flatten()) {
        pass.read(input);
    }
    let ambient = pass.write(ambient);
    pass.key(&light.map(|light| light.is_some()));
    pass.execute(move |cx| {
        let [base_color, depth] = inputs.map(|handle| cx.view(handle));
        let gpu = cx.gpu;
        let [first, second] = light.map(|light| light.map_or_else(|| zero_texture(gpu, 1), |handle| cx.view(handle)));
        let target = cx.buffer(ambient).clone();
        cx.dispatch(
            &ComputeKey::new("indirect/ambient.wgsl", "main"),
            &[
                ("base_color", Binding::Texture(&base_color)),
                ("depth", Binding::Texture(&depth)),
                ("first", Binding::Texture(&first)),
                ("second", Binding::Texture(&second)),
                ("ambient", Binding::Buffer(&target)),
            ],
            [1, 1, 1],
        )
    });
    ambient
}
