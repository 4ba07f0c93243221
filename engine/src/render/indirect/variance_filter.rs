//! The à-trous filter over the mean of frames, as wide as the variance that is left allows. See `indirect/variance_filter.wgsl`.

use crate::gpu::ComputeKey;
use crate::graph::{Graph, Handle, Texture};
use crate::render::frame::{Frame, ViewUniform};
use crate::render::geometry::gbuffer::GBuffer;
use encase::ShaderType;

/// Distances between the taps of both levels \[pixels\], in images that are at least 512 pixels high. Lower ones show as much of
/// the scene in fewer pixels, and so do their filters.
const STRIDES: [u32; 2] = [3, 8];
const FULL_HEIGHT: u32 = 512;

/// `VarianceFilter` of `indirect/variance_filter.wgsl`.
#[derive(ShaderType)]
pub(crate) struct VarianceFilterUniform {
    view: ViewUniform,
    stride: i32,
}

/// Declares the levels of the filter; the result is radiance [W/(m² sr)]. `averaged` is the mean of frames: its alpha holds the
/// standard deviation of the luminance of light over reflectance.
pub(in crate::render) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    averaged: Handle<Texture>,
) -> Handle<Texture> {
    let [fine, coarse] = STRIDES.map(|stride| stride_of(stride, frame.view.size[1]));
    let names = ["indirect radiance, filtered over few pixels", "filtered indirect radiance"];
    let between = graph.texture(names[0], frame.image_desc());
    let result = graph.retained_texture(names[1], frame.image_desc());
    let between = level(graph, frame, gbuffer, ("variance filter, fine", fine), [averaged, between]);
    level(graph, frame, gbuffer, ("variance filter, coarse", coarse), [between, result])
}

fn stride_of(stride: u32, height: u32) -> i32 {
    (stride * height.min(FULL_HEIGHT) / FULL_HEIGHT).max(1) as i32
}

fn level<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
    (name, stride): (&'static str, i32),
    [noisy, filtered]: [Handle<Texture>; 2],
) -> Handle<Texture> {
    let mut pass = graph.compute(name, ComputeKey::new("indirect/variance_filter.wgsl", "main"));
    pass.uniform("variance_filter", &VarianceFilterUniform { view: frame.view_values(), stride });
    gbuffer.bind(&mut pass);
    pass.read("noisy", noisy);
    let filtered = pass.write("filtered", filtered);
    pass.dispatch_over(frame.view.size);
    filtered
}
