//! From a declared graph to a plan: what is wanted, what is still there, what has to run.
//!
//! The walk goes backwards through the order of passes. A version is wanted if it is an output or
//! an input of a pass that runs; a pass runs if it makes a wanted version that is not available.
//! Available are imports, and the one version whose content key a retained slot still holds.

use super::alias::{self, Lifetime};
use super::builder::{Graph, Storage};
use super::cache::TargetCache;
use super::decision::{CompileOptions, Decision, WantedBy};
use super::error::GraphError;
use super::handle::Version;
use super::key::Keys;
use super::order::order;
use super::plan::{Layout, Place, Plan, PlannedResource, Step, StepWrite};
use super::reason;

impl<'a> Graph<'a> {
    /// Checks the graph and decides what has to run, given what the cache holds.
    ///
    /// # Errors
    /// Names the passes and the resource: see [`GraphError`].
    pub fn compile<P: Clone>(
        mut self,
        cache: &TargetCache<P>,
        options: &CompileOptions,
    ) -> Result<Plan<'a>, GraphError> {
        if !self.errors.is_empty() {
            return Err(self.errors.swap_remove(0));
        }
        self.check_work_and_outputs()?;
        let order = order(&self)?;
        let keys = Keys::new(&self, &order);
        let no_cache = options.no_cache || cache.audit.is_some();
        let held = self.resources.iter().enumerate().map(|(index, resource)| {
            let slot = cache.slot(&resource.name).filter(|slot| slot.desc == resource.desc)?;
            let retained = matches!(resource.storage, Storage::Retained) && !no_cache;
            let content = slot.content.filter(|_| retained)?;
            keys.versions[index].iter().rposition(|key| *key == Some(content))
        });
        let decision = decide(&self, &order, held.collect());
        let reports = reason::pass_reports(&self, cache, &keys, &decision, &CompileOptions { no_cache });
        let layout = self.layout(&order, &decision);
        let stamp = cache.stamp();
        let (id, skipped) = (self.id, std::mem::take(&mut self.skipped));
        let steps = self.into_steps(&order, keys, &decision);
        Ok(Plan::new(id, stamp, steps, layout, reports, skipped))
    }

    fn check_work_and_outputs(&self) -> Result<(), GraphError> {
        if let Some(pass) = self.passes.iter().find(|pass| pass.work.is_none()) {
            return Err(GraphError::NoWork { pass: pass.name.clone() });
        }
        let stale = self.outputs.iter().find_map(|&output| Some((output, self.overwriter(output)?)));
        match stale {
            Some((output, writer)) => Err(GraphError::StaleOutput {
                resource: self.resources[output.resource].name.clone(),
                writer: self.passes[writer].name.clone(),
            }),
            None => Ok(()),
        }
    }

    /// Memory for what the running passes touch.
    fn layout(&mut self, order: &[usize], decision: &Decision) -> Layout {
        let running = order.iter().copied().filter(|&pass| decision.runs[pass]);
        let mut lifetimes: Vec<Option<Lifetime>> = vec![None; self.resources.len()];
        let mut written = vec![false; self.resources.len()];
        for (at, pass) in running.enumerate() {
            let pass = &self.passes[pass];
            for version in pass.reads.iter().chain(&pass.writes) {
                alias::extend(&mut lifetimes[version.resource], at);
            }
            pass.writes.iter().for_each(|version| written[version.resource] = true);
        }
        for output in &self.outputs {
            alias::extend(&mut lifetimes[output.resource], usize::MAX);
        }
        let transients = self.resources.iter().enumerate().filter_map(|(index, resource)| {
            let lifetime = lifetimes[index].filter(|_| matches!(resource.storage, Storage::Transient))?;
            Some((index, &resource.desc, lifetime))
        });
        let (shared, assigned) = alias::assign(transients.collect(), self.resources.len());
        let resources = self.resources.iter_mut().enumerate().map(|(index, resource)| PlannedResource {
            name: resource.name.clone(),
            desc: resource.desc.clone(),
            place: match &mut resource.storage {
                Storage::Transient => Place::Shared(assigned[index]),
                Storage::Retained => Place::Slot { written: written[index] },
                Storage::Imported { target, .. } => Place::Imported(target.take()),
            },
        });
        Layout { resources: resources.collect(), shared }
    }

    fn into_steps(self, order: &[usize], keys: Keys, decision: &Decision) -> Vec<Step<'a>> {
        let mut recipes: Vec<_> = keys.recipes.into_iter().map(Some).collect();
        let mut passes: Vec<_> = self.passes.into_iter().map(Some).collect();
        let steps = order.iter().filter(|&&index| decision.runs[index]).filter_map(|&index| {
            let (pass, recipe) = (passes[index].take()?, recipes[index].take()?);
            let write = |from: &Version| StepWrite {
                from: *from,
                retained: matches!(self.resources[from.resource].storage, Storage::Retained),
                key: keys.versions[from.resource][from.number + 1],
            };
            let writes = pass.writes.iter().map(write).collect();
            Some(Step { pass: index, name: pass.name, reads: pass.reads, writes, recipe, work: pass.work? })
        });
        steps.collect()
    }
}

/// Walks back from the outputs. A slot can only serve the version that it holds if no running pass
/// overwrites it with that or an older version first; where one would, the slot does not count,
/// which may let more passes run, so the walk is repeated until nothing changes.
fn decide(graph: &Graph<'_>, order: &[usize], held: Vec<Option<usize>>) -> Decision {
    let mut available = held.clone();
    loop {
        let (runs, wanted) = walk_back(graph, order, &available);
        let mut changed = false;
        for version in graph.passes.iter().zip(&runs).filter(|(_, runs)| **runs).flat_map(|(pass, _)| &pass.writes) {
            let slot = &mut available[version.resource];
            if slot.is_some_and(|held| version.number < held) {
                *slot = None;
                changed = true;
            }
        }
        if !changed {
            return Decision { available, held, runs, wanted };
        }
    }
}

type Walk = (Vec<bool>, Vec<Vec<Option<WantedBy>>>);

fn walk_back(graph: &Graph<'_>, order: &[usize], available: &[Option<usize>]) -> Walk {
    let mut runs = vec![false; graph.passes.len()];
    let mut wanted: Vec<Vec<Option<WantedBy>>> =
        graph.resources.iter().map(|resource| vec![None; resource.writers.len() + 1]).collect();
    for output in &graph.outputs {
        wanted[output.resource][output.number] = Some(WantedBy::Output);
    }
    for &pass in order.iter().rev() {
        runs[pass] = graph.passes[pass].writes.iter().any(|from| {
            let made = from.number + 1;
            wanted[from.resource][made].is_some() && available[from.resource] != Some(made)
        });
        if runs[pass] {
            for input in graph.inputs(pass) {
                wanted[input.resource][input.number].get_or_insert(WantedBy::Pass(pass));
            }
        }
    }
    (runs, wanted)
}
