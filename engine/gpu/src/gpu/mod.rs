//! The device: adapter and queue, shaders with imports and hot reload, pipelines, timestamps, readback.

mod audit;
mod binding;
mod changing;
mod compose;
mod context;
mod counters;
mod inlined;
mod keep_pipelines;
mod kept;
mod pipeline;
mod pipeline_cache;
mod pipeline_file;
mod readback;
mod reflect;
mod requests;
mod reuse;
mod shader_defs;
mod shader_error;
mod shader_folder;
mod shader_library;
mod timestamps;
mod watch;

#[doc(hidden)]
pub use audit::Note;
#[doc(hidden)]
pub use changing::{Changing, changed};
pub use context::{Gpu, GpuError, GpuOptions, RayNodes, instance_descriptor};
#[doc(hidden)]
pub use context::{constants_bytes, uniform_bytes};
pub use counters::HostCounts;
pub use pipeline::{BindError, Binding, ComputeKey, Pipeline, PipelineCache, RasterKey};
pub use readback::{ImageF32, PendingBuffer, PendingTexture, ReadbackError, begin_read_buffer};
pub use readback::{begin_read_texture, floats_of};
pub use readback::{read_buffer, read_layer_f32, read_texture, read_texture_f32};
pub use reflect::{BindingInfo, EntryPoint, StructLayout};
pub use shader_defs::ShaderDef;
pub use shader_error::ShaderError;
pub use shader_folder::default_shader_dir;
pub use shader_library::{ShaderEvent, ShaderLibrary};
pub use timestamps::TimestampQueries;
