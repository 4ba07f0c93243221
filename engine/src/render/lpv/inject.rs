//! Injection of light from reflective shadow maps into a volume.

use super::volume::Volume;
use super::{LIGHT_BYTES, linear_groups};
use crate::gpu::{Binding, ComputeKey};
use crate::graph::{Buffer, BufferDesc, Graph, Handle, PassContext, PassError};
use crate::render::frame::Frame;
use crate::render::light_uniform::LightUniform;
use crate::render::rsm::Rsm;
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
    let gpu = cx.gpu;
    let volume_uniform = gpu.uniform("volume", &volume.uniform());
    let light = LightUniform::buffer(gpu, rsm.light, rsm.index);
    let scale = rsm.fixed_point_scale();
    let (fixed, injected) = (cx.buffer(fixed).clone(), cx.buffer(injected).clone());
    cx.encoder().clear_buffer(&fixed, 0, None);
    let (base_color, normal, depth) = rsm_views(cx, rsm);
    let groups = rsm.size.div_ceil(8);
    let mut layer_uniform = gpu.uniform("rsm", &rsm.layer_uniform(0, scale));
    for layer in 0..rsm.views.len() {
        layer_uniform = gpu.uniform("rsm", &rsm.layer_uniform(layer, scale));
        cx.dispatch(
            &ComputeKey::new("lpv/inject.wgsl", "inject"),
            &[
                ("volume", Binding::Buffer(&volume_uniform)),
                ("light", Binding::Buffer(&light)),
                ("rsm", Binding::Buffer(&layer_uniform)),
                ("base_color", Binding::Texture(&base_color)),
                ("normal", Binding::Texture(&normal)),
                ("depth", Binding::Texture(&depth)),
                ("fixed", Binding::Buffer(&fixed)),
            ],
            [groups, groups, 1],
        )?;
    }
    let counts = cx.counts();
    counts.injections += rsm.texels();
    counts.lights += 1;
    counts.cells += u64::from(volume.cell_count());
    cx.dispatch(
        &ComputeKey::new("lpv/inject.wgsl", "add_to_volume"),
        &[
            ("volume", Binding::Buffer(&volume_uniform)),
            ("rsm", Binding::Buffer(&layer_uniform)),
            ("fixed", Binding::Buffer(&fixed)),
            ("injected", Binding::Buffer(&injected)),
        ],
        linear_groups(12 * volume.cell_count()),
    )
}

/// The three targets of an RSM with all their layers.
pub(super) fn rsm_views(cx: &PassContext, rsm: &Rsm) -> (wgpu::TextureView, wgpu::TextureView, wgpu::TextureView) {
    let layered = |handle| {
        cx.texture(handle).create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        })
    };
    (layered(rsm.base_color), layered(rsm.normal), layered(rsm.depth))
}
