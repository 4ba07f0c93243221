//! Indirect light at points that a game asks for: looked up as for the surfels of a bounce, in the sum over all bounces.

use super::irradiance::{Lookup, look_up, lookup_at_surfels};
use super::opacity::Obstacles;
use super::{Irradiance, Level, links};
use crate::graph::{Buffer, BufferDesc, Graph, Handle};
use crate::render::frame::Frame;
use crate::scene::{ProbePoint, Surfel};
use glam::{Vec3, Vec4};
use wgpu::BufferUsages;

/// Name of the buffer with what was found.
pub(crate) const PROBE_LIGHT: &str = "probe light";

/// The normals that a point is asked for: its own, or those of the six axes, whose mean stands for that over all.
fn normals(probe: &ProbePoint) -> Vec<Vec3> {
    const AXES: [Vec3; 6] = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
    match probe.normal {
        Some(normal) => vec![normal.normalize_or(Vec3::Y)],
        None => AXES.to_vec(),
    }
}

fn surfels(probes: &[ProbePoint]) -> Vec<Surfel> {
    let at = |probe: &ProbePoint, normal: Vec3| Surfel {
        position: probe.position.to_array(),
        normal: normal.to_array(),
        // The lookup passes over what has no area.
        area: 1.0,
        ..Surfel::default()
    };
    let usable = probes.iter().flat_map(|probe| normals(probe).into_iter().map(move |normal| at(probe, normal)));
    usable.map(|s| if s.position.iter().all(|x| x.is_finite()) { s } else { Surfel::default() }).collect()
}

/// Declares the look-up; the result is E [W/m²] for each normal of each point.
pub(super) fn declare<'a>(graph: &mut Graph<'a>, frame: &Frame<'a>, levels: &[Level]) -> Handle<Buffer> {
    let surfels = surfels(frame.probes);
    let count = surfels.len() as u32;
    let desc = BufferDesc::new(16 * u64::from(count), BufferUsages::STORAGE | BufferUsages::COPY_SRC);
    let found = graph.retained_buffer(PROBE_LIGHT, desc);
    let mut pass = graph.pass("probes");
    let light: Vec<Irradiance> = levels.iter().map(Level::light).collect();
    let obstacles: Vec<_> = levels.iter().map(|level| level.obstacles).collect();
    for (Irradiance { axes, facing }, Obstacles { opacity, coverage, .. }) in light.iter().zip(&obstacles) {
        [axes, facing, opacity, coverage].into_iter().for_each(|buffer| pass.read(*buffer));
    }
    let found = pass.write(found);
    let keys: Vec<_> = levels.iter().map(|level| level.volume.key()).collect();
    let places: Vec<u32> = bytemuck::cast_slice::<Surfel, u32>(&surfels).to_vec();
    pass.key(&(keys, places));
    let volumes: Vec<_> = levels.iter().map(|level| level.volume).collect();
    let lookups: Vec<_> = (0..levels.len()).map(|i| lookup_at_surfels(levels, i)).collect();
    pass.execute(move |cx| {
        let target = cx.buffer(found).clone();
        let surfels = cx.gpu.storage("probes", &surfels, BufferUsages::empty());
        let links = cx.gpu.storage("links of probes", &vec![0_u32; count as usize], BufferUsages::empty());
        for (index, volume) in volumes.iter().enumerate() {
            let coverage = cx.buffer(obstacles[index].coverage).clone();
            links::find(cx, volume, [&surfels, &coverage, &links], count)?;
            let opacity = obstacles[index].opacity;
            let at = Lookup { lookups: &lookups, index, light: light[index], opacity, white: None };
            look_up(cx, at, [&surfels, &links, &target], count)?;
        }
        Ok(())
    });
    found
}

/// One irradiance for each point, from those for its normals.
pub(crate) fn probe_light(probes: &[ProbePoint], found: &[[f32; 4]]) -> Vec<Vec3> {
    let mut next = found.iter();
    let mean = |probe: &ProbePoint| {
        let count = normals(probe).len();
        next.by_ref().take(count).map(|e| Vec4::from_array(*e).truncate()).sum::<Vec3>() / count as f32
    };
    probes.iter().map(mean).collect()
}
