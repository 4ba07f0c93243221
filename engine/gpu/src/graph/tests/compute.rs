//! Compute passes whose content keys follow from what they bind.

use super::desc;
use crate::gpu::{BindError, ComputeKey, Gpu, GpuOptions, Pipeline, ShaderDef, read_texture};
use crate::graph::{
    CompileOptions, ComputeBuilder, Counts, FrameReport, Graph, Handle, PassState, Piece, PieceWork, SharedGroup,
    TargetCache, Texture, Tracked,
};
use std::fs;

const SUM: &str = "
#ifdef FACTOR
const factor = #{FACTOR}u;
#else
const factor = 1u;
#endif
@group(0) @binding(0) var<uniform> first: u32;
@group(0) @binding(1) var<storage> second: array<u32>;
@group(0) @binding(2) var left: texture_2d<u32>;
@group(0) @binding(3) var right: texture_2d<u32>;
@group(0) @binding(4) var sum: texture_storage_2d<r32uint, write>;
@group(1) @binding(0) var<uniform> shared_value: u32;
@compute @workgroup_size(8, 4) fn main(@builtin(global_invocation_id) id: vec3u) {
    let images = textureLoad(left, id.xy, 0).x - textureLoad(right, id.xy, 0).x;
    textureStore(sum, id.xy, vec4u(factor * (first + second[0] + images + shared_value)));
}";

const FILL: &str = "
struct Fill { first_row: u32, value: u32 }
@group(0) @binding(0) var<uniform> fill: Fill;
@group(0) @binding(1) var filled: texture_storage_2d<r32uint, write>;
@compute @workgroup_size(8, 8) fn main(@builtin(global_invocation_id) id: vec3u) {
    textureStore(filled, id.xy + vec2u(0u, fill.first_row), vec4u(fill.value));
}";

#[derive(encase::ShaderType)]
struct Fill {
    first_row: u32,
    value: u32,
}

/// A group 1 with a number.
struct Shared(u32);

impl SharedGroup for Shared {
    fn key(&self) -> u64 {
        self.0.into()
    }

    fn bind(&self, gpu: &Gpu, pipeline: &Pipeline) -> Result<wgpu::BindGroup, BindError> {
        let buffer = gpu.uniform("shared", &self.0);
        pipeline.bind(gpu, 1, &[("shared_value", crate::gpu::Binding::Buffer(&buffer))])
    }
}

/// All that the sum is made of.
#[derive(Clone, Copy)]
struct Parts<'a> {
    first: u32,
    second: &'a wgpu::Buffer,
    revision: u64,
    images: [u32; 2],
    is_turned: bool,
    shared: u32,
    factor: u32,
}

fn fill<'a>(graph: &mut Graph<'a>, name: &str, value: u32) -> Handle<Texture> {
    let desc = desc(16).with_usage(wgpu::TextureUsages::TEXTURE_BINDING);
    let filled = graph.retained_texture(name, desc);
    let mut pass = graph.compute(name, ComputeKey::new("fill.wgsl", "main"));
    let filled = pass.write("filled", filled);
    // A submit for every eight rows.
    let work = PieceWork { units: 1 << 20, on_software: 1 };
    pass.dispatch_rows([16, 16], work, "fill", move |rows: Piece| Fill { first_row: rows.first, value });
    filled
}

fn graph(parts: Parts) -> Graph {
    let mut graph = Graph::new(1);
    let [left, right] = [("left", 0), ("right", 1)].map(|(name, i)| fill(&mut graph, name, parts.images[i]));
    let sum = graph.retained_texture("sum", desc(16));
    let mut pass: ComputeBuilder = graph.compute("sum", ComputeKey::new("sum.wgsl", "main"));
    pass.define("FACTOR", ShaderDef::Uint(parts.factor));
    pass.uniform("first", &parts.first);
    pass.tracked("second", Tracked::buffer(parts.second, &parts.revision));
    let [left, right] = if parts.is_turned { [right, left] } else { [left, right] };
    pass.read("left", left);
    pass.read("right", right);
    pass.share(Shared(parts.shared));
    let sum = pass.write("sum", sum);
    pass.count(Counts { lights: 3, ..Counts::default() });
    pass.dispatch_over([16, 16]);
    graph.output(sum);
    graph
}

struct Bench {
    gpu: Gpu,
    cache: TargetCache,
    _dir: tempfile::TempDir,
}

impl Bench {
    fn new() -> Self {
        let dir = tempfile::tempdir().unwrap();
        fs::write(dir.path().join("sum.wgsl"), SUM).unwrap();
        fs::write(dir.path().join("fill.wgsl"), FILL).unwrap();
        let gpu = Gpu::headless(&GpuOptions { adapter: None, shader_dir: dir.path().into() }).unwrap();
        Self { gpu, cache: TargetCache::new(), _dir: dir }
    }

    /// Draws, and gives the report and the value of all texels.
    fn draw(&mut self, parts: Parts) -> (FrameReport, u32) {
        let plan = graph(parts).compile(&self.cache, &CompileOptions::default()).unwrap();
        let report = plan.execute(&self.gpu, &mut self.cache).unwrap();
        let bytes = read_texture(&self.gpu, self.cache.texture("sum").unwrap(), 0, 0).unwrap();
        let words: Vec<u32> = bytes.as_chunks().0.iter().map(|word| u32::from_le_bytes(*word)).collect();
        assert!(words.iter().all(|word| *word == words[0]), "{words:?}");
        (report, words[0])
    }
}

#[test]
fn a_pass_runs_again_where_anything_that_it_binds_has_changed() {
    let mut bench = Bench::new();
    let [five, six] = [5_u32, 6].map(|value| bench.gpu.constants("second", &[value]));
    let all =
        Parts { first: 1, second: &five, revision: 0, images: [40, 10], is_turned: false, shared: 100, factor: 1 };
    let (report, value) = bench.draw(all);
    assert_eq!(value, 1 + 5 + 30 + 100);
    let pass = report.pass("sum").unwrap();
    assert_eq!((pass.counts.texels, pass.counts.dispatches, pass.counts.lights), (256, 1, 3));
    assert_eq!(report.pass("left").unwrap().counts.dispatches, 2, "pieces of eight rows");
    let changes = [
        (Parts { first: 2, ..all }, 137),
        (Parts { second: &six, revision: 1, ..all }, 137),
        (Parts { images: [41, 10], ..all }, 137),
        (Parts { images: [41, 11], ..all }, 136),
        (Parts { images: [10, 40], is_turned: true, ..all }, 136),
        (Parts { is_turned: true, ..all }, 76),
        (Parts { shared: 101, ..all }, 137),
        (Parts { factor: 2, ..all }, 272),
        (all, 136),
    ];
    for (index, (parts, expected)) in changes.into_iter().enumerate() {
        let (report, value) = bench.draw(parts);
        assert_eq!(value, expected, "change {index}");
        assert_eq!(report.pass("sum").unwrap().state, PassState::Ran, "change {index}");
        let (report, value) = bench.draw(parts);
        assert_eq!(value, expected);
        assert_eq!(report.pass("sum").unwrap().state, PassState::Cached, "change {index}");
    }
    assert!(bench.gpu.take_errors().is_empty());
}

#[test]
fn what_the_shader_does_not_declare_is_an_error_that_names_it() {
    let bench = Bench::new();
    let mut graph = Graph::new(1);
    let sum = graph.retained_texture("sum", desc(16));
    let mut pass = graph.compute("sum", ComputeKey::new("fill.wgsl", "main"));
    pass.uniform("colour", &1_u32);
    let sum = pass.write("filled", sum);
    pass.dispatch_over([16, 16]);
    graph.output(sum);
    let mut cache = TargetCache::new();
    let plan = graph.compile(&cache, &CompileOptions::default()).unwrap();
    let error = plan.execute(&bench.gpu, &mut cache).expect_err("there is no `colour`").to_string();
    assert!(error.contains("sum") && error.contains("`colour`") && error.contains("fill"), "{error}");
}
