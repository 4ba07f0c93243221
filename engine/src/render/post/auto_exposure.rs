//! The exposure that suits an image: its log-average luminance becomes middle grey (Reinhard et al. 2002, eq. 1 and 2).

use crate::gpu::ComputeKey;
use crate::graph::{Buffer, BufferDesc, Graph, Handle, Texture};

/// Declares the pass; the result is the factor of the exposure.
pub fn declare(graph: &mut Graph, radiance: Handle<Texture>) -> Handle<Buffer> {
    let factor = graph.retained_buffer("auto exposure", BufferDesc::new(16, wgpu::BufferUsages::STORAGE));
    let mut pass = graph.compute("auto exposure", ComputeKey::new("post/auto_exposure.wgsl", "main"));
    pass.read("radiance", radiance);
    let factor = pass.write("factor", factor);
    pass.dispatch_groups([1, 1, 1]);
    factor
}
