//! Work for each texel of reflective shadow maps, which both ways of transport begin with.

use super::volume::Volume;
use crate::gpu::{Binding, ComputeKey};
use crate::graph::{PassContext, PassError};
use crate::render::scene_gpu::light_uniform::LightUniform;
use crate::render::shadows::reflective::Rsm;
use std::ops::Range;

/// Runs an entry point for each texel of some layers of an RSM, into a buffer of fixed-point sums.
pub(super) fn dispatch_texels(
    cx: &mut PassContext,
    key: &ComputeKey,
    rsm: &Rsm,
    layers: Range<usize>,
    volume: &Volume,
    fixed: &wgpu::Buffer,
    scale: f32,
) -> Result<(), PassError> {
    dispatch_rsm(cx, key, rsm, layers, volume, scale, &[("fixed", Binding::Buffer(fixed))])
}

/// Runs an entry point for each texel of some layers of an RSM, with further bindings.
pub(super) fn dispatch_rsm(
    cx: &mut PassContext,
    key: &ComputeKey,
    rsm: &Rsm,
    layers: Range<usize>,
    volume: &Volume,
    scale: f32,
    more: &[(&str, Binding)],
) -> Result<(), PassError> {
    let gpu = cx.gpu;
    let volume = gpu.uniform("volume", &volume.uniform());
    let light = LightUniform::buffer(gpu, rsm.light);
    let [base_color, normal, depth] = [rsm.base_color, rsm.normal, rsm.depth].map(|handle| cx.view(handle));
    let groups = rsm.size.div_ceil(8);
    cx.counts().injections += layers.len() as u64 * rsm.layer_texels();
    for layer in layers {
        let layer = gpu.uniform("rsm", &rsm.layer_uniform(layer, scale));
        let mut bindings = vec![
            ("volume", Binding::Buffer(&volume)),
            ("light", Binding::Buffer(&light)),
            ("rsm", Binding::Buffer(&layer)),
            ("base_color", Binding::Texture(&base_color)),
            ("normal", Binding::Texture(&normal)),
            ("depth", Binding::Texture(&depth)),
        ];
        bindings.extend_from_slice(more);
        cx.dispatch(key, &bindings, [groups, groups, 1])?;
    }
    Ok(())
}
