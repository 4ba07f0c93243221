//! The order of passes: dependencies, a stable topological sort, and what a cycle means.

use std::collections::BTreeSet;

use super::builder::Graph;
use super::error::GraphError;

/// Why one pass runs before another.
#[derive(Clone, Copy, PartialEq)]
enum Because {
    /// It writes what the other needs.
    Writes(usize),
    /// It reads what the other overwrites.
    ReadsBefore(usize),
    /// The caller says so.
    Ordered,
}

#[derive(Clone, Copy)]
struct Edge {
    from: usize,
    to: usize,
    because: Because,
}

/// All passes, each after those that it depends on; otherwise in the order of declaration.
pub(super) fn order(graph: &Graph<'_>) -> Result<Vec<usize>, GraphError> {
    let edges = edges(graph);
    let mut waiting_for = vec![0usize; graph.passes.len()];
    let mut followers = vec![Vec::new(); graph.passes.len()];
    for edge in &edges {
        waiting_for[edge.to] += 1;
        followers[edge.from].push(edge.to);
    }
    let mut ready: BTreeSet<usize> = (0..graph.passes.len()).filter(|&pass| waiting_for[pass] == 0).collect();
    let mut sorted = Vec::with_capacity(graph.passes.len());
    while let Some(pass) = ready.pop_first() {
        sorted.push(pass);
        for &follower in &followers[pass] {
            waiting_for[follower] -= 1;
            if waiting_for[follower] == 0 {
                ready.insert(follower);
            }
        }
    }
    if sorted.len() == graph.passes.len() {
        return Ok(sorted);
    }
    let stuck: Vec<bool> = waiting_for.iter().map(|&count| count > 0).collect();
    Err(circle_error(graph, &find_circle(&edges, &stuck)))
}

fn edges(graph: &Graph<'_>) -> Vec<Edge> {
    let mut edges: Vec<Edge> = Vec::new();
    for pass in 0..graph.passes.len() {
        for version in graph.inputs(pass) {
            if let Some(from) = graph.writer(version) {
                edges.push(Edge { from, to: pass, because: Because::Writes(version.resource) });
            }
            // A pass that reads what it then modifies does not wait for itself.
            if let Some(to) = graph.overwriter(version).filter(|&to| to != pass) {
                edges.push(Edge { from: pass, to, because: Because::ReadsBefore(version.resource) });
            }
        }
    }
    let ordered = graph.orders.iter().map(|&(from, to)| Edge { from, to, because: Because::Ordered });
    edges.extend(ordered);
    edges
}

/// A cycle among the passes that the sort could not place. Each of them waits for another one of
/// them, so going back from one for long enough goes round.
fn find_circle(edges: &[Edge], stuck: &[bool]) -> Vec<Edge> {
    let mut path: Vec<Edge> = Vec::new();
    let mut at = stuck.iter().position(|&stuck| stuck).unwrap_or(0);
    while let Some(&edge) = edges.iter().find(|edge| edge.to == at && stuck[edge.from]) {
        path.push(edge);
        at = edge.from;
        if let Some(start) = path.iter().position(|edge| edge.to == at) {
            let mut circle = path.split_off(start);
            circle.reverse();
            return circle;
        }
    }
    path
}

fn circle_error(graph: &Graph<'_>, circle: &[Edge]) -> GraphError {
    let name = |pass: usize| graph.passes[pass].name.clone();
    let steps = circle.iter().map(|edge| match edge.because {
        Because::Writes(at) => format!("`{}` writes `{}` for ", name(edge.from), graph.resources[at].name),
        Because::ReadsBefore(at) => format!("`{}` reads `{}` before ", name(edge.from), graph.resources[at].name),
        Because::Ordered => format!("`{}` is ordered before ", name(edge.from)),
    });
    let mut path: String = steps.collect();
    if let Some(first) = circle.first() {
        path += &format!("`{}`", name(first.from));
    }
    let stale = circle.iter().find_map(|edge| match edge.because {
        Because::ReadsBefore(resource) => Some((edge, resource)),
        _ => None,
    });
    match stale {
        Some((edge, resource)) => GraphError::StaleRead {
            pass: name(edge.from),
            resource: graph.resources[resource].name.clone(),
            writer: name(edge.to),
            path,
        },
        None => GraphError::Cycle { path },
    }
}
