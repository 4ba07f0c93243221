//! The graphics device, with or without a window.

use super::audit::Audit;
use super::pipeline_file::PipelineFile;
use super::reuse::{BindKey, ConstantsKey, Kept, ViewKey};
use super::shader_folder::default_shader_dir;
use super::{HostCounts, PipelineCache, ShaderLibrary};
use bytemuck::Pod;
use encase::ShaderType;
use encase::internal::WriteInto;
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// How to open the device.
#[derive(Clone, Debug, Default)]
pub struct GpuOptions {
    /// Part of the adapter's name, in any case; none: the fastest kind there is.
    pub adapter: Option<String>,
    /// Folder of the WGSL files; empty: [`default_shader_dir`], or else those that are built into the program.
    pub shader_dir: PathBuf,
}

/// How the hierarchies that rays go through lie on the device. Images are the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RayNodes {
    /// Lists of boxes, without a stack: little arithmetic at each of many steps.
    Lists,
    /// Nodes of eight children, in a buffer: few fetches, which rays wait for, with much arithmetic after each.
    Wide,
}

impl RayNodes {
    /// The value of the environment variable `LIGHTWELL_RAY_NODES`, or the default of the adapter.
    fn chosen(info: &wgpu::AdapterInfo, limits: &wgpu::Limits) -> Result<Self, GpuError> {
        match std::env::var_os("LIGHTWELL_RAY_NODES").filter(|wanted| !wanted.is_empty()) {
            Some(wanted) => Self::named(&wanted.to_string_lossy()),
            None => Ok(Self::suiting(info, limits)),
        }
    }

    fn named(wanted: &str) -> Result<Self, GpuError> {
        match wanted {
            "lists" => Ok(Self::Lists),
            "wide" => Ok(Self::Wide),
            _ => Err(GpuError::RayNodes { wanted: wanted.to_string() }),
        }
    }

    /// A processor takes 1.5 to 2.3 times as long through wide nodes. They take one more storage buffer of a shader, beside
    /// those that the passes themselves need.
    fn suiting(info: &wgpu::AdapterInfo, limits: &wgpu::Limits) -> Self {
        let has_room = limits.max_storage_buffers_per_shader_stage >= 16;
        if info.device_type != wgpu::DeviceType::Cpu && has_room { Self::Wide } else { Self::Lists }
    }
}

/// Why there is no device.
#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    /// No driver at all.
    #[error(
        "no graphics driver was found; install one (on Debian without a graphics card: \
         apt-get install mesa-vulkan-drivers libvulkan1)"
    )]
    NoAdapter,
    /// Drivers, but none for this window.
    #[error("no adapter can draw into this window; there are:\n{found}")]
    NoWindowAdapter {
        /// All adapters, a line each.
        found: String,
    },
    /// Drivers, but not the one asked for.
    #[error("no adapter's name contains `{wanted}`; there are:\n{found}")]
    NoSuchAdapter {
        /// The text asked for.
        wanted: String,
        /// All adapters, a line each.
        found: String,
    },
    /// The driver refused.
    #[error("adapter `{adapter}` gave no device: {reason}")]
    Device {
        /// The adapter's name.
        adapter: String,
        /// The driver's reason.
        reason: wgpu::RequestDeviceError,
    },
    /// The environment asks for a layout that there is not.
    #[error("LIGHTWELL_RAY_NODES is `{wanted}`: it can be `lists` or `wide`, or leave it out")]
    RayNodes {
        /// The text asked for.
        wanted: String,
    },
    /// The WGSL files cannot be read.
    #[error("cannot read shader folder {path}: {reason}")]
    ReadShaders {
        /// The folder.
        path: PathBuf,
        /// Why.
        reason: std::io::Error,
    },
}

/// Errors that the driver reports outside of any call.
#[derive(Default)]
struct Reported {
    errors: Vec<String>,
    lost: Option<String>,
}

/// The graphics device with what everything shares: shaders, pipelines, samplers.
pub struct Gpu {
    /// The logical device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// The adapter.
    pub adapter: wgpu::Adapter,
    /// Name and kind of the adapter.
    pub info: wgpu::AdapterInfo,
    /// Limits in force.
    pub limits: wgpu::Limits,
    /// Features in use.
    pub features: wgpu::Features,
    /// Whether passes hand over many draws in one call, from a buffer. The image is the same without.
    pub draws_indirectly: bool,
    /// Whether dispatches may take their number of workgroups from a buffer.
    pub dispatches_indirectly: bool,
    /// How rays go through a scene.
    pub ray_nodes: RayNodes,
    /// WGSL sources and their errors.
    pub shaders: ShaderLibrary,
    /// Pipelines by what they are made of.
    pub pipelines: PipelineCache,
    pub(super) pipeline_file: OnceLock<PipelineFile>,
    pub(super) counts: Mutex<HostCounts>,
    pub(super) uniforms: Mutex<Kept<ConstantsKey, wgpu::Buffer>>,
    pub(super) constants: Mutex<Kept<ConstantsKey, wgpu::Buffer>>,
    pub(super) stand_ins: Mutex<HashMap<(&'static str, u32), wgpu::TextureView>>,
    pub(super) views: Mutex<Kept<ViewKey, wgpu::TextureView>>,
    pub(super) bind_groups: Mutex<Kept<BindKey, wgpu::BindGroup>>,
    samplers: Mutex<HashMap<String, wgpu::Sampler>>,
    #[doc(hidden)]
    pub audit: Audit,
    reported: Arc<Mutex<Reported>>,
}

/// Features that are used where they exist; everything works without them.
const WELCOME_FEATURES: wgpu::Features = wgpu::Features::TIMESTAMP_QUERY
    .union(wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS)
    .union(wgpu::Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES)
    .union(wgpu::Features::FLOAT32_FILTERABLE)
    .union(wgpu::Features::FLOAT32_BLENDABLE)
    .union(wgpu::Features::RG11B10UFLOAT_RENDERABLE)
    .union(wgpu::Features::DEPTH_CLIP_CONTROL)
    .union(wgpu::Features::SHADER_F16)
    .union(wgpu::Features::CLEAR_TEXTURE)
    .union(wgpu::Features::SUBGROUP)
    .union(wgpu::Features::INDIRECT_FIRST_INSTANCE)
    .union(wgpu::Features::PIPELINE_CACHE);

impl Gpu {
    /// Whether the processor draws, by a software driver.
    pub fn is_software(&self) -> bool {
        self.info.device_type == wgpu::DeviceType::Cpu
    }

    /// Opens a device without a window.
    ///
    /// # Errors
    /// No adapter, none of that name, no device, or shaders that cannot be read.
    pub fn headless(options: &GpuOptions) -> Result<Self, GpuError> {
        let instance = wgpu::Instance::new(instance_descriptor(wgpu::InstanceDescriptor::new_without_display_handle()));
        Self::open(options, &instance, None)
    }

    /// Opens a device that does nothing: frames are recorded and submitted, and no shader runs. It tells what frames cost
    /// the host, on any machine, with the limits and features of a common graphics card. What is read back is memory that
    /// was never written by a shader: zeros, or what was uploaded.
    ///
    /// # Errors
    /// Shaders that cannot be read.
    pub fn noop(options: &GpuOptions) -> Result<Self, GpuError> {
        let noop = wgpu::NoopBackendOptions {
            limits: Some(noop_limits()),
            // Without it, formats can do what every device's can: this backend's own table is empty.
            features: Some(WELCOME_FEATURES - wgpu::Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES),
            ..wgpu::NoopBackendOptions::enabled()
        };
        let descriptor = wgpu::InstanceDescriptor {
            backends: wgpu::Backends::NOOP,
            backend_options: wgpu::BackendOptions { noop, ..Default::default() },
            ..wgpu::InstanceDescriptor::new_without_display_handle()
        };
        let instance = wgpu::Instance::new(instance_descriptor(descriptor));
        let mut gpu = Self::open(&GpuOptions { adapter: None, ..options.clone() }, &instance, None)?;
        // The backend calls itself software, whose work is cut into small pieces.
        gpu.info.device_type = wgpu::DeviceType::DiscreteGpu;
        gpu.ray_nodes = RayNodes::chosen(&gpu.info, &gpu.limits)?;
        Ok(gpu)
    }

    /// Opens a device that can present on the surface.
    ///
    /// # Errors
    /// Those of [`Gpu::headless`].
    pub fn for_window(
        options: &GpuOptions,
        instance: &wgpu::Instance,
        surface: &wgpu::Surface,
    ) -> Result<Self, GpuError> {
        Self::open(options, instance, Some(surface))
    }

    fn open(
        options: &GpuOptions,
        instance: &wgpu::Instance,
        surface: Option<&wgpu::Surface>,
    ) -> Result<Self, GpuError> {
        let given = Some(&options.shader_dir).filter(|dir| !dir.as_os_str().is_empty()).cloned();
        let shaders = match given.or_else(default_shader_dir) {
            Some(path) => {
                ShaderLibrary::open(&path).map_err(|reason| GpuError::ReadShaders { path: path.clone(), reason })?
            }
            None => ShaderLibrary::built_in(),
        };
        let adapter = choose_adapter(options, instance, surface)?;
        let info = adapter.get_info();
        let features = adapter.features() & WELCOME_FEATURES;
        let limits = adapter.limits();
        let ray_nodes = RayNodes::chosen(&info, &limits)?;
        let dispatches_indirectly =
            adapter.get_downlevel_capabilities().flags.contains(wgpu::DownlevelFlags::INDIRECT_EXECUTION);
        let draws_indirectly = dispatches_indirectly && features.contains(wgpu::Features::INDIRECT_FIRST_INSTANCE);
        let request = adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("lightwell"),
            required_features: features,
            required_limits: limits.clone(),
            ..Default::default()
        });
        let (device, queue) =
            pollster::block_on(request).map_err(|reason| GpuError::Device { adapter: info.name.clone(), reason })?;
        let reported = Arc::new(Mutex::new(Reported::default()));
        listen(&device, &reported);
        Ok(Self {
            device,
            queue,
            adapter,
            info,
            limits,
            features,
            draws_indirectly,
            dispatches_indirectly,
            ray_nodes,
            shaders,
            pipelines: PipelineCache::default(),
            pipeline_file: OnceLock::new(),
            counts: Mutex::default(),
            uniforms: Mutex::default(),
            constants: Mutex::default(),
            stand_ins: Mutex::default(),
            views: Mutex::default(),
            bind_groups: Mutex::default(),
            samplers: Mutex::default(),
            audit: Audit::default(),
            reported,
        })
    }

    /// Why the device was lost, if it was.
    pub fn device_lost(&self) -> Option<String> {
        self.reported.lock().unwrap_or_else(PoisonError::into_inner).lost.clone()
    }

    /// Errors that the driver reported since the last call.
    pub fn take_errors(&self) -> Vec<String> {
        std::mem::take(&mut self.reported.lock().unwrap_or_else(PoisonError::into_inner).errors)
    }

    /// Makes something of the device; what the device refuses comes back as its message.
    pub(super) fn checked<T>(&self, make: impl FnOnce() -> T) -> Result<T, String> {
        let scope = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let made = make();
        match pollster::block_on(scope.pop()) {
            None => Ok(made),
            Some(error) => Err(error.to_string()),
        }
    }

    /// A uniform buffer with the value in WGSL's layout: the same one as long as frames ask for the same value. It is not
    /// to be written to.
    pub fn uniform<T: ShaderType + WriteInto>(&self, label: &str, value: &T) -> wgpu::Buffer {
        self.kept(label, uniform_bytes(label, value), wgpu::BufferUsages::UNIFORM)
    }

    /// A storage buffer with the values, and at least 16 bytes long.
    pub fn storage<T: Pod>(&self, label: &str, values: &[T], more: wgpu::BufferUsages) -> wgpu::Buffer {
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | more;
        self.audit.note(label, &bytemuck::cast_slice::<T, u8>(values));
        self.filled_buffer(label, bytemuck::cast_slice(values), usage)
    }

    /// A storage buffer with values that shaders only read: the same one as long as frames ask for the same values.
    pub fn constants<T: Pod>(&self, label: &str, values: &[T]) -> wgpu::Buffer {
        self.kept(label, bytemuck::cast_slice(values).to_vec(), wgpu::BufferUsages::STORAGE)
    }

    /// Like [`Gpu::constants`], for structs in the layout of WGSL.
    pub fn constants_of<T>(&self, label: &str, values: &[T]) -> wgpu::Buffer
    where
        for<'a> &'a [T]: ShaderType + WriteInto,
    {
        self.kept(label, constants_bytes(label, values), wgpu::BufferUsages::STORAGE)
    }

    pub(super) fn filled_buffer(&self, label: &str, bytes: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
        let buffer = self.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: (bytes.len() as u64).next_multiple_of(16).max(16),
            usage: usage | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        if bytes.len().is_multiple_of(4) {
            self.write_buffer(&buffer, 0, bytes);
        } else {
            let mut padded = bytes.to_vec();
            padded.resize(bytes.len().next_multiple_of(4), 0);
            self.write_buffer(&buffer, 0, &padded);
        }
        buffer
    }

    /// The sampler of that description, made once.
    pub fn sampler(&self, descriptor: &wgpu::SamplerDescriptor) -> wgpu::Sampler {
        let key = format!("{:?}", wgpu::SamplerDescriptor { label: None, ..descriptor.clone() });
        let mut samplers = self.samplers.lock().unwrap_or_else(PoisonError::into_inner);
        samplers.entry(key).or_insert_with(|| self.device.create_sampler(descriptor)).clone()
    }
}

/// A value in the layout that WGSL has for uniforms.
#[doc(hidden)]
pub fn uniform_bytes<T: ShaderType + WriteInto>(label: &str, value: &T) -> Vec<u8> {
    let mut bytes = encase::UniformBuffer::new(Vec::new());
    if let Err(error) = bytes.write(value) {
        // A vector grows as needed, so that there is nothing to fail; a message is all that is left to do.
        log::error!("uniform buffer `{label}`: {error}");
    }
    bytes.into_inner()
}

/// Structs in the layout that WGSL has for storage buffers.
#[doc(hidden)]
pub fn constants_bytes<T>(label: &str, values: &[T]) -> Vec<u8>
where
    for<'a> &'a [T]: ShaderType + WriteInto,
{
    let mut bytes = encase::StorageBuffer::new(Vec::new());
    if let Err(error) = bytes.write(&values) {
        log::error!("storage buffer `{label}`: {error}");
    }
    bytes.into_inner()
}

/// The limits of the device that does nothing: what common graphics cards have beyond the least.
fn noop_limits() -> wgpu::Limits {
    wgpu::Limits {
        max_buffer_size: 1 << 31,
        max_storage_buffer_binding_size: 1 << 31,
        max_storage_buffers_per_shader_stage: 16,
        max_storage_textures_per_shader_stage: 8,
        max_compute_invocations_per_workgroup: 1024,
        max_compute_workgroup_storage_size: 32 << 10,
        max_color_attachment_bytes_per_sample: 128,
        max_texture_dimension_2d: 16384,
        ..wgpu::Limits::default()
    }
}

/// Removes the checks of indirect draws from a descriptor: they cost more than the draws themselves, and only this crate
/// writes the buffers, for meshes and instances that exist.
pub fn instance_descriptor(descriptor: wgpu::InstanceDescriptor) -> wgpu::InstanceDescriptor {
    let flags = descriptor.flags - wgpu::InstanceFlags::VALIDATION_INDIRECT_CALL;
    wgpu::InstanceDescriptor { flags, ..descriptor }
}

fn listen(device: &wgpu::Device, reported: &Arc<Mutex<Reported>>) {
    let sink = Arc::clone(reported);
    device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
        log::error!("graphics device: {error}");
        sink.lock().unwrap_or_else(PoisonError::into_inner).errors.push(error.to_string());
    }));
    let sink = Arc::clone(reported);
    device.set_device_lost_callback(move |reason, message| {
        // Whoever destroys it knows.
        if reason != wgpu::DeviceLostReason::Destroyed {
            log::error!("graphics device lost: {message}");
        }
        sink.lock().unwrap_or_else(PoisonError::into_inner).lost = Some(message);
    });
}

fn choose_adapter(
    options: &GpuOptions,
    instance: &wgpu::Instance,
    surface: Option<&wgpu::Surface>,
) -> Result<wgpu::Adapter, GpuError> {
    // The last is there only where an instance was made for it alone.
    let backends = wgpu::Backends::VULKAN | wgpu::Backends::METAL | wgpu::Backends::DX12 | wgpu::Backends::NOOP;
    let mut adapters = pollster::block_on(instance.enumerate_adapters(backends));
    if adapters.is_empty() {
        return Err(GpuError::NoAdapter);
    }
    let describe = |a: &wgpu::Adapter| {
        let info = a.get_info();
        format!("  {} ({:?}, {:?})", info.name, info.device_type, info.backend)
    };
    let found = adapters.iter().map(describe).collect::<Vec<_>>().join("\n");
    adapters.retain(|adapter| surface.is_none_or(|surface| adapter.is_surface_supported(surface)));
    if adapters.is_empty() {
        return Err(GpuError::NoWindowAdapter { found });
    }
    let wanted = options.adapter.clone().unwrap_or_default();
    adapters
        .into_iter()
        .filter(|adapter| adapter.get_info().name.to_lowercase().contains(&wanted.to_lowercase()))
        .min_by_key(|adapter| match adapter.get_info().device_type {
            wgpu::DeviceType::DiscreteGpu => 0,
            wgpu::DeviceType::IntegratedGpu => 1,
            wgpu::DeviceType::VirtualGpu => 2,
            wgpu::DeviceType::Cpu => 3,
            wgpu::DeviceType::Other => 4,
        })
        .ok_or(GpuError::NoSuchAdapter { wanted, found })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ray_nodes_are_those_that_suit_the_adapter_or_are_asked_for() {
        let gpu = Gpu::noop(&GpuOptions::default()).expect("a device");
        let (card, plenty) = (&gpu.info, noop_limits());
        let software = wgpu::AdapterInfo { device_type: wgpu::DeviceType::Cpu, ..card.clone() };
        let few = wgpu::Limits { max_storage_buffers_per_shader_stage: 8, ..plenty.clone() };
        assert_eq!(RayNodes::suiting(card, &plenty), RayNodes::Wide);
        assert_eq!(RayNodes::suiting(&software, &plenty), RayNodes::Lists);
        assert_eq!(RayNodes::suiting(card, &few), RayNodes::Lists);
        assert_eq!(RayNodes::named("lists").ok(), Some(RayNodes::Lists));
        assert_eq!(RayNodes::named("wide").ok(), Some(RayNodes::Wide));
        let error = RayNodes::named("tree").expect_err("there is no such layout").to_string();
        assert!(error.contains("tree") && error.contains("`lists` or `wide`"), "{error}");
    }
}
