//! Injection of light from reflective shadow maps into a volume.

use super::LIGHT_BYTES;
use crate::gpu::{Binding, ComputeKey};
use crate::graph::{Buffer, BufferDesc, Graph, Handle, PassContext, PassError};
use crate::render::frame::Frame;
use crate::render::frame::linear_groups;
use crate::render::indirect::light_volumes::texels::dispatch_texels;
use crate::render::indirect::light_volumes::volume::Volume;
use crate::render::shadows::reflective::Rsm;
use wgpu::BufferUsages;

/// Declares the injection of all lights into one cascade: each in fixed point with a scale of its own, added in the
/// scene's order, so that the sum depends neither on the order of texels nor on the brightest light.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    rsms: &[Rsm<'a>],
    level: usize,
    volume: &Volume,
) -> Handle<Buffer> {
    let name = format!("inject, cascade {level}");
    let bytes = LIGHT_BYTES * u64::from(volume.cell_count());
    let desc = BufferDesc::new(bytes, BufferUsages::STORAGE | BufferUsages::COPY_DST);
    let fixed = graph.buffer(format!("{name}, fixed point"), desc.clone());
    let injected = graph.retained_buffer(name.as_str(), desc);
    let mut pass = graph.pass(name.as_str());
    for rsm in rsms {
        pass.read(rsm.base_color);
        pass.read(rsm.normal);
        pass.read(rsm.depth);
    }
    let (fixed, injected) = (pass.write(fixed), pass.write(injected));
    let lights: Vec<u64> = rsms.iter().map(|rsm| rsm.light.revision).collect();
    pass.key(&(volume.key(), lights, frame.scene.identity));
    let (rsms, volume) = (rsms.to_vec(), *volume);
    pass.execute(move |cx| {
        let target = cx.buffer(injected).clone();
        cx.encoder().clear_buffer(&target, 0, None);
        rsms.iter().try_for_each(|rsm| inject(cx, rsm, &volume, fixed, injected))
    });
    injected
}

fn inject(
    cx: &mut PassContext,
    rsm: &Rsm,
    volume: &Volume,
    fixed: Handle<Buffer>,
    injected: Handle<Buffer>,
) -> Result<(), PassError> {
    let scale = rsm.fixed_point_scale();
    let (fixed, injected) = (cx.buffer(fixed).clone(), cx.buffer(injected).clone());
    cx.encoder().clear_buffer(&fixed, 0, None);
    let key = ComputeKey::new("indirect/light_volumes/diffusion/inject.wgsl", "inject");
    dispatch_texels(cx, &key, rsm, 0..rsm.views.len(), volume, &fixed, scale)?;
    let counts = cx.counts();
    counts.lights += 1;
    counts.cells += u64::from(volume.cell_count());
    let volume_uniform = cx.gpu.uniform("volume", &volume.uniform());
    let layer = cx.gpu.uniform("rsm", &rsm.layer_uniform(0, scale));
    cx.dispatch(
        &ComputeKey::new("indirect/light_volumes/diffusion/inject.wgsl", "add_to_volume"),
        &[
            ("volume", Binding::Buffer(&volume_uniform)),
            ("rsm", Binding::Buffer(&layer)),
            ("fixed", Binding::Buffer(&fixed)),
            ("injected", Binding::Buffer(&injected)),
        ],
        linear_groups(12 * volume.cell_count()),
    )
}
