//! Over random graphs and frames, what is cached is what would have been computed.

use std::collections::BTreeMap;

use proptest::prelude::*;

use super::desc;
use super::simulation::{Cache, World, made, run};
use crate::graph::builder::Storage;
use crate::graph::{CompileOptions, Graph, GraphError, Handle, Texture};

#[derive(Clone, Debug)]
struct PassSpec {
    /// Resource, and how many versions before the latest.
    reads: Vec<(usize, usize)>,
    writes: Vec<usize>,
    keyed: bool,
}

#[derive(Clone, Debug)]
struct FrameSpec {
    /// Parameter of each pass.
    own: Vec<u64>,
    /// Whether each pass is in the graph.
    present: Vec<bool>,
    /// Which resources are outputs.
    outputs: Vec<bool>,
    sizes: Vec<u32>,
    import: u64,
    fails: Option<usize>,
    no_cache: bool,
}

const RESOURCES: usize = 5;
const PASSES: usize = 7;

fn pass_spec() -> impl Strategy<Value = PassSpec> {
    let age = prop_oneof![6 => Just(0usize), 1 => 1..3usize];
    let reads = prop::collection::vec((0..RESOURCES, age), 0..3);
    let writes = prop::collection::btree_set(0..RESOURCES, 1..3);
    (reads, writes, prop::bool::weighted(0.9)).prop_map(|(reads, writes, keyed)| PassSpec {
        reads,
        writes: writes.into_iter().collect(),
        keyed,
    })
}

fn frame_spec() -> impl Strategy<Value = FrameSpec> {
    let own = prop::collection::vec(prop_oneof![8 => Just(0u64), 1 => 1..3u64], PASSES);
    let present = prop::collection::vec(prop::bool::weighted(0.93), PASSES);
    let outputs = prop::collection::vec(prop::bool::weighted(0.4), RESOURCES);
    let sizes = prop::collection::vec(prop_oneof![12 => Just(8u32), 1 => Just(16u32)], RESOURCES);
    let fails = prop::option::weighted(0.1, 0..PASSES);
    (own, present, outputs, sizes, 0..2u64, fails, prop::bool::weighted(0.1)).prop_map(
        |(own, present, outputs, sizes, import, fails, no_cache)| FrameSpec {
            own,
            present,
            outputs,
            sizes,
            import,
            fails,
            no_cache,
        },
    )
}

/// The graph of a frame, and what each output must hold.
fn build(
    frame: usize,
    spec: &FrameSpec,
    storages: &[u8],
    passes: &[PassSpec],
) -> (Graph<'static>, BTreeMap<String, u64>) {
    let mut graph = Graph::new(0);
    let mut versions: Vec<Vec<(Handle<Texture>, Option<u64>)>> = Vec::new();
    for (index, storage) in storages.iter().enumerate() {
        let (storage, value) = match storage {
            0 => (Storage::Transient, None),
            1 | 2 => (Storage::Retained, None),
            _ => (Storage::Imported { content: Some(spec.import), target: None }, Some(spec.import)),
        };
        let handle = graph.declare(format!("r{index}"), desc(spec.sizes[index]).into(), storage);
        versions.push(vec![(handle, value)]);
    }
    for (index, pass) in passes.iter().enumerate().filter(|(index, _)| spec.present[*index]) {
        declare(&mut graph, index, own(frame, spec, pass, index), pass, &mut versions);
    }
    let mut expected = BTreeMap::new();
    for (index, versions) in versions.iter().enumerate().filter(|(index, _)| spec.outputs[*index]) {
        if let Some((handle, Some(value))) = versions.last() {
            graph.output(*handle);
            expected.insert(format!("r{index}"), *value);
        }
    }
    (graph, expected)
}

fn own(frame: usize, spec: &FrameSpec, pass: &PassSpec, index: usize) -> u64 {
    if pass.keyed { spec.own[index] } else { 100 + frame as u64 }
}

fn declare(
    graph: &mut Graph<'static>,
    index: usize,
    own: u64,
    spec: &PassSpec,
    versions: &mut [Vec<(Handle<Texture>, Option<u64>)>],
) {
    let name = format!("p{index}");
    let mut pass = graph.pass(&name);
    let mut reads: Vec<(Handle<Texture>, u64)> = Vec::new();
    for &(resource, age) in &spec.reads {
        let of = &versions[resource];
        let (handle, value) = of[of.len().saturating_sub(1 + age)];
        let value = value.filter(|_| reads.iter().all(|(other, _)| *other != handle));
        if let Some(value) = value {
            pass.read(handle);
            reads.push((handle, value));
        }
    }
    let modified = spec.writes.iter().filter_map(|&resource| versions[resource].last()?.1);
    let inputs: Vec<u64> = reads.iter().map(|(_, value)| *value).chain(modified).collect();
    for &resource in &spec.writes {
        let handle = versions[resource].last().unwrap().0;
        versions[resource].push((pass.write(handle), Some(made(&name, own, &inputs, &format!("r{resource}")))));
    }
    if spec.keyed {
        pass.key(&own);
    }
    pass.execute(|_| Ok(()));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn cached_frames_equal_computed_ones(
        storages in prop::collection::vec(0..4u8, RESOURCES),
        passes in prop::collection::vec(pass_spec(), PASSES),
        frames in prop::collection::vec(frame_spec(), 1..7),
    ) {
        let mut cache = Cache::with_keep_frames(2);
        for (index, spec) in frames.iter().enumerate() {
            let (graph, expected) = build(index, spec, &storages, &passes);
            let fails = spec.fails.map(|pass| format!("p{pass}"));
            let own = |name: &str| {
                let pass: usize = name[1..].parse().unwrap();
                own(index, spec, &passes[pass], pass)
            };
            let world = World { own: &own, import: &|_| spec.import, fails: fails.as_deref() };
            let plan = match graph.compile(&cache, &CompileOptions { no_cache: spec.no_cache }) {
                Ok(plan) => plan,
                Err(error) => {
                    prop_assert!(matches!(error, GraphError::StaleRead { .. }), "{error}");
                    continue;
                }
            };
            check_cull(&plan, spec.no_cache)?;
            let Some(values) = run(plan, &mut cache, &world) else { continue };
            for (name, value) in expected {
                prop_assert_eq!(values.get(&name), Some(&value), "{} in frame {}", name, index);
            }
        }
    }
}

/// Without the cache nothing counts as cached.
fn check_cull(plan: &crate::graph::Plan<'_>, no_cache: bool) -> Result<(), TestCaseError> {
    let cached = plan.passes().iter().filter(|pass| pass.state == crate::graph::PassState::Cached).count();
    prop_assert!(!no_cache || cached == 0);
    Ok(())
}
