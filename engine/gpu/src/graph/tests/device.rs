//! Graphs on a device.

use std::fs;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use super::desc;
use crate::gpu::{Binding, ComputeKey, Gpu, GpuOptions, read_texture};
use crate::graph::{
    CompileOptions, FramePacing, FrameReport, Graph, GraphError, PassError, PassState, TargetCache, TextureDesc,
};

const FILL: &str = "
@group(0) @binding(0) var target_image: texture_storage_2d<r32uint, write>;
@compute @workgroup_size(8, 8) fn fill(@builtin(global_invocation_id) id: vec3<u32>) {
    textureStore(target_image, id.xy, vec4<u32>(id.x * 3u + id.y * 1000u));
}";

const TWICE: &str = "
@group(0) @binding(0) var source: texture_2d<u32>;
@group(0) @binding(1) var target_image: texture_storage_2d<r32uint, write>;
@compute @workgroup_size(8, 8) fn twice(@builtin(global_invocation_id) id: vec3<u32>) {
    textureStore(target_image, id.xy, textureLoad(source, id.xy, 0) * 2u);
}";

fn gpu() -> (tempfile::TempDir, Gpu) {
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("fill.wgsl"), FILL).unwrap();
    fs::write(dir.path().join("twice.wgsl"), TWICE).unwrap();
    let gpu = Gpu::headless(&GpuOptions { adapter: None, shader_dir: dir.path().into() }).unwrap();
    (dir, gpu)
}

fn image() -> TextureDesc {
    desc(16).with_usage(wgpu::TextureUsages::TEXTURE_BINDING)
}

/// fill → twice, both kept.
fn two_passes<'a>(splits: bool) -> Graph<'a> {
    let mut graph = Graph::new(1);
    let filled = graph.retained_texture("filled", image());
    let doubled = graph.retained_texture("doubled", image());
    let mut pass = graph.pass("fill");
    let filled = pass.write(filled);
    pass.key(&());
    pass.execute(move |cx| {
        let view = cx.view(filled);
        cx.counts().texels += 16 * 16;
        cx.dispatch(&ComputeKey::new("fill.wgsl", "fill"), &[("target_image", Binding::Texture(&view))], [2, 2, 1])?;
        if splits {
            cx.submit();
        }
        Ok(())
    });
    let mut pass = graph.pass("twice");
    pass.read(filled);
    let doubled = pass.write(doubled);
    pass.key(&());
    pass.execute(move |cx| {
        let (source, target) = (cx.view(filled), cx.view(doubled));
        let bindings = [("source", Binding::Texture(&source)), ("target_image", Binding::Texture(&target))];
        cx.dispatch(&ComputeKey::new("twice.wgsl", "twice"), &bindings, [2, 2, 1])
    });
    graph.output(doubled);
    graph
}

fn run(gpu: &Gpu, cache: &mut TargetCache, graph: Graph<'_>, no_cache: bool) -> Result<FrameReport, GraphError> {
    graph.compile(cache, &CompileOptions { no_cache })?.execute(gpu, cache)
}

fn texels(gpu: &Gpu, cache: &TargetCache) -> Vec<u8> {
    read_texture(gpu, cache.texture("doubled").unwrap(), 0, 0).unwrap()
}

#[test]
fn the_second_frame_is_cached_and_has_the_same_bits() {
    let (_dir, gpu) = gpu();
    let mut cache = TargetCache::new();
    let first = run(&gpu, &mut cache, two_passes(false), false).unwrap();
    assert_eq!((first.ran_count(), first.submits), (2, 1), "{first}");
    assert_eq!((first.total().dispatches, first.total().texels), (2, 256));
    assert_eq!(first.allocated_bytes, 2 * 16 * 16 * 4);
    let timed = gpu.features.contains(wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS);
    assert_eq!(first.pass("twice").unwrap().gpu_ms.is_some(), timed);
    let bits = texels(&gpu, &cache);
    let word = |index: usize| u32::from_le_bytes(bits[index * 4..][..4].try_into().unwrap());
    assert_eq!((word(1), word(16 * 5 + 7)), (6, 2 * (7 * 3 + 5 * 1000)));
    let second = run(&gpu, &mut cache, two_passes(false), false).unwrap();
    assert!(second.passes.iter().all(|pass| pass.state == PassState::Cached), "{second}");
    assert_eq!(second.total(), Default::default());
    assert_eq!(texels(&gpu, &cache), bits);
    let third = run(&gpu, &mut cache, two_passes(true), true).unwrap();
    assert_eq!((third.ran_count(), third.submits), (2, 2));
    assert_eq!(texels(&gpu, &cache), bits);
    assert!(gpu.take_errors().is_empty());
}

/// A pass over one retained texture that does what a test wants.
fn one_pass<'a>(work: impl FnOnce(&mut crate::graph::PassContext<'_>) -> Result<(), PassError> + 'a) -> Graph<'a> {
    let mut graph = two_passes(false);
    let other = graph.retained_texture("other", image());
    let mut pass = graph.pass("test");
    let other = pass.write(other);
    pass.key(&());
    pass.execute(work);
    graph.output(other);
    graph
}

fn is_written(gpu: &Gpu, cache: &mut TargetCache) -> [bool; 2] {
    let report = run(gpu, cache, one_pass(|_| Ok(())), false).unwrap();
    ["twice", "test"].map(|name| !report.ran(name))
}

#[test]
fn a_failed_pass_is_named_and_those_before_it_stay() {
    let (_dir, gpu) = gpu();
    let mut cache = TargetCache::new();
    let error = run(&gpu, &mut cache, one_pass(|_| Err(PassError::message("no light"))), false).unwrap_err();
    assert_eq!(error.to_string(), "pass `test` failed: no light");
    assert_eq!(is_written(&gpu, &mut cache), [true, false]);
    let bits = texels(&gpu, &cache);
    assert_eq!(bits[4..8], [6, 0, 0, 0], "what ran before the failure was submitted");
}

#[test]
fn an_undeclared_resource_fails_the_pass() {
    let (_dir, gpu) = gpu();
    let mut cache = TargetCache::new();
    let stranger = Graph::new(0).texture("stranger", image());
    let graph = one_pass(move |cx| {
        cx.view(stranger);
        Ok(())
    });
    let error = run(&gpu, &mut cache, graph, false).unwrap_err().to_string();
    assert!(error.contains("`test`") && error.contains("another graph"), "{error}");
    assert_eq!(is_written(&gpu, &mut cache), [true, false]);
}

#[test]
fn what_the_device_refuses_is_an_error_and_nothing_is_kept() {
    let (_dir, gpu) = gpu();
    let mut cache = TargetCache::new();
    let graph = one_pass(|cx| {
        let buffer = cx.gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("wrong"),
            size: 16,
            usage: wgpu::BufferUsages::VERTEX,
            mapped_at_creation: false,
        });
        cx.encoder().clear_buffer(&buffer, 0, None);
        Ok(())
    });
    let error = run(&gpu, &mut cache, graph, false).unwrap_err();
    assert!(matches!(error, GraphError::Device { .. }), "{error}");
    assert_eq!(is_written(&gpu, &mut cache), [false, false]);
    assert!(gpu.take_errors().is_empty(), "the error is told once");
}

#[test]
fn a_frame_that_is_dropped_ends_in_the_middle_of_long_work_and_is_made_anew() {
    let (_dir, gpu) = gpu();
    let mut cache = TargetCache::new();
    let pacing = Arc::new(FramePacing::new(&gpu.info));
    cache.set_pacing(Some(pacing.clone()));
    // One pass in ten pieces, in the third of which another picture is asked for.
    let long = |drops: bool| {
        let mut graph = Graph::new(1);
        let filled = graph.retained_texture("filled", image());
        let mut pass = graph.pass("fill");
        let filled = pass.write(filled);
        pass.key(&());
        let (done, pacing) = (Arc::new(AtomicU32::new(0)), pacing.clone());
        let count = done.clone();
        pass.execute(move |cx| {
            let view = cx.view(filled);
            for piece in 0..10 {
                cx.work(1, 1)?;
                let bindings = [("target_image", Binding::Texture(&view))];
                cx.dispatch(&ComputeKey::new("fill.wgsl", "fill"), &bindings, [2, 2, 1])?;
                count.store(piece + 1, Ordering::Relaxed);
                if drops && piece == 2 {
                    pacing.drop_frame();
                }
            }
            Ok(())
        });
        graph.output(filled);
        (graph, done)
    };
    let (graph, done) = long(true);
    assert!(matches!(run(&gpu, &mut cache, graph, false), Err(GraphError::Stopped)));
    assert_eq!(done.load(Ordering::Relaxed), 3, "no piece after the third");
    pacing.restart();
    let (graph, done) = long(false);
    let report = run(&gpu, &mut cache, graph, false).unwrap();
    assert_eq!((report.ran_count(), done.load(Ordering::Relaxed)), (1, 10), "what was half done is not kept");
    assert!(read_texture(&gpu, cache.texture("filled").unwrap(), 0, 0).is_ok());
}

#[test]
fn a_target_too_large_for_the_device_is_an_error() {
    let (_dir, gpu) = gpu();
    let mut cache = TargetCache::new();
    let mut graph = Graph::new(0);
    let huge = graph.retained_texture("huge", desc(1 << 20));
    let mut pass = graph.pass("huge");
    let huge = pass.write(huge);
    pass.execute(|_| Ok(()));
    graph.output(huge);
    let error = run(&gpu, &mut cache, graph, false).unwrap_err();
    assert!(matches!(error, GraphError::Device { .. }), "{error}");
    assert_eq!(cache.figures().retained, 0, "memory that was not made is not kept");
}

#[test]
fn imports_are_used_as_they_are() {
    let (_dir, gpu) = gpu();
    let mut cache = TargetCache::new();
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("import"),
        size: image().extent(),
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::R32Uint,
        usage: image().usage | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    for (content, ran) in [(Some(1), true), (Some(1), false), (Some(2), true), (None, true), (None, true)] {
        let mut graph = Graph::new(0);
        let source = graph.import_texture("source", texture.clone(), content);
        let doubled = graph.retained_texture("doubled", image());
        let mut pass = graph.pass("twice");
        pass.read(source);
        let doubled = pass.write(doubled);
        pass.key(&());
        pass.execute(move |cx| {
            let (source, target) = (cx.view(source), cx.view(doubled));
            let bindings = [("source", Binding::Texture(&source)), ("target_image", Binding::Texture(&target))];
            cx.dispatch(&ComputeKey::new("twice.wgsl", "twice"), &bindings, [2, 2, 1])
        });
        graph.output(doubled);
        assert_eq!(run(&gpu, &mut cache, graph, false).unwrap().ran("twice"), ran, "{content:?}");
    }
}
