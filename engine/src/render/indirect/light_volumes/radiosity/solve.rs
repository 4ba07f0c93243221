//! All bounces between patches. See `indirect/light_volumes/radiosity/solve.wgsl`.

use super::links::Links;
use super::{BounceCount, RADIOSITY, Radiosity, Rays, Turn};
use crate::gpu::{ComputeKey, ShaderDef};
use crate::graph::{Buffer, BufferDesc, ComputeBuilder, Graph, Handle};
use crate::render::frame::Frame;
use wgpu::BufferUsages;

/// The system to solve: surfels, the links between them, and the light that arrives first.
#[derive(Clone, Copy)]
pub(super) struct Subject {
    /// In world space.
    pub surfels: Handle<Buffer>,
    pub links: Links,
    /// Irradiance of the surfels of the lights' first bounce.
    pub reflected: Handle<Buffer>,
    pub rays: Rays,
    /// Not all surfels: the light of the frame before is there, and goes on by a bounce.
    pub turn: Turn,
    pub bounces: BounceCount,
}

impl Subject {
    /// Whether the light of the frame before goes on by a bounce. Where bounces are counted, they begin anew in each frame.
    fn goes_on(&self) -> bool {
        !self.turn.is_all() && self.bounces.has_rest
    }
}

/// What the steps have in common.
struct Work {
    subject: Subject,
    bounces: [Handle<Buffer>; 2],
    patch_count: u32,
}

/// Declares the solution.
pub(super) fn declare<'a>(graph: &mut Graph<'a>, frame: &Frame<'a>, subject: Subject) -> Radiosity {
    let cloud = frame.surfels;
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST | BufferUsages::COPY_SRC;
    let vectors = |count: u32| BufferDesc::new(16 * u64::from(count.max(1)), usage);
    let bounces = ["light of patches, a bounce", "light of patches, another bounce"]
        .map(|name| graph.buffer(name.to_owned(), vectors(cloud.patch_count())));
    let rest = graph.buffer("light of patches, the rest".to_owned(), vectors(1));
    let patches = graph.retained_buffer("light of patches", vectors(cloud.patch_count()));
    let surfels = graph.retained_buffer("light of surfels", vectors(cloud.count()));
    let mut pass = graph.compute(RADIOSITY, ComputeKey::new("indirect/light_volumes/radiosity/solve.wgsl", "start"));
    pass.tracked("patches", cloud.ranges());
    pass.read("surfels", subject.surfels);
    pass.read("surfel_links", subject.links.links);
    pass.read("shone_on", subject.links.shone_on);
    pass.read("reflected_light", subject.reflected);
    let bounces = bounces.map(|handle| pass.write_in_steps(handle));
    let rest = pass.write("rest", rest);
    let result = Radiosity {
        patches: pass.write("patch_light", patches),
        surfels: pass.write("received", surfels),
        change: None,
    };
    pass.depends_on(&(subject.bounces, subject.rays, subject.turn));
    pass.clear(rest);
    let work = Work { subject, bounces, patch_count: cloud.patch_count() };
    if subject.goes_on() {
        pass.copy(result.patches, bounces[1]);
        work.step(&mut pass, "go_on", 0);
    } else {
        work.step(&mut pass, "start", 0);
        (1..subject.bounces.computed).for_each(|bounce| work.step(&mut pass, "bounce", bounce));
        let last = subject.bounces.computed - 1;
        if subject.bounces.has_rest && last > 0 {
            work.step(&mut pass, "find_rest", last);
        }
        work.step(&mut pass, "finish", last);
    }
    pass.finish();
    result
}

impl Work {
    /// Declares an entry point; even bounces are written to the first buffer, and odd ones to the second.
    fn step(&self, pass: &mut ComputeBuilder, entry: &'static str, bounce: u32) {
        let now = (bounce % 2) as usize;
        let mut step = pass.step(entry);
        if ["bounce", "go_on"].contains(&entry) {
            step.define("RAYS", ShaderDef::Uint(self.subject.rays.count));
        }
        step.read("this_bounce", self.bounces[now]);
        step.read("last_bounce", self.bounces[1 - now]);
        match entry {
            "find_rest" => step.in_groups([1, 1, 1]),
            _ => step.over_items(self.patch_count),
        }
    }
}
