//! The sweep of one bounce through one cascade.

use super::directions::Directions;
use super::opacity::Obstacles;
use super::{BounceCount, Irradiance, Level};
use crate::gpu::{Binding, ComputeKey, Gpu, ShaderDef};
use crate::graph::{Buffer, BufferDesc, Graph, Handle, PassContext, PassError};
use crate::render::frame::Frame;
use crate::render::frame::linear_groups;
use crate::render::indirect::light_volumes::volume::Volume;
use crate::world::Precision;
use bytemuck::{Pod, Zeroable};
use encase::ShaderType;
use glam::{IVec3, UVec3, Vec3};
use wgpu::BufferUsages;

/// `Slice` of `indirect/light_volumes/sweep/transport.wgsl`.
#[derive(ShaderType, Clone, Copy)]
pub(crate) struct SliceUniform {
    inner_low: IVec3,
    forward: i32,
    inner_size: IVec3,
    backward: i32,
    quarter: u32,
    before: u32,
    after: u32,
    brightest: f32,
}

/// `Sum` of `indirect/light_volumes/sweep/sum.wgsl`.
#[derive(ShaderType, Clone, Copy)]
pub(crate) struct SumUniform {
    bounce: u32,
    has_tail: u32,
    most: f32,
    padding: u32,
}

/// `Ordinate` of `indirect/light_volumes/sweep/transport.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Ordinate {
    direction: [f32; 4],
    border: [f32; 4],
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

/// What of a cascade's light is for others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kept {
    /// That of each bounce, until the next.
    Nothing,
    /// That of the only sweep.
    OneSweep,
    /// The sum over all bounces.
    Sum,
}

/// What enters the coarsest cascade from outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sky {
    /// Nothing.
    Dark,
    /// Radiance 1 from all directions.
    White,
    /// The scene's sky.
    Scene,
}

/// The buffers of a cascade.
pub(super) fn level(
    graph: &mut Graph<'_>,
    obstacles: Obstacles,
    name: &str,
    volume: &Volume,
    precision: Precision,
    kept: Kept,
) -> Level {
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
    let desc = |bytes: u64| BufferDesc::new(bytes * u64::from(volume.cell_count()), usage);
    let emission_bytes = 96 * u64::from(volume.cell_count()) + BRIGHTEST_BYTES;
    let emission = graph.buffer(format!("emission, {name}"), BufferDesc::new(emission_bytes, usage));
    let mut irradiance = |of: &str, is_retained: bool| {
        let mut buffer = |name: String, bytes: u64| match is_retained {
            true => graph.retained_buffer(name, desc(bytes)),
            false => graph.buffer(name, desc(bytes)),
        };
        Irradiance { axes: buffer(format!("axes{of}, {name}"), 72), facing: buffer(format!("facing{of}, {name}"), 36) }
    };
    // Debug views find what is kept by its name.
    let bounce = match kept {
        Kept::OneSweep => irradiance("", true),
        Kept::Nothing | Kept::Sum => irradiance(" of a bounce", false),
    };
    let sum = (kept == Kept::Sum).then(|| irradiance("", true));
    Level { name: name.to_owned(), volume: *volume, precision, obstacles, emission, bounce, sum, shell: None }
}

/// Bytes behind the emission of all cells: the brightest sources.
const BRIGHTEST_BYTES: u64 = 16;

/// Bytes of light on its way: RGB, and nothing.
fn light_bytes(precision: Precision) -> u64 {
    match precision {
        Precision::Single => 16,
        Precision::Half => 8,
    }
}

/// Bytes of a cell and direction of a front: light of both senses before and after a slice.
fn front_bytes(precision: Precision) -> u64 {
    4 * light_bytes(precision)
}

/// The most that they are: grids are the same in either precision.
pub(super) const FRONT_BYTES: u64 = 64;

/// Declares the sweep of a bounce through a cascade, and its addition to the sum of all bounces.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    directions: &Directions,
    levels: &mut [Level],
    totals: Option<Handle<Buffer>>,
    sky: Sky,
    step: Step,
) {
    let inner = step.index.checked_sub(1).map(|finer| levels[finer].volume);
    let level = &mut levels[step.index];
    let volume = level.volume;
    let name = format!("sweep, {}, bounce {}", level.name, step.bounce + 1);
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
    let precision = level.precision;
    let bytes = front_bytes(precision) * u64::from(directions.group()) * u64::from(largest_slice(&volume));
    let fronts = graph.buffer(format!("{name}, fronts"), BufferDesc::new(bytes, usage));
    let outer = level.shell.take();
    let shell = inner.map(|inner| Shell::new(graph, &name, level, &inner, directions));
    let mut pass = graph.pass(name);
    let totals = totals.filter(|_| level.sum.is_some());
    let inputs = [level.obstacles.opacity, level.emission].into_iter().chain(totals).chain(outer.into_iter().flatten());
    inputs.for_each(|buffer| pass.read(buffer));
    let mut written = |light: &mut Irradiance| {
        *light = Irradiance { axes: pass.write(light.axes), facing: pass.write(light.facing) };
        *light
    };
    let (bounce, sum) = (written(&mut level.bounce), level.sum.as_mut().map(written));
    let buffers = Buffers {
        precision,
        opacity: level.obstacles.opacity,
        emission: level.emission,
        bounce,
        sum: sum.zip(totals),
        fronts: pass.write(fronts),
        outer,
        inner: shell.map(|shell| Shell { light: shell.light.map(|light| pass.write(light)), ..shell }),
    };
    if let Some(inner) = &buffers.inner {
        levels[step.index - 1].shell = Some(inner.light);
    }
    let border = match sky {
        Sky::White => Vec3::ONE,
        Sky::Scene => frame.scene.sky,
        Sky::Dark => Vec3::ZERO,
    };
    let map = frame.scene.sky_map.as_deref().filter(|_| sky == Sky::Scene);
    let sky = (border.to_array().map(f32::to_bits), map.map(|map| (map.id, map.turn.to_bits())));
    let inner_key = inner.map(|inner| inner.key());
    pass.key(&(volume.key(), inner_key, directions.key(), sky, step.bounce, step.bounces, precision));
    let map = map.and(frame.scene.sky_map.as_ref()).cloned();
    let directions = directions.clone();
    pass.execute(move |cx| {
        let border = match &map {
            Some(map) => directions.sky(map),
            None => vec![border.extend(0.0).to_array(); directions.values.len()],
        };
        sweep(cx, &volume, &directions, &buffers, &border)?;
        match buffers.sum {
            Some((sum, totals)) => add(cx, buffers.bounce, sum, totals, step),
            None => Ok(()),
        }
    });
}

struct Buffers {
    precision: Precision,
    opacity: Handle<Buffer>,
    emission: Handle<Buffer>,
    bounce: Irradiance,
    /// The sum over all bounces, and the flux of each.
    sum: Option<(Irradiance, Handle<Buffer>)>,
    fronts: Handle<Buffer>,
    /// Light of the shell around this cascade, by axis.
    outer: Option<[Handle<Buffer>; 3]>,
    /// The shell around the next finer one.
    inner: Option<Shell>,
}

/// The cells of a cascade around the next finer one, whose light enters that one.
#[derive(Clone, Copy)]
struct Shell {
    /// First cell that the finer cascade covers.
    low: IVec3,
    /// How many it covers.
    size: IVec3,
    /// Light of the cells, for the directions of each axis.
    light: [Handle<Buffer>; 3],
}

impl Shell {
    fn new(graph: &mut Graph<'_>, name: &str, level: &Level, inner: &Volume, directions: &Directions) -> Self {
        let volume = &level.volume;
        let low = ((inner.origin - volume.origin) / volume.cell).round().as_ivec3();
        let size = inner.cells.as_ivec3() / 2;
        let bytes = shell_places(size.as_uvec3(), directions) * light_bytes(level.precision);
        let desc = BufferDesc::new(bytes, BufferUsages::STORAGE);
        let light = [0, 1, 2].map(|axis| graph.buffer(format!("{name}, shell along axis {axis}"), desc.clone()));
        Self { low, size, light }
    }
}

/// The most bytes of the light of a shell around so many cells, for the directions of one axis.
pub(super) fn shell_bytes(inner: UVec3, directions: &Directions) -> u64 {
    shell_places(inner, directions) * light_bytes(Precision::Single)
}

/// Places of such a shell.
fn shell_places(inner: UVec3, directions: &Directions) -> u64 {
    let n = inner.as_u64vec3() + 2;
    2 * (n.x * n.y + n.y * n.z + n.z * n.x) * 2 * u64::from(directions.group())
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
    let handles = [buffers.opacity, buffers.emission, buffers.bounce.axes, buffers.bounce.facing, buffers.fronts];
    let [opacity, emission, axes, facing, fronts] = handles.map(|handle| cx.buffer(handle).clone());
    for buffer in [&axes, &facing] {
        cx.encoder().clear_buffer(buffer, 0, None);
    }
    let uniform = cx.gpu.uniform("volume", &volume.uniform());
    let ordinates = directions.values.iter().zip(border).map(|(&direction, &border)| Ordinate { direction, border });
    let ordinates = cx.gpu.storage("ordinates", &ordinates.collect::<Vec<_>>(), BufferUsages::empty());
    let half = (fronts.size() / light_bytes(buffers.precision) / 2) as u32;
    let brightest = border.iter().flat_map(|light| &light[..3]).fold(0.0, |most: f32, &light| most.max(light));
    for axis in 0..3 {
        let along = volume.cells[axis];
        let across = [volume.cells[(axis + 1) % 3], volume.cells[(axis + 2) % 3]];
        let mut key = ComputeKey::new("indirect/light_volumes/sweep/transport.wgsl", "main")
            .def("AXIS", ShaderDef::Int(axis as i32));
        let outer = buffers.outer.map(|shell| cx.buffer(shell[axis]).clone());
        let inner = buffers.inner.map(|shell| cx.buffer(shell.light[axis]).clone());
        if buffers.precision == Precision::Half {
            key = key.def("HALF", ShaderDef::Flag(true));
        }
        for (name, shell) in [("NO_OUTER", &outer), ("NO_INNER", &inner)] {
            if shell.is_none() {
                key = key.def(name, ShaderDef::Flag(true));
            }
        }
        // Both senses go on in one dispatch. They must not add to the same slice: where the number of slices is odd
        // they would meet in the middle, and the second sense starts one later.
        let late = along % 2;
        for step in 0..=along + late {
            let turn = step % 2;
            let slice = SliceUniform {
                inner_low: buffers.inner.map_or(IVec3::ZERO, |shell| shell.low),
                forward: if step <= along { step as i32 } else { -1 },
                inner_size: buffers.inner.map_or(IVec3::ZERO, |shell| shell.size),
                backward: step as i32 - late as i32,
                quarter: directions.quarter,
                before: turn * half,
                after: (1 - turn) * half,
                brightest,
            };
            let slice = cx.gpu.uniform("slice", &slice);
            let mut bindings = vec![
                ("volume", Binding::Buffer(&uniform)),
                ("slice", Binding::Buffer(&slice)),
                ("ordinates", Binding::Buffer(&ordinates)),
                ("opacity", Binding::Buffer(&opacity)),
                ("emission", Binding::Buffer(&emission)),
                ("fronts", Binding::Buffer(&fronts)),
                ("axes", Binding::Buffer(&axes)),
                ("facing", Binding::Buffer(&facing)),
            ];
            bindings.extend(outer.iter().map(|shell| ("outer_shell", Binding::Buffer(shell))));
            bindings.extend(inner.iter().map(|shell| ("inner_shell", Binding::Buffer(shell))));
            cx.dispatch(&key, &bindings, [across[0].div_ceil(8), across[1].div_ceil(8), 2])?;
        }
        // A submit stays short even for the largest grids.
        cx.submit();
    }
    cx.counts().cells += u64::from(volume.cell_count()) * directions.values.len() as u64;
    Ok(())
}

/// Adds a bounce to the sum.
fn add(
    cx: &mut PassContext,
    bounce: Irradiance,
    sum: Irradiance,
    totals: Handle<Buffer>,
    step: Step,
) -> Result<(), PassError> {
    let handles = [totals, bounce.axes, bounce.facing, sum.axes, sum.facing];
    let [totals, axes, facing, all_axes, all_facing] = handles.map(|handle| cx.buffer(handle).clone());
    if step.bounce == 0 {
        for buffer in [&all_axes, &all_facing] {
            cx.encoder().clear_buffer(buffer, 0, None);
        }
    }
    let numbers = (all_axes.size() / 4) as u32;
    cx.dispatch(
        &ComputeKey::new("indirect/light_volumes/sweep/sum.wgsl", "main"),
        &[
            ("sum", Binding::Buffer(&sum_uniform(cx.gpu, step))),
            ("totals", Binding::Buffer(&totals)),
            ("axes", Binding::Buffer(&axes)),
            ("facing", Binding::Buffer(&facing)),
            ("all_axes", Binding::Buffer(&all_axes)),
            ("all_facing", Binding::Buffer(&all_facing)),
        ],
        linear_groups(numbers),
    )
}

/// `Sum` of `indirect/light_volumes/sweep/sum.wgsl` for a bounce.
pub(super) fn sum_uniform(gpu: &Gpu, step: Step) -> wgpu::Buffer {
    let Step { bounce, bounces, .. } = step;
    let has_tail = u32::from(bounces.has_tail && bounce + 1 == bounces.swept);
    gpu.uniform("sum", &SumUniform { bounce, has_tail, most: LARGEST_RATIO, padding: 0 })
}
