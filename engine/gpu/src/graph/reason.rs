//! Why a pass runs or does not, in words.

use super::builder::{Graph, PassNode, Storage};
use super::cache::TargetCache;
use super::decision::{CompileOptions, Decision, WantedBy};
use super::handle::Version;
use super::key::{Keys, Recipe};
use super::report::{PassReport, PassState};

/// The state of every pass in the order of declaration, as it is planned.
pub(super) fn pass_reports<P: Clone>(
    graph: &Graph<'_>,
    cache: &TargetCache<P>,
    keys: &Keys,
    decision: &Decision,
    options: &CompileOptions,
) -> Vec<PassReport> {
    let needed = needed(graph);
    let report = |(index, pass): (usize, &PassNode<'_>)| {
        let (state, why) = if decision.runs[index] {
            (PassState::Ran, why_it_runs(graph, cache, keys, decision, options, index))
        } else if needed[index] && is_held(pass, decision) {
            (PassState::Cached, format!("{} unchanged", names(graph, pass)))
        } else {
            (PassState::Culled, why_culled(graph, decision, &needed, index))
        };
        PassReport::new(pass.name.clone(), state, why)
    };
    graph.passes.iter().enumerate().map(report).collect()
}

/// Whether a pass contributes to an output at all, cached or not.
fn needed(graph: &Graph<'_>) -> Vec<bool> {
    let mut needed = vec![false; graph.passes.len()];
    let mut open: Vec<Version> = graph.outputs.clone();
    while let Some(version) = open.pop() {
        if let Some(pass) = graph.writer(version).filter(|&pass| !needed[pass]) {
            needed[pass] = true;
            open.extend(graph.inputs(pass));
        }
    }
    needed
}

/// Whether slots serve what is wanted of a pass that does not run; if nothing is wanted of it
/// because its readers do not run either, whether slots hold all that it makes.
fn is_held(pass: &PassNode<'_>, decision: &Decision) -> bool {
    let wanted = pass.writes.iter().any(|from| decision.wanted[from.resource][from.number + 1].is_some());
    wanted || pass.writes.iter().all(|from| decision.available[from.resource] == Some(from.number + 1))
}

fn why_it_runs<P: Clone>(
    graph: &Graph<'_>,
    cache: &TargetCache<P>,
    keys: &Keys,
    decision: &Decision,
    options: &CompileOptions,
    index: usize,
) -> String {
    let pass = &graph.passes[index];
    if options.no_cache {
        return "caching is off".into();
    }
    if pass.key.is_none() {
        return "it states no key, so it runs every frame".into();
    }
    let missing = pass.writes.iter().filter_map(|from| {
        let wanted = decision.wanted[from.resource][from.number + 1]?;
        (decision.available[from.resource] != Some(from.number + 1)).then_some((*from, wanted))
    });
    let (retained, transient): (Vec<_>, Vec<_>) =
        missing.partition(|(from, _)| matches!(graph.resources[from.resource].storage, Storage::Retained));
    // A slot that the pass itself, or another one, overwrites is a consequence: told last.
    let held = |from: &Version| decision.held[from.resource] == Some(from.number + 1);
    if let Some((from, _)) = retained.iter().find(|(from, _)| !held(from)) {
        return why_not_in_slot(graph, cache, &keys.recipes[index], *from);
    }
    match transient.first() {
        Some((from, WantedBy::Pass(reader))) => {
            format!("`{}` needs `{}`", graph.passes[*reader].name, graph.resources[from.resource].name)
        }
        Some((from, WantedBy::Output)) => format!("`{}` is an output", graph.resources[from.resource].name),
        None => {
            let names: Vec<&str> =
                retained.iter().map(|(from, _)| graph.resources[from.resource].name.as_str()).collect();
            format!("`{}` is overwritten in this frame before it is used", names.join("`, `"))
        }
    }
}

/// Compares what was done when the slot was filled with what is to be done now.
fn why_not_in_slot<P: Clone>(graph: &Graph<'_>, cache: &TargetCache<P>, now: &Recipe, from: Version) -> String {
    let resource = &graph.resources[from.resource];
    let name = &resource.name;
    let Some(slot) = cache.slot(name) else { return format!("`{name}` is not in the cache yet") };
    if slot.desc != resource.desc {
        return format!("`{name}` was {} and is now {}", slot.desc, resource.desc);
    }
    let Some(then) = slot.recipes.get(from.number) else {
        return format!("what `{name}` holds is incomplete");
    };
    if let Some(volatile) = now.inputs.iter().find(|(_, key)| key.is_none()) {
        return format!("`{}` changes every frame", volatile.0);
    }
    if then.pass != now.pass {
        return format!("`{name}` holds what `{}` wrote", then.pass);
    }
    if then.seed != now.seed {
        return "the seed changed".into();
    }
    if then.own != now.own {
        return "its key changed".into();
    }
    if then.inputs.len() != now.inputs.len() {
        return "it reads other resources than before".into();
    }
    match now.inputs.iter().zip(&then.inputs).find(|(now, then)| now != then) {
        Some((now, _)) => format!("`{}` changed", now.0),
        None if slot.recipes.len() > from.number + 1 => {
            format!("`{name}` is needed as it was before `{}` overwrote it", slot.recipes[from.number + 1].pass)
        }
        None => format!("what `{name}` holds was invalidated"),
    }
}

fn why_culled(graph: &Graph<'_>, decision: &Decision, needed: &[bool], index: usize) -> String {
    let pass = &graph.passes[index];
    if pass.writes.is_empty() {
        return "it writes nothing".into();
    }
    let reads_of = |reader: usize| graph.inputs(reader).any(|input| graph.writer(input) == Some(index));
    let readers: Vec<usize> = (0..graph.passes.len()).filter(|&reader| reader != index && reads_of(reader)).collect();
    let cached = |&&reader: &&usize| needed[reader] && is_held(&graph.passes[reader], decision);
    if let Some(&reader) = readers.iter().find(cached) {
        return format!("only needed by `{}`, which is cached", graph.passes[reader].name);
    }
    match readers.iter().find(|reader| needed[**reader]).or(readers.first()) {
        Some(&reader) => format!("only needed by `{}`, which is culled", graph.passes[reader].name),
        None => format!("nothing reads {}", names(graph, pass)),
    }
}

fn names(graph: &Graph<'_>, pass: &PassNode<'_>) -> String {
    let names = pass.writes.iter().map(|from| format!("`{}`", graph.resources[from.resource].name));
    names.collect::<Vec<_>>().join(", ")
}
