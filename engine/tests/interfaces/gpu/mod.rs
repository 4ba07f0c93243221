//! The graphics device: adapters, shaders and their reload, pipelines and bindings, timers, readback.

mod context;
mod pipelines;
mod readback;
mod reload;

use lightwell::gpu::{Binding, ComputeKey, Gpu, GpuOptions, ShaderError, read_buffer};
use std::path::Path;

/// A file that others import.
pub const LIBRARY: &str = "#define_import_path test::numbers\n\nfn answer() -> u32 {\n    return 40u;\n}\n";

/// Writes `answer() + 2` times the input.
pub const SHADER: &str = "\
#import test::numbers::answer

@group(0) @binding(0) var<storage, read> input: array<u32>;
@group(0) @binding(1) var<storage, read_write> output: array<u32>;
@group(0) @binding(2) var spare: texture_2d<f32>;

@compute @workgroup_size(4)
fn main(@builtin(global_invocation_id) id: vec3u) {
    output[id.x] = (answer() + 2u) * input[id.x];
}
";

/// Writes a file of the shader folder in place.
pub fn write(dir: &Path, name: &str, text: &str) {
    std::fs::write(dir.join(name), text).expect("write shader");
}

/// A device with the two files above.
pub fn open() -> (tempfile::TempDir, Gpu) {
    let dir = tempfile::tempdir().expect("temporary folder");
    std::fs::create_dir(dir.path().join("lib")).expect("folder");
    write(dir.path(), "lib/numbers.wgsl", LIBRARY);
    write(dir.path(), "test.wgsl", SHADER);
    let gpu = open_dir(dir.path());
    (dir, gpu)
}

/// A device with the shaders of that folder.
pub fn open_dir(dir: &Path) -> Gpu {
    Gpu::headless(&GpuOptions { adapter: None, shader_dir: dir.to_owned() }).expect("a Vulkan driver")
}

/// What the shader makes of 1, 2, 3, 4.
pub fn dispatch(gpu: &Gpu) -> Result<Vec<u32>, ShaderError> {
    let pipeline = gpu.pipelines.compute(gpu, &ComputeKey::new("test.wgsl", "main"))?;
    assert_eq!(pipeline.workgroup_size(), [4, 1, 1]);
    let input = gpu.storage("input", &[1_u32, 2, 3, 4], wgpu::BufferUsages::empty());
    let output = gpu.storage("output", &[0_u32; 4], wgpu::BufferUsages::empty());
    let bindings = [("input", Binding::Buffer(&input)), ("output", Binding::Buffer(&output))];
    let group = pipeline.bind(gpu, 0, &bindings).expect("bind");
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(pipeline.compute().expect("a compute pipeline"));
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(1, 1, 1);
    }
    gpu.queue.submit([encoder.finish()]);
    let result = read_buffer(gpu, &output).expect("read");
    assert_eq!(gpu.take_errors(), Vec::<String>::new());
    assert_eq!(gpu.device_lost(), None);
    Ok(result)
}
