//! The sweep of one bounce through one cascade: its buffers and its pass. `march` holds the dispatches.

use super::bounce_sum;
use super::directions::Directions;
use super::march::{self, Buffers, directions_a_round, largest_slice, light_bytes};
use super::opacity::Obstacles;
use super::shell::Shell;
use super::{BounceCount, Irradiance, Level};
use crate::graph::{Buffer, BufferDesc, Graph, Handle};
use crate::render::frame::Frame;
use crate::render::indirect::light_volumes::volume::Volume;
use crate::scene::SceneMedium;
use crate::world::Precision;
use glam::Vec3;
use wgpu::BufferUsages;

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

/// Results of a cascade's transport that are kept for other passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kept {
    /// That of each bounce, until the next.
    Nothing,
    /// That of the only sweep.
    OneSweep,
    /// The sum over all bounces.
    Sum,
}

/// Light that enters the coarsest cascade from outside.
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
    Level {
        name: name.to_owned(),
        volume: *volume,
        precision,
        obstacles,
        emission,
        lamp_light: None,
        bounce,
        sum,
        shell: None,
    }
}

/// Bytes behind the emission of all cells: the brightest sources.
const BRIGHTEST_BYTES: u64 = 16;

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
    // By hand: the light of the sky by direction is looked up in its map only when the sweep runs, and the rounds follow from
    // the device.
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
        has_media: level.lamp_light.is_some(),
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
    let sky_is_seen = sky == Sky::Scene;
    let map = frame.scene.sky_map.as_deref().filter(|_| sky_is_seen);
    let sky = (border.to_array().map(f32::to_bits), map.map(|map| (map.id, map.turn.to_bits())));
    let inner_key = inner.map(|inner| inner.key());
    pass.key(&(volume.key(), inner_key, directions.key(), sky, step.bounce, step.bounces, precision));
    pass.key(&(buffers.has_media, sky_is_seen.then(|| frame.media_key())));
    let map = map.and(frame.scene.sky_map.as_ref()).cloned();
    let directions = directions.clone();
    let media = if sky_is_seen { frame.scene.media.clone() } else { Vec::new() };
    pass.execute(move |cx| {
        let mut border = match &map {
            Some(map) => directions.sky(map),
            None => vec![border.extend(0.0).to_array(); directions.values.len()],
        };
        if !media.is_empty() {
            through_media(&mut border, &media, &volume, &directions);
        }
        march::sweep(cx, &volume, &directions, &buffers, &border)?;
        match buffers.sum {
            Some((sum, totals)) => bounce_sum::add(cx, buffers.bounce, sum, totals, step),
            None => Ok(()),
        }
    });
}

/// What media before the sky let pass of it, to the middle of the volume.
fn through_media(border: &mut [[f32; 4]], media: &[SceneMedium], volume: &Volume, directions: &Directions) {
    let bounds = volume.bounds();
    let middle = 0.5 * (bounds.min + bounds.max);
    for (light, [x, y, z, _]) in border.iter_mut().zip(&directions.values) {
        let toward = -Vec3::new(*x, *y, *z);
        let passing: f32 = media.iter().map(|medium| medium.passes_from_afar(middle, toward)).product();
        light[..3].iter_mut().for_each(|channel| *channel *= passing);
    }
}
