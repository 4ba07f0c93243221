//! Passes of several dispatches or draws, whose content keys follow from all of them.

use super::desc;
use crate::gpu::{ComputeKey, Gpu, GpuOptions, RasterKey, ShaderDef, read_buffer, read_texture};
use crate::graph::{
    BufferDesc, CompileOptions, Contents, FrameReport, Graph, PassState, Piece, PieceWork, TargetCache,
};
use std::fs;
use wgpu::BufferUsages;

const CHAIN: &str = "
#ifdef FACTOR
const factor = #{FACTOR}u;
#else
const factor = 1u;
#endif
@group(0) @binding(0) var<uniform> added: vec2u;
@group(0) @binding(1) var<storage> source: array<u32>;
@group(0) @binding(2) var<storage, read_write> sum: array<u32>;
@compute @workgroup_size(64) fn add(@builtin(global_invocation_id) id: vec3u) {
    sum[id.x + added.y] += factor * added.x;
}
@compute @workgroup_size(64) fn double(@builtin(global_invocation_id) id: vec3u) {
    sum[id.x] += 2u * source[id.x];
}";

const FLAT: &str = "
@group(0) @binding(0) var<uniform> value: u32;
@vertex fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(f32(index % 2u) * 4.0 - 1.0, f32(index / 2u) * 4.0 - 1.0, 0.0, 1.0);
}
@fragment fn fragment() -> @location(0) u32 {
    return value;
}";

/// Numbers that a pass sums up.
const COUNT: u32 = 256;

struct Bench {
    gpu: Gpu,
    cache: TargetCache,
    _dir: tempfile::TempDir,
}

impl Bench {
    fn new() -> Self {
        let dir = tempfile::tempdir().unwrap();
        fs::write(dir.path().join("chain.wgsl"), CHAIN).unwrap();
        fs::write(dir.path().join("flat.wgsl"), FLAT).unwrap();
        let gpu = Gpu::headless(&GpuOptions { adapter: None, shader_dir: dir.path().into() }).unwrap();
        Self { gpu, cache: TargetCache::new(), _dir: dir }
    }

    fn run(&mut self, graph: Graph) -> FrameReport {
        let plan = graph.compile(&self.cache, &CompileOptions::default()).unwrap();
        plan.execute(&self.gpu, &mut self.cache).unwrap()
    }

    /// The report, and the number that all of `sum` are.
    fn sum(&mut self, chain: Chain) -> (FrameReport, u32) {
        let report = self.run(chain.graph());
        let words: Vec<u32> = read_buffer(&self.gpu, self.cache.buffer("sum").unwrap()).unwrap();
        assert!(words.iter().all(|word| *word == words[0]), "{words:?}");
        (report, words[0])
    }

    /// The report, and the value of all texels of `image`.
    fn image(&mut self, graph: Graph) -> (FrameReport, u32) {
        let report = self.run(graph);
        let bytes = read_texture(&self.gpu, self.cache.texture("image").unwrap(), 0, 0).unwrap();
        let words: Vec<u32> = bytes.as_chunks().0.iter().map(|word| u32::from_le_bytes(*word)).collect();
        assert!(words.iter().all(|word| *word == words[0]), "{words:?}");
        (report, words[0])
    }
}

/// Adds numbers to one buffer, and twice that to another.
#[derive(Clone, Copy)]
struct Chain {
    added: &'static [u32],
    is_doubled: bool,
    is_copied: bool,
    factor: u32,
}

impl Chain {
    fn graph(self) -> Graph<'static> {
        let mut graph = Graph::new(1);
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST | BufferUsages::COPY_SRC;
        let [part, sum] = ["part", "sum"].map(|name| {
            let desc = BufferDesc::new(4 * u64::from(COUNT), usage);
            if name == "sum" { graph.retained_buffer(name, desc) } else { graph.buffer(name, desc) }
        });
        let mut pass = graph.compute("chain", ComputeKey::new("chain.wgsl", "add"));
        let [part, sum] = [part, sum].map(|buffer| pass.write_in_steps(buffer));
        pass.clear(part);
        for &number in self.added {
            let mut step = pass.step("add");
            step.define("FACTOR", ShaderDef::Uint(self.factor));
            step.read("sum", part);
            // A submit for every two workgroups.
            let work = PieceWork { units: 1 << 20, on_software: 1 << 27 };
            step.over_pieces(COUNT, work, "added", move |items: Piece| vec![glam::UVec2::new(number, items.first)]);
        }
        if self.is_copied {
            pass.copy(part, sum);
        } else {
            pass.clear(sum);
        }
        if self.is_doubled {
            let mut step = pass.step("double");
            step.read("source", part);
            step.read("sum", sum);
            step.over_items(COUNT);
        }
        pass.finish();
        graph.output(sum);
        graph
    }
}

#[test]
fn a_pass_of_steps_runs_again_where_any_of_them_has_changed() {
    let mut bench = Bench::new();
    let all = Chain { added: &[3, 4], is_doubled: true, is_copied: false, factor: 1 };
    let (report, sum) = bench.sum(all);
    assert_eq!(sum, 14);
    assert_eq!(report.pass("chain").unwrap().counts.dispatches, 5, "two of two pieces, and one");
    let changes = [
        (Chain { added: &[3, 5], ..all }, 16),
        (Chain { added: &[3], ..all }, 6),
        (Chain { added: &[], ..all }, 0),
        (Chain { is_copied: true, ..all }, 21),
        (Chain { is_copied: true, is_doubled: false, ..all }, 7),
        (Chain { is_doubled: false, ..all }, 0),
        (Chain { factor: 2, ..all }, 28),
        (all, 14),
    ];
    for (index, (chain, expected)) in changes.into_iter().enumerate() {
        let (report, sum) = bench.sum(chain);
        assert_eq!(sum, expected, "change {index}");
        assert_eq!(report.pass("chain").unwrap().state, PassState::Ran, "change {index}");
        let (report, sum) = bench.sum(chain);
        assert_eq!((sum, &report.pass("chain").unwrap().state), (expected, &PassState::Cached), "change {index}");
    }
    assert!(bench.gpu.take_errors().is_empty());
}

fn flat(values: &[u32], vertices: u32) -> Graph<'static> {
    let mut graph = Graph::new(1);
    let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
    let image = graph.retained_texture("image", desc(16).with_usage(usage));
    let pipeline = || RasterKey {
        shader: "flat.wgsl",
        vertex: "vertex",
        fragment: Some("fragment"),
        defs: Vec::new(),
        vertex_buffers: Vec::new(),
        primitive: wgpu::PrimitiveState::default(),
        depth: None,
        targets: vec![Some(wgpu::TextureFormat::R32Uint.into())],
    };
    let mut pass = graph.raster("flat");
    let image = pass.color(image, Contents::Cleared);
    for value in values {
        let mut step = pass.step();
        step.uniform("value", value);
        step.draw(pipeline(), [vertices, 1]);
    }
    pass.finish();
    graph.output(image);
    graph
}

#[test]
fn a_raster_pass_runs_again_where_anything_that_it_draws_has_changed() {
    let mut bench = Bench::new();
    for (index, (values, vertices, expected)) in
        [(&[7][..], 3, 7), (&[8], 3, 8), (&[8, 9], 3, 9), (&[9, 8], 3, 8), (&[9, 8], 0, 0), (&[7], 3, 7)]
            .into_iter()
            .enumerate()
    {
        let (report, value) = bench.image(flat(values, vertices));
        let pass = report.pass("flat").unwrap();
        assert_eq!((value, &pass.state), (expected, &PassState::Ran), "change {index}");
        assert_eq!(pass.counts.draws, if vertices == 0 { 0 } else { values.len() as u64 });
        let (report, value) = bench.image(flat(values, vertices));
        assert_eq!((value, &report.pass("flat").unwrap().state), (expected, &PassState::Cached), "change {index}");
    }
    assert!(bench.gpu.take_errors().is_empty());
}
