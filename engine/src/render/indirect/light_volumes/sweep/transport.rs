//! The sweep of one bounce through one cascade.

use super::directions::Directions;
use super::grid::BINDING;
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
use std::ops::Range;
use wgpu::BufferUsages;

/// `March` of `indirect/light_volumes/sweep/transport.wgsl`.
#[derive(ShaderType, Clone, Copy)]
pub(crate) struct MarchUniform {
    inner_low: IVec3,
    quarter: u32,
    inner_size: IVec3,
    chunk: u32,
    first: u32,
    arrivals: u32,
    turn: u32,
    brightest: f32,
}

/// `Part` of `indirect/light_volumes/sweep/collect.wgsl`.
#[derive(ShaderType, Clone, Copy, Default)]
pub(crate) struct PartUniform {
    first: u32,
    end: u32,
    arrivals: u32,
    padding: u32,
}

/// `Collect` of `indirect/light_volumes/sweep/collect.wgsl`.
#[derive(ShaderType, Clone, Copy)]
pub(crate) struct CollectUniform {
    parts: [PartUniform; 3],
    quarter: u32,
    is_first: u32,
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

/// Directions whose light is on its way at once: as many as the portable size of a binding holds, which is all of them
/// for grids of middle size. They go through the grid in rounds.
fn directions_a_round(volume: &Volume, directions: &Directions, precision: Precision) -> u32 {
    let columns = 2 * u64::from(largest_slice(volume));
    let fitting = BINDING / (columns.max(u64::from(volume.cell_count())) * light_bytes(precision));
    fitting.clamp(1, directions.values.len() as u64) as u32
}

/// Directions that one workgroup takes through the grid. They share what is read of a cell, so that few processors do best
/// with few workgroups, and graphics cards with many. It divides those of a quadrant.
fn directions_a_workgroup(gpu: &Gpu, quarter: u32, most: u32) -> u32 {
    let wanted = if gpu.info.device_type == wgpu::DeviceType::Cpu { quarter } else { 2 };
    (1..=wanted.min(most)).rev().find(|chunk| quarter.is_multiple_of(*chunk)).unwrap_or(1)
}

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
    let at_once = u64::from(directions_a_round(&volume, directions, precision)) * light_bytes(precision);
    let fronts = BufferDesc::new(2 * at_once * u64::from(largest_slice(&volume)), usage);
    let fronts = graph.buffer(format!("{name}, fronts"), fronts);
    let arrivals = BufferDesc::new(at_once * u64::from(volume.cell_count()), usage);
    let arrivals = graph.buffer(format!("{name}, arrivals"), arrivals);
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
        arrivals: pass.write(arrivals),
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
    /// What arrives at each cell along each direction.
    arrivals: Handle<Buffer>,
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
    let ordinates = directions.values.iter().zip(border).map(|(&direction, &border)| Ordinate { direction, border });
    let most = directions_a_round(volume, directions, buffers.precision);
    let work = Work {
        volume,
        directions,
        buffers,
        uniform: cx.gpu.uniform("volume", &volume.uniform()),
        ordinates: cx.gpu.constants("ordinates", &ordinates.collect::<Vec<_>>()),
        brightest: border.iter().flat_map(|light| &light[..3]).fold(0.0, |most: f32, &light| most.max(light)),
        chunk: directions_a_workgroup(cx.gpu, directions.quarter, most),
    };
    let all = 3 * work.workgroups_an_axis();
    let a_round = (most / work.chunk).max(1);
    for first in (0..all).step_by(a_round as usize) {
        let end = all.min(first + a_round);
        // A submit stays short even for the largest grids.
        cx.work(u64::from(end - first), u64::from(a_round));
        work.round(cx, first..end)?;
    }
    cx.counts().cells += u64::from(volume.cell_count()) * directions.values.len() as u64;
    Ok(())
}

/// What all dispatches of a sweep share.
struct Work<'a> {
    volume: &'a Volume,
    directions: &'a Directions,
    buffers: &'a Buffers,
    uniform: wgpu::Buffer,
    ordinates: wgpu::Buffer,
    /// Radiance of the brightest direction beyond the border [W/(m² sr)].
    brightest: f32,
    /// Directions of a workgroup.
    chunk: u32,
}

impl Work<'_> {
    /// Workgroups for all directions of an axis, of both senses.
    fn workgroups_an_axis(&self) -> u32 {
        8 * self.directions.quarter / self.chunk
    }

    /// Takes the directions of some workgroups through the grid, counted over all axes, and sums up what arrives.
    fn round(&self, cx: &mut PassContext, groups: Range<u32>) -> Result<(), PassError> {
        let an_axis = self.workgroups_an_axis();
        let mut parts = [PartUniform::default(); 3];
        for (axis, part) in (0..3).zip(&mut parts) {
            let first = (groups.start.max(axis * an_axis)) - axis * an_axis;
            let end = groups.end.clamp(axis * an_axis, (axis + 1) * an_axis) - axis * an_axis;
            if first >= end {
                continue;
            }
            let before = (axis * an_axis + first - groups.start) * self.chunk;
            let arrivals = before * self.volume.cell_count();
            *part = PartUniform { first: first * self.chunk, end: end * self.chunk, arrivals, padding: 0 };
            self.march(cx, axis as usize, first..end, arrivals)?;
        }
        self.collect(cx, parts, groups.start == 0)
    }

    /// Takes the directions of some workgroups of an axis through the grid.
    fn march(&self, cx: &mut PassContext, axis: usize, groups: Range<u32>, arrivals: u32) -> Result<(), PassError> {
        let Buffers { precision, opacity, emission, fronts, arrivals: kept, outer, inner, .. } = self.buffers;
        let [opacity, emission, fronts, kept] =
            [opacity, emission, fronts, kept].map(|handle| cx.buffer(*handle).clone());
        let outer = outer.map(|shell| cx.buffer(shell[axis]).clone());
        let inner_shell = inner.map(|shell| cx.buffer(shell.light[axis]).clone());
        let mut key = ComputeKey::new("indirect/light_volumes/sweep/transport.wgsl", "main")
            .def("AXIS", ShaderDef::Int(axis as i32));
        let flags =
            [("HALF", *precision == Precision::Half), ("NO_OUTER", outer.is_none()), ("NO_INNER", inner.is_none())];
        for (name, _) in flags.into_iter().filter(|(_, set)| *set) {
            key = key.def(name, ShaderDef::Flag(true));
        }
        let march = MarchUniform {
            inner_low: inner.map_or(IVec3::ZERO, |shell| shell.low),
            quarter: self.directions.quarter,
            inner_size: inner.map_or(IVec3::ZERO, |shell| shell.size),
            chunk: self.chunk,
            first: groups.start,
            arrivals,
            turn: (fronts.size() / light_bytes(*precision) / 2) as u32,
            brightest: self.brightest,
        };
        let march = cx.gpu.uniform("march", &march);
        let mut bindings = vec![
            ("volume", Binding::Buffer(&self.uniform)),
            ("march", Binding::Buffer(&march)),
            ("ordinates", Binding::Buffer(&self.ordinates)),
            ("opacity", Binding::Buffer(&opacity)),
            ("emission", Binding::Buffer(&emission)),
            ("fronts", Binding::Buffer(&fronts)),
            ("arrivals", Binding::Buffer(&kept)),
        ];
        bindings.extend(outer.iter().map(|shell| ("outer_shell", Binding::Buffer(shell))));
        bindings.extend(inner_shell.iter().map(|shell| ("inner_shell", Binding::Buffer(shell))));
        cx.dispatch(&key, &bindings, [groups.end - groups.start, 1, 1])
    }

    /// Sums up what arrived.
    fn collect(&self, cx: &mut PassContext, parts: [PartUniform; 3], is_first: bool) -> Result<(), PassError> {
        let Buffers { precision, opacity, emission, bounce, arrivals, .. } = self.buffers;
        let handles = [*opacity, *emission, *arrivals, bounce.axes, bounce.facing];
        let [opacity, emission, arrivals, axes, facing] = handles.map(|handle| cx.buffer(handle).clone());
        let mut key = ComputeKey::new("indirect/light_volumes/sweep/collect.wgsl", "main");
        if *precision == Precision::Half {
            key = key.def("HALF", ShaderDef::Flag(true));
        }
        let (quarter, brightest) = (self.directions.quarter, self.brightest);
        let collect = CollectUniform { parts, quarter, is_first: u32::from(is_first), brightest };
        let collect = cx.gpu.uniform("collect", &collect);
        let bindings = [
            ("volume", Binding::Buffer(&self.uniform)),
            ("collect", Binding::Buffer(&collect)),
            ("ordinates", Binding::Buffer(&self.ordinates)),
            ("opacity", Binding::Buffer(&opacity)),
            ("emission", Binding::Buffer(&emission)),
            ("arrivals", Binding::Buffer(&arrivals)),
            ("axes", Binding::Buffer(&axes)),
            ("facing", Binding::Buffer(&facing)),
        ];
        cx.dispatch(&key, &bindings, linear_groups(self.volume.cell_count()))
    }
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
