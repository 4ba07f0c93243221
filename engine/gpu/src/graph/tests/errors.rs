//! Each mistake is an error that names the passes and the resource.

use super::simulation::Cache;
use super::{desc, pass};
use crate::graph::{CompileOptions, Graph, GraphError};

fn error(graph: Graph<'_>) -> GraphError {
    match graph.compile(&Cache::with_keep_frames(8), &CompileOptions::default()) {
        Ok(_) => panic!("the graph compiles"),
        Err(error) => error,
    }
}

/// The message of the error, which must hold the given words.
fn fails_with(graph: Graph<'_>, words: &[&str]) {
    let message = error(graph).to_string();
    for word in words {
        assert!(message.contains(word), "`{word}` is missing in: {message}");
    }
}

#[test]
fn read_before_write() {
    let mut graph = Graph::new(0);
    let depth = graph.texture("depth", desc(4));
    let image = graph.retained_texture("image", desc(4));
    pass(&mut graph, "shade", None, &[depth], [image]);
    fails_with(graph, &["`shade` reads `depth` before"]);
}

#[test]
fn output_that_nobody_writes() {
    let mut graph = Graph::new(0);
    let image = graph.retained_texture("image", desc(4));
    graph.output(image);
    fails_with(graph, &["output `image` is not written"]);
}

#[test]
fn output_that_is_overwritten() {
    let mut graph = Graph::new(0);
    let image = graph.retained_texture("image", desc(4));
    let ([first], _) = pass(&mut graph, "shade", None, &[], [image]);
    pass(&mut graph, "blend", None, &[], [first]);
    graph.output(first);
    fails_with(graph, &["output `image`", "`blend`"]);
}

#[test]
fn two_writers_of_one_version() {
    let mut graph = Graph::new(0);
    let image = graph.texture("image", desc(4));
    pass(&mut graph, "one", None, &[], [image]);
    pass(&mut graph, "two", None, &[], [image]);
    fails_with(graph, &["`one`", "`two`", "`image`"]);
}

#[test]
fn stale_read_that_data_forbids() {
    // `late` reads the old image, and what was made from the new one.
    let mut graph = Graph::new(0);
    let image = graph.texture("image", desc(4));
    let other = graph.texture("other", desc(4));
    let result = graph.texture("result", desc(4));
    let ([old], _) = pass(&mut graph, "first", None, &[], [image]);
    let ([new], _) = pass(&mut graph, "overwrite", None, &[], [old]);
    let ([other], _) = pass(&mut graph, "derive", None, &[new], [other]);
    pass(&mut graph, "late", None, &[old, other], [result]);
    let error = error(graph);
    assert!(
        matches!(&error, GraphError::StaleRead { pass, resource, writer, .. }
        if pass == "late" && resource == "image" && writer == "overwrite"),
        "{error}"
    );
}

#[test]
fn stale_read_that_order_forbids() {
    let mut graph = Graph::new(0);
    let image = graph.texture("image", desc(4));
    let result = graph.texture("result", desc(4));
    let ([old], _) = pass(&mut graph, "first", None, &[], [image]);
    let (_, reader) = pass(&mut graph, "reader", None, &[old], [result]);
    let (_, overwrite) = pass(&mut graph, "overwrite", None, &[], [old]);
    graph.order(overwrite, reader);
    assert!(matches!(error(graph), GraphError::StaleRead { .. }));
}

#[test]
fn order_against_the_data() {
    let mut graph = Graph::new(0);
    let image = graph.texture("image", desc(4));
    let result = graph.texture("result", desc(4));
    let ([written], writer) = pass(&mut graph, "writer", None, &[], [image]);
    let (_, reader) = pass(&mut graph, "reader", None, &[written], [result]);
    graph.order(reader, writer);
    fails_with(
        graph,
        &["wait for each other", "`writer` writes `image` for `reader`", "`reader` is ordered before `writer`"],
    );
}

#[test]
fn circle_of_orders() {
    let mut graph = Graph::new(0);
    let [a, b] = ["a", "b"].map(|name| graph.texture(name, desc(4)));
    let (_, one) = pass(&mut graph, "one", None, &[], [a]);
    let (_, two) = pass(&mut graph, "two", None, &[], [b]);
    graph.order(one, two);
    graph.order(two, one);
    assert!(matches!(error(graph), GraphError::Cycle { .. }));
}

#[test]
fn pass_that_reads_its_own_output() {
    let mut graph = Graph::new(0);
    let image = graph.texture("image", desc(4));
    let mut builder = graph.pass("loop");
    let written = builder.write(image);
    builder.read(written);
    builder.execute(|_| Ok(()));
    assert!(matches!(error(graph), GraphError::Cycle { .. }));
}

#[test]
fn foreign_handles() {
    let mut foreign = Graph::new(0);
    let stranger = foreign.texture("image", desc(4));
    let (_, strange_pass) = pass(&mut foreign, "stranger", None, &[], [stranger]);
    let mut graph = Graph::new(0);
    pass(&mut graph, "reader", None, &[stranger], []);
    fails_with(graph, &["pass `reader`", "another graph"]);
    let mut graph = Graph::new(0);
    pass(&mut graph, "writer", None, &[], [stranger]);
    fails_with(graph, &["pass `writer`", "another graph"]);
    let mut graph = Graph::new(0);
    graph.output(stranger);
    fails_with(graph, &["`output`"]);
    let mut graph = Graph::new(0);
    graph.order(strange_pass, strange_pass);
    fails_with(graph, &["`order`"]);
}

#[test]
fn duplicate_names() {
    let mut graph = Graph::new(0);
    graph.texture("image", desc(4));
    graph.retained_texture("image", desc(8));
    fails_with(graph, &["`image`", "unique"]);
    let mut graph = Graph::new(0);
    pass(&mut graph, "shade", None, &[], []);
    pass(&mut graph, "shade", None, &[], []);
    fails_with(graph, &["`shade`", "unique"]);
    let mut graph = Graph::new(0);
    pass(&mut graph, "shade", None, &[], []);
    graph.skip("shade", "no light");
    fails_with(graph, &["`shade`", "unique"]);
}

#[test]
fn pass_without_work_and_resource_without_size() {
    let mut graph = Graph::new(0);
    graph.pass("idle");
    fails_with(graph, &["`idle`", "execute"]);
    let mut graph = Graph::new(0);
    graph.texture("image", desc(0));
    fails_with(graph, &["`image`", "is 0"]);
}

#[test]
fn a_plan_of_the_past_is_noticed() {
    let mut cache = Cache::with_keep_frames(8);
    let plan = Graph::new(0).compile(&cache, &CompileOptions::default()).unwrap();
    cache.invalidate("anything");
    assert_ne!(plan.stamp, cache.stamp());
}
