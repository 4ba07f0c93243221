use super::{dispatch, open, write};
use lightwell::gpu::{Binding, ComputeKey, RasterKey, ShaderDef};
use std::sync::Arc;

#[test]
fn a_shader_with_an_import_computes() {
    let (_dir, gpu) = open();
    assert_eq!(dispatch(&gpu).expect("pipeline"), [42, 84, 126, 168]);
}

#[test]
fn a_pipeline_is_made_once() {
    let (_dir, gpu) = open();
    let key = ComputeKey::new("test.wgsl", "main");
    let first = gpu.pipelines.compute(&gpu, &key).expect("pipeline");
    assert!(Arc::ptr_eq(&first, &gpu.pipelines.compute(&gpu, &key).expect("pipeline")));
    assert_eq!(gpu.pipelines.len(), 1);
}

#[test]
fn binding_errors_name_shader_and_binding() {
    let (_dir, gpu) = open();
    let pipeline = gpu.pipelines.compute(&gpu, &ComputeKey::new("test.wgsl", "main")).expect("pipeline");
    let buffer = gpu.storage("numbers", &[0_u32; 4], wgpu::BufferUsages::empty());
    let uniform = gpu.uniform("uniform", &1.0_f32);
    let sampler = gpu.sampler(&Default::default());
    let whole = Binding::Buffer(&buffer);
    let refused = |bindings: &[(&str, Binding)]| {
        let text = pipeline.bind(&gpu, 0, bindings).expect_err("must be refused").to_string();
        assert!(text.contains("test.wgsl"), "{text}");
        text
    };
    assert!(refused(&[("input", whole)]).contains("`output` is not bound"));
    assert!(refused(&[("input", whole), ("output", whole), ("extra", whole)]).contains("no `extra`"));
    assert!(refused(&[("input", whole), ("output", Binding::Sampler(&sampler))]).contains("`output`"));
    assert!(refused(&[("input", whole), ("output", Binding::BufferRange(&buffer, 0, 64))]).contains("has 16"));
    // Only the device sees that this buffer lacks the usage.
    assert!(refused(&[("input", whole), ("output", Binding::Buffer(&uniform))]).contains("1 is `output`"));
    assert_eq!(gpu.take_errors(), Vec::<String>::new());
}

#[test]
fn what_the_shader_declares_but_does_not_use_may_be_bound() {
    let (_dir, gpu) = open();
    let pipeline = gpu.pipelines.compute(&gpu, &ComputeKey::new("test.wgsl", "main")).expect("pipeline");
    let input = gpu.storage("input", &[0_u32; 4], wgpu::BufferUsages::empty());
    let output = gpu.storage("output", &[0_u32; 4], wgpu::BufferUsages::empty());
    let bindings =
        [("input", Binding::Buffer(&input)), ("spare", Binding::Buffer(&input)), ("output", Binding::Buffer(&output))];
    pipeline.bind(&gpu, 0, &bindings).expect("bind");
    assert!(!pipeline.declares(0, "spare"));
}

#[test]
fn a_missing_entry_point_or_file_is_an_error_that_stays_listed() {
    let (_dir, gpu) = open();
    let error = gpu.pipelines.compute(&gpu, &ComputeKey::new("test.wgsl", "start")).expect_err("no entry");
    assert!(error.to_string().contains("`start`") && error.to_string().contains("main"), "{error}");
    assert_eq!(gpu.shaders.errors(), [error]);
    let error = gpu.pipelines.compute(&gpu, &ComputeKey::new("none.wgsl", "main")).expect_err("no file");
    assert!(error.to_string().contains("none.wgsl"), "{error}");
    assert_eq!(gpu.shaders.errors().len(), 2);
}

#[test]
fn defines_choose_the_code() {
    let (dir, _) = open();
    let shader = "@group(0) @binding(0) var<storage, read_write> output: array<u32>;\n\
        @compute @workgroup_size(#{WIDTH}) fn main() {\n#ifdef DOUBLE\n    output[0] = 2u;\n#else\n    output[0] = 1u;\n#endif\n}\n";
    write(dir.path(), "defs.wgsl", shader);
    let gpu = super::open_dir(dir.path());
    let key = ComputeKey::new("defs.wgsl", "main").def("WIDTH", ShaderDef::Uint(8));
    let pipeline = gpu.pipelines.compute(&gpu, &key).expect("pipeline");
    assert_eq!(pipeline.workgroup_size(), [8, 1, 1]);
    let other = gpu.pipelines.compute(&gpu, &key.def("DOUBLE", ShaderDef::Flag(true))).expect("pipeline");
    assert!(!Arc::ptr_eq(&pipeline, &other));
}

#[test]
fn a_raster_pipeline_draws_with_bindings_of_both_stages_and_of_an_import() {
    let (dir, _) = open();
    write(
        dir.path(),
        "lib/shared.wgsl",
        "#define_import_path test::shared\n\n@group(1) @binding(0) var<uniform> tint: vec4f;\n",
    );
    let shader = "#import test::shared::tint\n\
        @group(0) @binding(0) var<uniform> depth: vec4f;\n\
        @vertex fn vertex(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {\n\
            return vec4f(vec2f(vec2u(i & 1u, i >> 1u)) * 4.0 - 1.0, depth.x, 1.0);\n}\n\
        @fragment fn fragment() -> @location(0) vec4f { return tint + depth; }\n";
    write(dir.path(), "raster.wgsl", shader);
    let gpu = super::open_dir(dir.path());
    let format = wgpu::TextureFormat::Rgba32Float;
    let key = RasterKey {
        shader: "raster.wgsl",
        vertex: "vertex",
        fragment: Some("fragment"),
        defs: Vec::new(),
        vertex_buffers: Vec::new(),
        primitive: Default::default(),
        depth: None,
        targets: vec![Some(format.into())],
    };
    let pipeline = gpu.pipelines.raster(&gpu, &key).expect("pipeline");
    let depth = gpu.uniform("depth", &glam::Vec4::new(0.5, 0.0, 0.0, 0.0));
    let tint = gpu.uniform("tint", &glam::Vec4::new(1.0, 2.0, 3.0, 4.0));
    let groups = [
        pipeline.bind(&gpu, 0, &[("depth", Binding::Buffer(&depth))]).expect("group 0"),
        pipeline.bind(&gpu, 1, &[("tint", Binding::Buffer(&tint))]).expect("group 1"),
    ];
    let texture = super::readback::texture(&gpu, 5, 3, format, wgpu::TextureUsages::RENDER_ATTACHMENT);
    let view = texture.create_view(&Default::default());
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations::default(),
            })],
            ..Default::default()
        });
        pass.set_pipeline(pipeline.raster().expect("a raster pipeline"));
        for (index, group) in (0..).zip(&groups) {
            pass.set_bind_group(index, group, &[]);
        }
        pass.draw(0..3, 0..1);
    }
    gpu.queue.submit([encoder.finish()]);
    let image = lightwell::gpu::read_texture_f32(&gpu, &texture).expect("read");
    assert_eq!(image.rgba, [[1.5, 2.0, 3.0, 4.0]; 15]);
    assert_eq!(gpu.take_errors(), Vec::<String>::new());
}
