//! Light straight from the lights in each cell, for media to scatter. See `indirect/light_volumes/sweep/lamp_light.wgsl`.

use crate::gpu::{Binding, ComputeKey, ShaderDef};
use crate::graph::{Buffer, BufferDesc, Graph, Handle, PassContext};
use crate::render::direct::lamps::{Bound, Lamps};
use crate::render::frame::{Frame, linear_groups};
use crate::render::indirect::light_volumes::volume::Volume;
use wgpu::BufferUsages;

/// Bytes of a cell.
const CELL_BYTES: u64 = 48;

/// Declares the pass; the result is three vectors a cell. None where there are no media.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    name: &str,
    volume: &Volume,
) -> Option<Handle<Buffer>> {
    let lamps = Lamps::of(graph, frame)?;
    let name = format!("haze, {name}");
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
    let desc = BufferDesc::new(CELL_BYTES * u64::from(volume.cell_count()), usage);
    let light = graph.retained_buffer(name.clone(), desc);
    let mut pass = graph.pass(name);
    lamps.maps().for_each(|map| pass.read(map));
    let light = pass.write(light);
    pass.key(&(frame.media_key(), volume.key(), lamps.key()));
    let (frame, volume) = (frame.clone(), *volume);
    pass.execute(move |cx| {
        let buffer = cx.buffer(light).clone();
        let uniform = cx.gpu.uniform("volume", &volume.uniform());
        let media = frame.gpu_scene.media_binding(cx.gpu);
        let groups = linear_groups(volume.cell_count());
        cx.counts().cells += u64::from(volume.cell_count());
        let dispatch = |cx: &mut PassContext, lamps: Option<Bound>| {
            let key = ComputeKey::new("indirect/light_volumes/sweep/lamp_light.wgsl", "main");
            let mut key = frame.gpu_scene.with_media(key);
            if let Some(lamps) = &lamps {
                key = key.def("LIT", ShaderDef::Flag(true));
                key = lamps.define.into_iter().fold(key, |key, (name, value)| key.def(name, value));
            }
            if lamps.as_ref().is_some_and(|lamps| !lamps.is_first) {
                key = key.def("MORE", ShaderDef::Flag(true));
            }
            let mut group = vec![("volume", Binding::Buffer(&uniform)), ("lamp_light", Binding::Buffer(&buffer))];
            group.extend(media.iter().map(|(name, media)| (*name, Binding::Buffer(media))));
            group.extend(lamps.into_iter().flat_map(|lamps| lamps.bindings));
            cx.dispatch(&key, &group, groups)
        };
        match lamps.is_empty() {
            true => dispatch(cx, None),
            false => lamps.dispatch(cx, |cx, lamps| dispatch(cx, Some(lamps))),
        }
    });
    Some(light)
}
