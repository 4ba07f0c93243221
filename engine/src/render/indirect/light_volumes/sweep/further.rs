//! Light of all bounces but the last, in a grid of its own that is coarser than that of the last.
//!
//! What surfaces reflect of light that was reflected before changes slowly from place to place, and the last sweep smooths
//! it once more: it takes few cells. (As final gathering does with radiosity: Reichert 1992, "A two-pass radiosity method
//! driven by lights and viewer position".) The last sweep, in fine cells and along many directions, brings this light and
//! that of the surfaces which the lights shine at, whose borders are sharp.

use super::directions::Directions;
use super::{Bounce, BounceCount, Level, Light, Work, bounce_name, bounce_sum, emit, irradiance, transport};
use crate::gpu::ComputeKey;
use crate::graph::{Buffer, BufferDesc, Graph, Handle};
use wgpu::BufferUsages;

/// Declares all passes; the result is the irradiance of which the surfels reflect their share \[W/m²\], of all bounces.
pub(super) fn declare<'a>(
    graph: &mut Graph<'a>,
    work: &Work<'_, 'a>,
    level: Level,
    bounces: BounceCount,
    directions: &Directions,
) -> Handle<Buffer> {
    let mut levels = [level];
    let mut totals = emit::totals(graph, bounces.swept);
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
    let desc = BufferDesc::new(16 * u64::from(work.source.count), usage);
    let mut all = graph.buffer("irradiance of surfels, all bounces", desc);
    let white = work.white(graph, &levels, directions);
    let mut light = Light::Scene(None);
    for number in 0..bounces.swept {
        work.sweep(graph, &mut levels, Some(&mut totals), Bounce { number, of: bounces, directions, light });
        let name = bounce_name(number + 1);
        let received = irradiance::at_surfels(graph, &work.source, &levels, &name, Some(white));
        let step = transport::Step { index: 0, bounce: number, bounces };
        all = add(graph, [totals, received, all], step, work.source.count);
        light = Light::Scene(Some(received));
    }
    all
}

/// Declares the addition of a bounce to the light of all; the result is that light.
fn add(
    graph: &mut Graph<'_>,
    [totals, received, all]: [Handle<Buffer>; 3],
    step: transport::Step,
    count: u32,
) -> Handle<Buffer> {
    let shader = ComputeKey::new("indirect/light_volumes/sweep/sum.wgsl", "at_surfels");
    let mut pass = graph.compute(format!("add, bounce {}", step.bounce + 1), shader);
    pass.uniform("sum", &bounce_sum::sum_uniform(step));
    pass.read("totals", totals);
    pass.read("received", received);
    let all = pass.write("all_received", all);
    if step.bounce == 0 {
        pass.clear(all);
    }
    pass.step("at_surfels").over_items(count);
    pass.finish();
    all
}
