//! All bounces between patches. See `indirect/light_volumes/radiosity/solve.wgsl`.

use super::links::Links;
use super::{BounceCount, RADIOSITY, Radiosity, Rays, Turn};
use crate::gpu::{Binding, ComputeKey, ShaderDef};
use crate::graph::{Buffer, BufferDesc, Graph, Handle, PassContext, PassError};
use crate::render::frame::{Frame, linear_groups};
use crate::render::scene_gpu::surfels::GpuSurfels;
use wgpu::BufferUsages;

const SHADER: &str = "indirect/light_volumes/radiosity/solve.wgsl";

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

/// Buffers that the bounces are computed in.
#[derive(Clone, Copy)]
struct Work {
    bounces: [Handle<Buffer>; 2],
    rest: Handle<Buffer>,
    result: Radiosity,
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
    let mut pass = graph.pass(RADIOSITY);
    let Links { links, shone_on, .. } = subject.links;
    [subject.surfels, links, shone_on, subject.reflected].into_iter().for_each(|handle| pass.read(handle));
    let work = Work {
        bounces: bounces.map(|handle| pass.write(handle)),
        rest: pass.write(rest),
        result: Radiosity { patches: pass.write(patches), surfels: pass.write(surfels), change: None },
    };
    pass.key(&(subject.bounces, subject.rays, subject.turn, cloud.revision()));
    pass.execute(move |cx| {
        let rest = cx.buffer(work.rest).clone();
        cx.encoder().clear_buffer(&rest, 0, None);
        if subject.goes_on() {
            let [before, now] = [work.bounces[1], work.result.patches].map(|handle| cx.buffer(handle).clone());
            cx.encoder().copy_buffer_to_buffer(&now, 0, &before, 0, None);
            return run(cx, cloud, &subject, &work, "go_on", 0);
        }
        run(cx, cloud, &subject, &work, "start", 0)?;
        for bounce in 1..subject.bounces.computed {
            run(cx, cloud, &subject, &work, "bounce", bounce)?;
        }
        let last = subject.bounces.computed - 1;
        if subject.bounces.has_rest && last > 0 {
            run(cx, cloud, &subject, &work, "find_rest", last)?;
        }
        run(cx, cloud, &subject, &work, "finish", last)
    });
    work.result
}

/// Runs an entry point; even bounces are written to the first buffer, and odd ones to the second.
fn run(
    cx: &mut PassContext,
    cloud: &GpuSurfels,
    subject: &Subject,
    work: &Work,
    entry: &'static str,
    bounce: u32,
) -> Result<(), PassError> {
    let [mut to, mut from] = work.bounces;
    if bounce % 2 == 1 {
        (from, to) = (to, from);
    }
    let handles =
        [subject.surfels, subject.links.links, subject.links.shone_on, subject.reflected, from, to, work.rest]
            .map(|handle| cx.buffer(handle).clone());
    let results = [work.result.patches, work.result.surfels].map(|handle| cx.buffer(handle).clone());
    let names = ["surfels", "surfel_links", "shone_on", "reflected_light", "last_bounce", "this_bounce", "rest"];
    let mut key = ComputeKey::new(SHADER, entry);
    if ["bounce", "go_on"].contains(&entry) {
        key = key.def("RAYS", ShaderDef::Uint(subject.rays.count));
    }
    let mut group = vec![("patches", cloud.patches().ranges())];
    group.extend(names.into_iter().zip(handles.iter().map(Binding::Buffer)));
    group.extend(["patch_light", "received"].into_iter().zip(results.iter().map(Binding::Buffer)));
    let groups = if entry == "find_rest" { [1, 1, 1] } else { linear_groups(cloud.patch_count()) };
    cx.dispatch(&key, &group, groups)
}
