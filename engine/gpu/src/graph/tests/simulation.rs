//! Executes plans without a device: a piece of memory holds one number, and what a pass writes is
//! a hash of what it finds in the memory of its inputs.

use std::cell::Cell;
use std::collections::BTreeMap;
use std::rc::Rc;

use crate::graph::key::hash;
use crate::graph::plan::{Place, Plan, Step};
use crate::graph::{CompileOptions, FrameReport, Graph, GraphError, PassState, TargetCache};

pub type Memory = Rc<Cell<u64>>;
pub type Cache = TargetCache<Memory>;

/// The value that a pass computes from its inputs for one of its resources.
pub fn made(pass: &str, own: u64, inputs: &[u64], resource: &str) -> u64 {
    hash(&(pass, own, inputs, resource))
}

/// Parameters of passes, and contents of imports.
pub struct World<'w> {
    pub own: &'w dyn Fn(&str) -> u64,
    pub import: &'w dyn Fn(&str) -> u64,
    /// This pass fails.
    pub fails: Option<&'w str>,
}

impl Default for World<'_> {
    fn default() -> Self {
        Self { own: &|_| 0, import: &|_| 0, fails: None }
    }
}

/// The contents of each resource at the end; `None` if a pass failed.
pub fn run(plan: Plan<'_>, cache: &mut Cache, world: &World<'_>) -> Option<BTreeMap<String, u64>> {
    assert_eq!(plan.stamp, cache.stamp());
    let mut garbage = 1 << 60;
    let mut memory = cache.begin_frame(&plan.layout, &mut |_, _| {
        garbage += 1;
        Rc::new(Cell::new(garbage))
    });
    for (resource, memory) in plan.layout.resources.iter().zip(&mut memory) {
        if matches!(resource.place, Place::Imported(_)) {
            *memory = Some(Rc::new(Cell::new((world.import)(&resource.name))));
        }
    }
    let Plan { steps, layout, .. } = plan;
    let names: Vec<String> = layout.resources.iter().map(|resource| resource.name.clone()).collect();
    let imports: Vec<bool> =
        layout.resources.iter().map(|resource| matches!(resource.place, Place::Imported(_))).collect();
    let ok = steps.iter().all(|step| run_step(step, &names, &imports, &memory, cache, world));
    cache.end_frame();
    let values = names.into_iter().zip(memory).filter_map(|(name, memory)| Some((name, memory?.get())));
    ok.then(|| values.collect())
}

fn run_step(
    step: &Step<'_>,
    names: &[String],
    imports: &[bool],
    memory: &[Option<Memory>],
    cache: &mut Cache,
    world: &World<'_>,
) -> bool {
    let slots = || step.writes.iter().filter(|write| write.retained);
    slots().for_each(|write| cache.begin_write(&names[write.from.resource]));
    let modified = step.writes.iter().map(|write| write.from).filter(|at| at.number > 0 || imports[at.resource]);
    let inputs: Vec<u64> =
        step.reads.iter().copied().chain(modified).map(|at| memory[at.resource].as_ref().unwrap().get()).collect();
    let fails = world.fails == Some(step.name.as_str());
    for write in &step.writes {
        let name = &names[write.from.resource];
        let value = made(&step.name, (world.own)(&step.name), &inputs, name);
        memory[write.from.resource].as_ref().unwrap().set(if fails { 666 } else { value });
    }
    if !fails {
        slots().for_each(|write| {
            cache.end_write(&names[write.from.resource], write.from.number + 1, write.key, &step.recipe)
        });
    }
    !fails
}

/// Compiles and runs a frame; returns what became of each pass.
pub fn frame(graph: Graph<'_>, cache: &mut Cache) -> FrameReport {
    frame_with(graph, cache, &World::default(), false).unwrap()
}

pub fn frame_with(
    graph: Graph<'_>,
    cache: &mut Cache,
    world: &World<'_>,
    no_cache: bool,
) -> Result<FrameReport, GraphError> {
    let plan = graph.compile(cache, &CompileOptions { no_cache })?;
    let report = FrameReport { passes: plan.passes().to_vec(), resources: plan.resources(), ..Default::default() };
    run(plan, cache, world);
    Ok(report)
}

/// The states of some passes, as letters: r(an), c(ached), x (culled), s(kipped).
pub fn states(report: &FrameReport) -> String {
    let letter = |state: &PassState| match state {
        PassState::Ran => 'r',
        PassState::Cached => 'c',
        PassState::Culled => 'x',
        PassState::Skipped(_) => 's',
    };
    report.passes.iter().map(|pass| letter(&pass.state)).collect()
}

/// Why a pass ran or not.
pub fn why<'r>(report: &'r FrameReport, pass: &str) -> &'r str {
    &report.pass(pass).unwrap().why
}
