//! One irradiance for all, from what the visible surfaces receive.

use super::gbuffer::GBuffer;
use crate::gpu::{Binding, ComputeKey};
use crate::graph::{Buffer, BufferDesc, Graph, Handle, Texture};
use wgpu::BufferUsages;

/// Declares the pass; the result is the mean indirect irradiance of the visible surfaces [W/m²].
pub fn declare<'a>(graph: &mut Graph<'a>, gbuffer: &GBuffer, indirect: Handle<Texture>) -> Handle<Buffer> {
    let ambient = graph.retained_buffer("ambient irradiance", BufferDesc::new(16, BufferUsages::STORAGE));
    let mut pass = graph.pass("ambient");
    let inputs = [gbuffer.base_color, gbuffer.depth, indirect];
    for input in inputs {
        pass.read(input);
    }
    let ambient = pass.write(ambient);
    pass.key(&());
    pass.execute(move |cx| {
        let [base_color, depth, indirect] = inputs.map(|handle| cx.view(handle));
        let target = cx.buffer(ambient).clone();
        cx.dispatch(
            &ComputeKey::new("ambient.wgsl", "main"),
            &[
                ("base_color", Binding::Texture(&base_color)),
                ("depth", Binding::Texture(&depth)),
                ("indirect", Binding::Texture(&indirect)),
                ("ambient", Binding::Buffer(&target)),
            ],
            [1, 1, 1],
        )
    });
    ambient
}
