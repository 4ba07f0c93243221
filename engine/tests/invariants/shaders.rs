//! Every entry point of every shader goes through the real import path and becomes a pipeline's layout.

use lightwell::gpu::{Gpu, GpuOptions, default_shader_dir};

#[test]
fn every_entry_point_compiles_and_its_bindings_are_portable() {
    let options = GpuOptions { adapter: None, shader_dir: default_shader_dir().expect("shaders") };
    let gpu = Gpu::headless(&options).expect("a Vulkan driver");
    let files = gpu.shaders.shader_files();
    assert!(!files.is_empty());
    for file in files {
        let entries = gpu.shaders.entry_points(&file).unwrap_or_else(|error| panic!("{error}"));
        assert!(!entries.is_empty(), "{file} has no entry point");
        for entry in entries {
            let storage = entry.bindings.iter().filter(|b| {
                matches!(b.ty, wgpu::BindingType::Buffer { ty: wgpu::BufferBindingType::Storage { .. }, .. })
            });
            assert!(storage.count() <= 8, "{file}: `{}` binds more than the portable 8 storage buffers", entry.name);
        }
    }
}
