//! Sharing of transient memory, and eviction.

use super::simulation::{Cache, frame};
use super::{desc, pass};
use crate::graph::{CompileOptions, Graph, ResourceReport};

/// A chain of passes over transients of given sizes, ending in a retained image.
fn chain(sizes: &[u32]) -> Graph<'static> {
    let mut graph = Graph::new(0);
    let mut last = None;
    for (index, size) in sizes.iter().enumerate() {
        let target = graph.texture(format!("t{index}"), desc(*size));
        let ([written], _) = pass(&mut graph, &format!("p{index}"), Some(0), last.as_slice(), [target]);
        last = Some(written);
    }
    let image = graph.retained_texture("image", desc(4));
    let ([image], _) = pass(&mut graph, "end", None, last.as_slice(), [image]);
    graph.output(image);
    graph
}

fn resources(graph: Graph<'_>) -> Vec<ResourceReport> {
    graph.compile(&Cache::with_keep_frames(8), &CompileOptions::default()).unwrap().resources()
}

#[test]
fn disjoint_lifetimes_share_and_overlapping_ones_do_not() {
    let resources = resources(chain(&[8, 8, 8, 8]));
    let with = |index: usize| resources[index].aliased_with.clone();
    assert_eq!(with(0), ["t2"]);
    assert_eq!(with(1), ["t3"]);
    assert!(with(4).is_empty(), "a retained target shares with nobody");
}

#[test]
fn different_descriptions_do_not_share() {
    assert!(resources(chain(&[8, 16, 32, 64])).iter().all(|resource| resource.aliased_with.is_empty()));
}

#[test]
fn a_target_that_is_read_late_keeps_its_memory() {
    let mut graph = Graph::new(0);
    let [a, b, c] = ["a", "b", "c"].map(|name| graph.texture(name, desc(8)));
    let image = graph.retained_texture("image", desc(8));
    let ([a], _) = pass(&mut graph, "a", Some(0), &[], [a]);
    let ([b], _) = pass(&mut graph, "b", Some(0), &[a], [b]);
    let ([c], _) = pass(&mut graph, "c", Some(0), &[b], [c]);
    let ([image], _) = pass(&mut graph, "end", Some(0), &[a, c], [image]);
    graph.output(image);
    assert!(resources(graph).iter().all(|resource| resource.aliased_with.is_empty()));
}

#[test]
fn memory_is_pooled_over_frames_and_evicted() {
    let mut cache = Cache::with_keep_frames(3);
    frame(chain(&[8, 8, 8]), &mut cache);
    let first = cache.figures();
    assert_eq!((first.pooled, first.retained, first.created), (2, 1, 3));
    assert_eq!(first.pooled_bytes, 2 * 8 * 8 * 4);
    frame(chain(&[8, 8, 8]), &mut cache);
    assert_eq!(cache.figures().created, 0);
    for left in [2, 2, 0] {
        frame(chain(&[]), &mut cache);
        assert_eq!(cache.figures().pooled, left);
    }
    assert_eq!(cache.figures().evicted, 2);
    for left in [1, 1, 0] {
        frame(Graph::new(0), &mut cache);
        assert_eq!(cache.figures().retained, left);
    }
}

#[test]
fn a_retained_target_that_is_declared_but_not_used_stays() {
    let mut cache = Cache::with_keep_frames(2);
    frame(chain(&[]), &mut cache);
    for _ in 0..4 {
        let mut graph = Graph::new(0);
        graph.retained_texture("image", desc(4));
        frame(graph, &mut cache);
        assert_eq!(cache.figures().retained, 1);
    }
}

#[test]
fn another_size_makes_new_memory_and_lets_the_old_go() {
    let mut cache = Cache::with_keep_frames(8);
    for (size, created) in [(8, 1), (8, 0), (16, 1), (8, 1)] {
        let mut graph = Graph::new(0);
        let image = graph.retained_texture("image", desc(size));
        let ([image], _) = pass(&mut graph, "draw", Some(0), &[], [image]);
        graph.output(image);
        let report = frame(graph, &mut cache);
        assert_eq!(report.ran_count(), created, "size {size}");
        let figures = cache.figures();
        assert_eq!((figures.created, figures.retained), (created, 1));
        assert_eq!(figures.retained_bytes, u64::from(size * size * 4));
    }
}
