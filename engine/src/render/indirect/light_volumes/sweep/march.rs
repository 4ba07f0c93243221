//! The dispatches of a sweep: directions march through the grid in rounds, and what arrives is summed up.

use super::Irradiance;
use super::directions::Directions;
use super::grid::BINDING;
use super::shell::Shell;
use crate::gpu::{Binding, ComputeKey, Gpu, ShaderDef};
use crate::graph::{Buffer, Handle, PassContext, PassError};
use crate::render::frame::linear_groups;
use crate::render::indirect::light_volumes::volume::Volume;
use crate::world::Precision;
use bytemuck::{Pod, Zeroable};
use encase::ShaderType;
use glam::IVec3;
use std::ops::Range;

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

/// `Ordinate` of `indirect/light_volumes/sweep/transport.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Ordinate {
    direction: [f32; 4],
    border: [f32; 4],
}

/// Resources of a sweep.
pub(super) struct Buffers {
    pub(super) precision: Precision,
    pub(super) opacity: Handle<Buffer>,
    pub(super) emission: Handle<Buffer>,
    /// Whether media take light away, and are sources.
    pub(super) has_media: bool,
    pub(super) bounce: Irradiance,
    /// The sum over all bounces, and the flux of each.
    pub(super) sum: Option<(Irradiance, Handle<Buffer>)>,
    pub(super) fronts: Handle<Buffer>,
    /// Radiance that arrives at each cell along each direction.
    pub(super) arrivals: Handle<Buffer>,
    /// Light of the shell around this cascade, by axis.
    pub(super) outer: Option<[Handle<Buffer>; 3]>,
    /// The shell around the next finer one.
    pub(super) inner: Option<Shell>,
}

/// Bytes of radiance in flight: RGB, and nothing.
pub(super) fn light_bytes(precision: Precision) -> u64 {
    match precision {
        Precision::Single => 16,
        Precision::Half => 8,
    }
}

/// Directions whose radiance is in flight at once: as many as the portable size of a binding holds, which is all of them
/// for grids of middle size. They go through the grid in rounds.
pub(super) fn directions_a_round(volume: &Volume, directions: &Directions, precision: Precision) -> u32 {
    let columns = 2 * u64::from(largest_slice(volume));
    let fitting = BINDING / (columns.max(u64::from(volume.cell_count())) * light_bytes(precision));
    fitting.clamp(1, directions.values.len() as u64) as u32
}

/// Directions that one workgroup takes through the grid. They share what is read of a cell, so that few processors do best
/// with few workgroups, and graphics cards with many. It divides those of a quadrant.
fn directions_a_workgroup(gpu: &Gpu, quarter: u32, most: u32) -> u32 {
    let wanted = if gpu.is_software() { quarter } else { 2 };
    (1..=wanted.min(most)).rev().find(|chunk| quarter.is_multiple_of(*chunk)).unwrap_or(1)
}

/// Cells of the largest slice of a volume across an axis.
pub(super) fn largest_slice(volume: &Volume) -> u32 {
    let n = volume.cells;
    (n.x * n.y).max(n.y * n.z).max(n.z * n.x)
}

/// Takes all directions through the grid, in rounds, and sums up what arrives at each cell.
pub(super) fn sweep(
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
        cx.work(u64::from(end - first), u64::from(a_round))?;
        work.round(cx, first..end)?;
    }
    cx.counts().cells += u64::from(volume.cell_count()) * directions.values.len() as u64;
    Ok(())
}

/// Shared inputs of all dispatches of a sweep.
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
        let Buffers { precision, opacity, emission, has_media, fronts, arrivals: kept, outer, inner, .. } =
            self.buffers;
        let [opacity, emission, fronts, kept] =
            [opacity, emission, fronts, kept].map(|handle| cx.buffer(*handle).clone());
        let outer = outer.map(|shell| cx.buffer(shell[axis]).clone());
        let inner_shell = inner.map(|shell| cx.buffer(shell.light[axis]).clone());
        let mut key = ComputeKey::new("indirect/light_volumes/sweep/transport.wgsl", "main")
            .def("AXIS", ShaderDef::Int(axis as i32));
        let flags = [
            ("HALF", *precision == Precision::Half),
            ("NO_OUTER", outer.is_none()),
            ("NO_INNER", inner.is_none()),
            ("HAZE", *has_media),
        ];
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
        let Buffers { precision, opacity, emission, has_media, bounce, arrivals, .. } = self.buffers;
        let handles = [*opacity, *emission, *arrivals, bounce.axes, bounce.facing];
        let [opacity, emission, arrivals, axes, facing] = handles.map(|handle| cx.buffer(handle).clone());
        let mut key = ComputeKey::new("indirect/light_volumes/sweep/collect.wgsl", "main");
        if *precision == Precision::Half {
            key = key.def("HALF", ShaderDef::Flag(true));
        }
        if *has_media {
            key = key.def("HAZE", ShaderDef::Flag(true));
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
