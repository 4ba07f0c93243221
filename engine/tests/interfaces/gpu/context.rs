use super::{open, write};
use lightwell::gpu::{Binding, ComputeKey, Gpu, GpuError, GpuOptions};

#[test]
fn an_unknown_adapter_is_an_error_that_lists_the_known_ones() {
    let dir = tempfile::tempdir().expect("temporary folder");
    let options = GpuOptions { adapter: Some("Voodoo2".into()), shader_dir: dir.path().into() };
    let error = Gpu::headless(&options).err().expect("no such adapter");
    let (_dir, gpu) = open();
    assert!(matches!(error, GpuError::NoSuchAdapter { .. }), "{error}");
    let text = error.to_string();
    assert!(text.contains("Voodoo2") && text.contains(&gpu.info.name), "{text}");
}

#[test]
fn an_adapter_is_found_by_part_of_its_name_in_any_case() {
    let (dir, gpu) = open();
    let part = gpu.info.name.to_uppercase().chars().take(5).collect();
    let options = GpuOptions { adapter: Some(part), shader_dir: dir.path().into() };
    assert!(
        Gpu::headless(&options).expect("adapter").info.name.to_lowercase().contains(&gpu.info.name[..5].to_lowercase())
    );
}

#[test]
fn a_missing_shader_folder_is_an_error_with_its_path() {
    let options = GpuOptions { adapter: None, shader_dir: "no/such/folder".into() };
    let text = Gpu::headless(&options).err().expect("no folder").to_string();
    assert!(text.contains("no/such/folder"), "{text}");
}

#[test]
fn what_the_device_refuses_is_kept_and_no_panic() {
    let (_dir, gpu) = open();
    let size = gpu.limits.max_buffer_size.saturating_add(4);
    let _refused = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("far too large"),
        size,
        usage: wgpu::BufferUsages::UNIFORM,
        mapped_at_creation: false,
    });
    let errors = gpu.take_errors();
    assert!(errors.len() == 1 && errors[0].contains("far too large"), "{errors:?}");
    assert!(gpu.take_errors().is_empty());
}

#[test]
fn timers_nest_and_are_positive() {
    let (_dir, gpu) = open();
    let buffer = gpu.storage("cleared", &vec![1_u32; 1 << 20], wgpu::BufferUsages::empty());
    let mut timers = gpu.timestamps();
    for _ in 0..2 {
        timers.reset();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        assert!(timers.begin(&mut encoder, "outer"));
        assert!(timers.begin(&mut encoder, "inner"));
        encoder.clear_buffer(&buffer, 0, None);
        timers.end(&mut encoder);
        timers.end(&mut encoder);
        timers.resolve(&mut encoder);
        gpu.queue.submit([encoder.finish()]);
    }
    let times = timers.read(&gpu);
    assert_eq!(gpu.take_errors(), Vec::<String>::new());
    let wanted = wgpu::Features::TIMESTAMP_QUERY | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS;
    match &times[..] {
        [(outer, Some(whole)), (inner, Some(part))] => {
            assert_eq!((outer.as_str(), inner.as_str()), ("outer", "inner"));
            assert!(*part > 0.0 && whole >= part && *whole < 60e3, "{times:?}");
        }
        _ => assert!(!gpu.features.contains(wanted) && times.len() == 2, "{times:?}"),
    }
}

fn clear(gpu: &Gpu, encoder: &mut wgpu::CommandEncoder) {
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("cleared"),
        size: wgpu::Extent3d { width: 64, height: 64, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    let view = texture.create_view(&Default::default());
    let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store };
    let attachment = wgpu::RenderPassColorAttachment { view: &view, depth_slice: None, resolve_target: None, ops };
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        color_attachments: &[Some(attachment)],
        ..Default::default()
    });
}

/// On lavapipe a timestamp waits for the next rasterisation unless it is flushed, and a dispatch right behind it was
/// timed as nothing.
#[test]
fn a_dispatch_takes_the_time_that_it_takes() {
    let (dir, _) = open();
    let shader = "@group(0) @binding(0) var<storage, read_write> o: array<u32>;\n@compute @workgroup_size(64)\n\
        fn main(@builtin(global_invocation_id) id: vec3u) {\n    var x = id.x;\n\
        for (var i = 0u; i < 4000u; i++) { x = x * 747796405u + 1u; }\n    o[id.x] = x;\n}\n";
    write(dir.path(), "busy.wgsl", shader);
    let gpu = super::open_dir(dir.path());
    let pipeline = gpu.pipelines.compute(&gpu, &ComputeKey::new("busy.wgsl", "main")).expect("a shader");
    let output = gpu.storage("output", &vec![0_u32; 1 << 18], wgpu::BufferUsages::empty());
    let group = pipeline.bind(&gpu, 0, &[("o", Binding::Buffer(&output))]).expect("bind");
    let mut timers = gpu.timestamps();
    let mut wall = 0.0;
    for _ in 0..2 {
        timers.reset();
        gpu.wait();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        clear(&gpu, &mut encoder);
        for name in ["first", "second"] {
            timers.begin(&mut encoder, name);
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(pipeline.compute().expect("a compute pipeline"));
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups(1 << 12, 1, 1);
            drop(pass);
            timers.end(&mut encoder);
        }
        timers.resolve(&mut encoder);
        let start = std::time::Instant::now();
        gpu.queue.submit([encoder.finish()]);
        gpu.wait();
        wall = start.elapsed().as_secs_f64() * 1e3;
    }
    let times: Vec<f64> = timers.read(&gpu).into_iter().filter_map(|(_, ms)| ms).collect();
    if let [first, second] = times[..] {
        // A fast device spends most of the time elsewhere: there both are alike, and that is all.
        let alike = first < 5.0 * second && second < 5.0 * first;
        assert!(alike && (first + second > 0.6 * wall || wall < 20.0), "{first} and {second} of {wall} ms");
    }
}

#[test]
fn samplers_of_the_same_kind_are_one() {
    let (_dir, gpu) = open();
    let linear = |label| wgpu::SamplerDescriptor { label, mag_filter: wgpu::FilterMode::Linear, ..Default::default() };
    let first = gpu.sampler(&linear(Some("a")));
    assert_eq!(first, gpu.sampler(&linear(Some("b"))));
    assert_ne!(first, gpu.sampler(&Default::default()));
}

#[test]
fn struct_sizes_follow_wgsl() {
    let (dir, _) = open();
    let shader = "struct Params { a: vec3f, b: f32, c: vec2f }\n@group(0) @binding(0) var<uniform> p: Params;\n\
        @group(0) @binding(1) var<storage, read_write> o: f32;\n@compute @workgroup_size(1) fn main() { o = p.b; }\n";
    write(dir.path(), "params.wgsl", shader);
    let gpu = super::open_dir(dir.path());
    let layout = gpu.shaders.struct_layout("params.wgsl", "Params").expect("layout");
    assert_eq!(layout.size, 32);
    assert_eq!(layout.members, [("a".to_string(), 0), ("b".into(), 12), ("c".into(), 16)]);
    assert!(gpu.shaders.struct_size("params.wgsl", "Other").is_err());
}
