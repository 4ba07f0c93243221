//! Indirect light at points that a game asks for: looked up as for the surfels of a bounce, in the sum over all bounces.

use super::{Level, irradiance, links};
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
    let no_links = graph.buffer("links of probes", BufferDesc::new(4 * u64::from(count), BufferUsages::STORAGE));
    let mut pass = graph.compute("probes", links::shader());
    pass.values("surfels", &surfels);
    let found = pass.write("received", found);
    let _ = pass.write("links", no_links);
    for (index, level) in levels.iter().enumerate() {
        let mut step = pass.step_of(links::shader());
        step.uniform("volume", &level.volume.uniform());
        step.read("coverage", level.obstacles.coverage);
        step.over_items(count);
        let mut step = pass.step_of(irradiance::shader("at_surfels", index, levels.len()));
        irradiance::look_up(&mut step, levels, index, level.light());
        step.over_items(count);
    }
    pass.finish();
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
