//! The sweep of one bounce through one cascade.

use super::super::linear_groups;
use super::super::volume::Volume;
use super::directions::Directions;
use super::{BounceCount, Irradiance, Level};
use crate::gpu::{Binding, ComputeKey, Gpu, ShaderDef};
use crate::graph::{Buffer, BufferDesc, Graph, Handle, PassContext, PassError};
use crate::render::frame::Frame;
use encase::ShaderType;
use glam::Vec3;
use wgpu::BufferUsages;

/// `Slice` of `lpv/sweep/transport.wgsl`.
#[derive(ShaderType, Clone, Copy)]
pub(crate) struct SliceUniform {
    forward: i32,
    backward: i32,
    quarter: u32,
    padding: u32,
}

/// `Sum` of `lpv/sweep/sum.wgsl`.
#[derive(ShaderType, Clone, Copy)]
pub(crate) struct SumUniform {
    bounce: u32,
    has_tail: u32,
    most: f32,
    padding: u32,
}

/// Bound on the factor from one bounce to the next in the series that ends the sum.
const LARGEST_RATIO: f32 = 0.98;

/// One bounce of one cascade.
#[derive(Clone, Copy)]
pub(super) struct Step {
    /// The cascade.
    pub index: usize,
    /// 0: light straight from the lights.
    pub bounce: u32,
    /// Of so many.
    pub bounces: BounceCount,
}

/// The buffers of a cascade.
pub(super) fn level(graph: &mut Graph<'_>, opacity: Handle<Buffer>, name: &str, volume: &Volume) -> Level {
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
    let desc = |bytes: u64| BufferDesc::new(bytes * u64::from(volume.cell_count()), usage);
    let emission = graph.buffer(format!("emission, {name}"), desc(96));
    let bounce = Irradiance {
        // A bounce's holds what the cells took out of the light too.
        axes: graph.buffer(format!("axes of a bounce, {name}"), desc(76)),
        facing: graph.buffer(format!("facing of a bounce, {name}"), desc(36)),
    };
    let sum = Irradiance {
        axes: graph.retained_buffer(format!("axes, {name}"), desc(72)),
        facing: graph.retained_buffer(format!("facing, {name}"), desc(36)),
    };
    Level { name: name.to_owned(), volume: *volume, opacity, emission, bounce, sum }
}

/// Bytes of a cell and direction of a front: light of both senses, RGB and one unused number.
pub(super) const FRONT_BYTES: u64 = 32;

/// Declares the sweep of a bounce through a cascade, and its addition to the sum of all bounces.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    directions: &Directions,
    levels: &mut [Level],
    totals: Handle<Buffer>,
    step: Step,
) {
    let level = &mut levels[step.index];
    let volume = level.volume;
    let name = format!("sweep, {}, bounce {}", level.name, step.bounce + 1);
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
    let front_bytes = FRONT_BYTES * u64::from(directions.group()) * u64::from(largest_slice(&volume));
    let fronts = [0, 1].map(|i| graph.buffer(format!("{name}, front {i}"), BufferDesc::new(front_bytes, usage)));
    let mut pass = graph.pass(name);
    for buffer in [level.opacity, level.emission, totals] {
        pass.read(buffer);
    }
    let mut written = |handle: &mut Handle<Buffer>| {
        *handle = pass.write(*handle);
        *handle
    };
    let (bounce, sum) = (&mut level.bounce, &mut level.sum);
    let buffers = Buffers {
        opacity: level.opacity,
        emission: level.emission,
        totals,
        bounce: Irradiance { axes: written(&mut bounce.axes), facing: written(&mut bounce.facing) },
        sum: Irradiance { axes: written(&mut sum.axes), facing: written(&mut sum.facing) },
        fronts: fronts.map(|mut front| written(&mut front)),
    };
    let border = if step.bounce == 0 { frame.scene.sky } else { Vec3::ZERO };
    let map = frame.scene.sky_map.as_deref().filter(|_| step.bounce == 0);
    let sky = (border.to_array().map(f32::to_bits), map.map(|map| (map.id, map.turn.to_bits())));
    pass.key(&(volume.key(), directions.values.len(), sky, step.bounce, step.bounces));
    let map = map.and(frame.scene.sky_map.as_ref()).cloned();
    let directions = directions.clone();
    pass.execute(move |cx| {
        if step.bounce == 0 {
            for handle in [buffers.sum.axes, buffers.sum.facing] {
                let buffer = cx.buffer(handle).clone();
                cx.encoder().clear_buffer(&buffer, 0, None);
            }
        }
        let border = match &map {
            Some(map) => directions.sky(map),
            None => vec![border.extend(0.0).to_array(); directions.values.len()],
        };
        sweep(cx, &volume, &directions, &buffers, &border)?;
        add(cx, &buffers, step)
    });
}

struct Buffers {
    opacity: Handle<Buffer>,
    emission: Handle<Buffer>,
    totals: Handle<Buffer>,
    bounce: Irradiance,
    sum: Irradiance,
    fronts: [Handle<Buffer>; 2],
}

fn largest_slice(volume: &Volume) -> u32 {
    let n = volume.cells;
    (n.x * n.y).max(n.y * n.z).max(n.z * n.x)
}

fn sweep(
    cx: &mut PassContext,
    volume: &Volume,
    directions: &Directions,
    buffers: &Buffers,
    border: &[[f32; 4]],
) -> Result<(), PassError> {
    let handles = [buffers.opacity, buffers.emission, buffers.bounce.axes, buffers.bounce.facing];
    let [opacity, emission, axes, facing] = handles.map(|handle| cx.buffer(handle).clone());
    let fronts = buffers.fronts.map(|handle| cx.buffer(handle).clone());
    for buffer in [&axes, &facing] {
        cx.encoder().clear_buffer(buffer, 0, None);
    }
    let uniform = cx.gpu.uniform("volume", &volume.uniform());
    let set = cx.gpu.storage("directions", &directions.values, BufferUsages::empty());
    let border = cx.gpu.storage("border", border, BufferUsages::empty());
    for axis in 0..3 {
        let along = volume.cells[axis];
        let across = [volume.cells[(axis + 1) % 3], volume.cells[(axis + 2) % 3]];
        let key = ComputeKey::new("lpv/sweep/transport.wgsl", "main").def("AXIS", ShaderDef::Int(axis as i32));
        // Both senses go on in one dispatch. They must not add to the same slice: where the number of slices is odd
        // they would meet in the middle, and the second sense starts one later.
        let late = along % 2;
        for step in 0..=along + late {
            let slice = SliceUniform {
                forward: if step <= along { step as i32 } else { -1 },
                backward: step as i32 - late as i32,
                quarter: directions.quarter,
                padding: 0,
            };
            let slice = cx.gpu.uniform("slice", &slice);
            let turn = step as usize % 2;
            cx.dispatch(
                &key,
                &[
                    ("volume", Binding::Buffer(&uniform)),
                    ("slice", Binding::Buffer(&slice)),
                    ("directions", Binding::Buffer(&set)),
                    ("border", Binding::Buffer(&border)),
                    ("opacity", Binding::Buffer(&opacity)),
                    ("emission", Binding::Buffer(&emission)),
                    ("before", Binding::Buffer(&fronts[turn])),
                    ("after", Binding::Buffer(&fronts[1 - turn])),
                    ("axes", Binding::Buffer(&axes)),
                    ("facing", Binding::Buffer(&facing)),
                ],
                [across[0].div_ceil(8), across[1].div_ceil(8), 2],
            )?;
        }
        // A submit stays short even for the largest grids.
        cx.submit();
    }
    cx.counts().cells += u64::from(volume.cell_count()) * directions.values.len() as u64;
    Ok(())
}

fn add(cx: &mut PassContext, buffers: &Buffers, step: Step) -> Result<(), PassError> {
    let Irradiance { axes, facing } = buffers.bounce;
    let handles = [buffers.totals, axes, facing, buffers.sum.axes, buffers.sum.facing];
    let [totals, axes, facing, all_axes, all_facing] = handles.map(|handle| cx.buffer(handle).clone());
    let is_last = step.bounce + 1 == step.bounces.swept;
    let sum = sum_uniform(cx.gpu, step.bounce, is_last && step.bounces.has_tail);
    let numbers = (all_axes.size() / 4) as u32;
    cx.dispatch(
        &ComputeKey::new("lpv/sweep/sum.wgsl", "main"),
        &[
            ("sum", Binding::Buffer(&sum)),
            ("totals", Binding::Buffer(&totals)),
            ("axes", Binding::Buffer(&axes)),
            ("facing", Binding::Buffer(&facing)),
            ("all_axes", Binding::Buffer(&all_axes)),
            ("all_facing", Binding::Buffer(&all_facing)),
        ],
        linear_groups(numbers),
    )
}

fn sum_uniform(gpu: &Gpu, bounce: u32, has_tail: bool) -> wgpu::Buffer {
    gpu.uniform("sum", &SumUniform { bounce, has_tail: u32::from(has_tail), most: LARGEST_RATIO, padding: 0 })
}
