//! Passes that run, are reused or are culled, and the reasons.

use super::simulation::{Cache, World, frame, frame_with, states, why};
use super::{desc, pass};
use crate::graph::{Buffer, BufferDesc, Graph, Handle, Texture};

fn cache() -> Cache {
    Cache::with_keep_frames(8)
}

/// geometry (transient) → shadow (retained) → light (retained, output), and one that nobody reads.
fn scene(seed: u64, keys: [Option<u64>; 3]) -> Graph<'static> {
    let mut graph = Graph::new(seed);
    let geometry = graph.texture("geometry", desc(8));
    let shadow = graph.retained_texture("shadow", desc(16));
    let image = graph.retained_texture("image", desc(8));
    let unused = graph.texture("unused", desc(8));
    let ([geometry], _) = pass(&mut graph, "draw", keys[0], &[], [geometry]);
    let ([shadow], _) = pass(&mut graph, "cast", keys[1], &[geometry], [shadow]);
    let ([image], _) = pass(&mut graph, "light", keys[2], &[shadow], [image]);
    pass(&mut graph, "lost", Some(0), &[image], [unused]);
    graph.skip("rsm", "no volume in the scene");
    graph.output(image);
    graph
}

const KEYS: [Option<u64>; 3] = [Some(0), Some(0), Some(0)];

#[test]
fn the_second_frame_is_cached() {
    let mut cache = cache();
    let first = frame(scene(0, KEYS), &mut cache);
    assert_eq!(states(&first), "rrrxs");
    assert_eq!(why(&first, "lost"), "nothing reads `unused`");
    assert_eq!(why(&first, "light"), "`image` is not in the cache yet");
    assert_eq!(why(&first, "draw"), "`cast` needs `geometry`");
    assert_eq!(why(&first, "rsm"), "no volume in the scene");
    let second = frame(scene(0, KEYS), &mut cache);
    assert_eq!(states(&second), "xccxs");
    assert_eq!(why(&second, "light"), "`image` unchanged");
    assert_eq!(why(&second, "draw"), "only needed by `cast`, which is cached");
}

#[test]
fn a_changed_key_reruns_what_is_downstream_only() {
    let mut cache = cache();
    frame(scene(0, KEYS), &mut cache);
    let light = frame(scene(0, [Some(0), Some(0), Some(1)]), &mut cache);
    assert_eq!(states(&light), "xcrxs");
    assert_eq!(why(&light, "light"), "its key changed");
    let draw = frame(scene(0, [Some(1), Some(0), Some(1)]), &mut cache);
    assert_eq!(states(&draw), "rrrxs");
    assert_eq!(why(&draw, "cast"), "`geometry` changed");
    assert_eq!(why(&draw, "light"), "`shadow` changed");
    let seed = frame(scene(7, [Some(1), Some(0), Some(1)]), &mut cache);
    assert_eq!(states(&seed), "rrrxs");
    assert_eq!(why(&seed, "cast"), "the seed changed");
}

#[test]
fn an_edit_undone_runs_once_more_and_then_is_cached() {
    let mut cache = cache();
    let edits = [(0, "rrrxs"), (1, "xcrxs"), (0, "xcrxs"), (0, "xccxs")];
    for (key, expected) in edits {
        assert_eq!(states(&frame(scene(0, [Some(0), Some(0), Some(key)]), &mut cache)), expected);
    }
}

#[test]
fn a_pass_without_key_runs_every_frame_and_so_does_what_follows() {
    let mut cache = cache();
    let keys = [Some(0), None, Some(0)];
    for _ in 0..3 {
        assert_eq!(states(&frame(scene(0, keys), &mut cache)), "rrrxs");
    }
    let report = frame(scene(0, keys), &mut cache);
    assert_eq!(why(&report, "cast"), "it states no key, so it runs every frame");
    assert_eq!(why(&report, "light"), "`shadow` changes every frame");
    // Later frames do not reuse its content.
    assert_eq!(states(&frame(scene(0, KEYS), &mut cache)), "rrrxs");
}

#[test]
fn no_cache_runs_all_that_is_wanted() {
    let mut cache = cache();
    for _ in 0..2 {
        let report = frame_with(scene(0, KEYS), &mut cache, &World::default(), true).unwrap();
        assert_eq!(states(&report), "rrrxs");
        assert_eq!(why(&report, "light"), "caching is off");
    }
    assert_eq!(states(&frame(scene(0, KEYS), &mut cache)), "xccxs");
}

/// clear → add a → add b, all in one retained target.
fn accumulate(keys: [u64; 3], read_first: Option<u64>) -> Graph<'static> {
    let mut graph = Graph::new(0);
    let sum = graph.retained_texture("sum", desc(8));
    let ([one], _) = pass(&mut graph, "clear", Some(keys[0]), &[], [sum]);
    let ([two], _) = pass(&mut graph, "add a", Some(keys[1]), &[], [one]);
    let ([three], _) = pass(&mut graph, "add b", Some(keys[2]), &[], [two]);
    if let Some(key) = read_first {
        let copy = graph.retained_texture("copy", desc(8));
        let ([copy], _) = pass(&mut graph, "read", Some(key), &[one], [copy]);
        graph.output(copy);
    }
    graph.output(three);
    graph
}

#[test]
fn a_chain_in_place_is_cached_as_a_whole() {
    let mut cache = cache();
    assert_eq!(states(&frame(accumulate([0; 3], None), &mut cache)), "rrr");
    let second = frame(accumulate([0; 3], None), &mut cache);
    assert_eq!(states(&second), "xxc");
    assert_eq!(why(&second, "clear"), "only needed by `add a`, which is culled");
    assert_eq!(why(&second, "add a"), "only needed by `add b`, which is cached");
    // The last change needs the version before it, which is overwritten: all again.
    let last = frame(accumulate([0, 0, 1], None), &mut cache);
    assert_eq!(states(&last), "rrr");
    assert_eq!(why(&last, "add b"), "its key changed");
    assert_eq!(why(&last, "clear"), "`sum` is needed as it was before `add a` overwrote it");
}

#[test]
fn an_older_version_that_is_wanted_runs_its_writer_again() {
    let mut cache = cache();
    assert_eq!(states(&frame(accumulate([0; 3], Some(0)), &mut cache)), "rrrr");
    assert_eq!(states(&frame(accumulate([0; 3], Some(0)), &mut cache)), "xxcc");
    // `read` wants the cleared target; making it destroys the sum, which is an output.
    let report = frame(accumulate([0; 3], Some(1)), &mut cache);
    assert_eq!(states(&report), "rrrr");
    assert_eq!(why(&report, "add b"), "`sum` is overwritten in this frame before it is used");
}

#[test]
fn a_cached_version_is_read_before_it_is_overwritten() {
    let build = |more: bool| {
        let mut graph = Graph::new(0);
        let volume = graph.retained_texture("volume", desc(8));
        let image = graph.retained_texture("image", desc(8));
        let ([first], _) = pass(&mut graph, "inject", Some(0), &[], [volume]);
        let second = more.then(|| pass(&mut graph, "spread", Some(0), &[], [first]).0[0]);
        let ([image], _) = pass(&mut graph, "show", Some(more.into()), &[first], [image]);
        second.into_iter().chain([image]).for_each(|handle| graph.output(handle));
        graph
    };
    let mut cache = cache();
    frame(build(false), &mut cache);
    let plan = build(true).compile(&cache, &Default::default()).unwrap();
    assert_eq!(plan.running().collect::<Vec<_>>(), ["show", "spread"]);
}

/// One pass makes a retained and a transient target.
fn two_outputs(image_key: u64, uses_side: bool) -> Graph<'static> {
    let mut graph = Graph::new(0);
    let main = graph.retained_texture("main", desc(8));
    let side = graph.texture("side", desc(8));
    let image = graph.retained_texture("image", desc(8));
    let ([main, side], _) = pass(&mut graph, "both", Some(0), &[], [main, side]);
    let reads: &[Handle<Texture>] = if uses_side { &[main, side] } else { &[main] };
    let ([image], _) = pass(&mut graph, "show", Some(image_key), reads, [image]);
    graph.output(image);
    graph
}

#[test]
fn a_pass_with_two_outputs_runs_if_a_transient_one_is_wanted() {
    let mut cache = cache();
    assert_eq!(states(&frame(two_outputs(0, false), &mut cache)), "rr");
    assert_eq!(states(&frame(two_outputs(1, false), &mut cache)), "cr");
    let report = frame(two_outputs(1, true), &mut cache);
    assert_eq!(states(&report), "rr");
    assert_eq!(why(&report, "both"), "`show` needs `side`");
    assert_eq!(states(&frame(two_outputs(1, true), &mut cache)), "xc");
}

#[test]
fn a_failed_pass_leaves_nothing_in_the_cache() {
    let mut cache = cache();
    frame(scene(0, KEYS), &mut cache);
    let fails = World { fails: Some("light"), ..World::default() };
    frame_with(scene(0, [Some(0), Some(1), Some(0)]), &mut cache, &fails, false).unwrap();
    // The shadow that was made before the failure is good; the image is not, not even as it was.
    let next = frame(scene(0, [Some(0), Some(1), Some(0)]), &mut cache);
    assert_eq!(states(&next), "xcrxs");
}

#[test]
fn an_invalidated_target_is_made_again() {
    let mut cache = cache();
    frame(scene(0, KEYS), &mut cache);
    cache.invalidate("image");
    let report = frame(scene(0, KEYS), &mut cache);
    assert_eq!(states(&report), "xcrxs");
    assert_eq!(why(&report, "light"), "what `image` holds was invalidated");
}

#[test]
fn two_names_are_two_contents() {
    let build = |name: &str| {
        let mut graph = Graph::new(0);
        let image = graph.retained_texture(name, desc(8));
        let ([image], _) = pass(&mut graph, "draw", Some(0), &[], [image]);
        graph.output(image);
        graph
    };
    let mut cache = cache();
    for (name, expected) in [("left", "r"), ("right", "r"), ("left", "c"), ("right", "c")] {
        assert_eq!(states(&frame(build(name), &mut cache)), expected);
    }
}

#[test]
fn order_without_data_is_kept_and_ties_follow_the_declaration() {
    let mut graph = Graph::new(0);
    let targets = ["a", "b", "c"].map(|name| graph.texture(name, desc(8)));
    let ids = targets.map(|target| {
        let name = format!("pass {}", target.at.resource);
        let ([written], id) = pass(&mut graph, &name, None, &[], [target]);
        graph.output(written);
        id
    });
    graph.order(ids[2], ids[0]);
    let plan = graph.compile(&cache(), &Default::default()).unwrap();
    assert_eq!(plan.running().collect::<Vec<_>>(), ["pass 1", "pass 2", "pass 0"]);
}

#[test]
fn buffers_are_cached_like_textures() {
    let build = || {
        let mut graph = Graph::new(0);
        let buffer: Handle<Buffer> = graph.retained_buffer("counts", BufferDesc::new(64, wgpu::BufferUsages::STORAGE));
        let mut pass = graph.pass("count");
        let buffer = pass.write(buffer);
        pass.key(&());
        pass.execute(|_| Ok(()));
        graph.output(buffer);
        graph
    };
    let mut cache = cache();
    assert_eq!(states(&frame(build(), &mut cache)), "r");
    assert_eq!(states(&frame(build(), &mut cache)), "c");
    assert_eq!(cache.figures().retained_bytes, 64);
}

#[test]
fn the_report_prints_a_table() {
    let text = frame(scene(0, KEYS), &mut cache()).to_string();
    assert!(text.contains("light  ran"), "{text}");
    assert!(text.contains("rsm    skipped"), "{text}");
    assert!(text.contains("no volume in the scene"), "{text}");
}
