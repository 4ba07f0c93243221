//! `lightwell info`: the graphics adapter.

use anyhow::Result;
use lightwell_runtime::cli::Common;
use lightwell_runtime::say;
use lightwell_runtime::session::open_gpu;

/// Prints the adapter in use with what matters of its features and limits, and the other adapters.
///
/// # Errors
/// If there is no adapter.
pub fn run(common: &Common) -> Result<()> {
    let gpu = open_gpu(common)?;
    let info = &gpu.info;
    let line = |name: &str, value: String| say!("{name:<24}{value}");
    line("lightwell", env!("CARGO_PKG_VERSION").to_owned());
    line("adapter", info.name.clone());
    line("kind", format!("{:?} through {:?}", info.device_type, info.backend));
    line("driver", format!("{} {}", info.driver, info.driver_info).trim().to_owned());
    line("shaders", gpu.shaders.dir().map_or("built in".to_owned(), |dir| dir.display().to_string()));
    say!("\nfeatures");
    for (feature, name) in [
        (wgpu::Features::TIMESTAMP_QUERY, "times of passes"),
        (wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS, "times inside encoders"),
        (wgpu::Features::FLOAT32_FILTERABLE, "float32 filtering"),
        (wgpu::Features::SHADER_F16, "16-bit floats"),
        (wgpu::Features::SUBGROUP, "subgroups"),
    ] {
        let state = match (gpu.features.contains(feature), gpu.adapter.features().contains(feature)) {
            (true, _) => "in use",
            (false, true) => "there, not needed",
            (false, false) => "not there",
        };
        line(&format!("  {name}"), state.to_owned());
    }
    say!("\nlimits");
    let limits = &gpu.limits;
    line("  texture 2D", format!("{} pixels", limits.max_texture_dimension_2d));
    line("  texture 3D", format!("{} texels", limits.max_texture_dimension_3d));
    line("  texture layers", limits.max_texture_array_layers.to_string());
    line("  storage binding", format!("{} MiB", limits.max_storage_buffer_binding_size / (1 << 20)));
    line("  buffer", format!("{} MiB", limits.max_buffer_size / (1 << 20)));
    line("  workgroup", format!("{} threads", limits.max_compute_invocations_per_workgroup));
    line("  workgroup memory", format!("{} KiB", limits.max_compute_workgroup_storage_size / 1024));
    say!("\nadapters (choose with --adapter NAME)");
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    for adapter in pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY)) {
        let other = adapter.get_info();
        say!("  {} ({:?}, {:?})", other.name, other.device_type, other.backend);
    }
    Ok(())
}
