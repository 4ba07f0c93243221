//! Takes up the pipelines that an earlier run has kept.

use super::context::Gpu;
use super::pipeline_file::{PipelineFile, unwrapped};
use std::path::Path;
use std::sync::atomic::AtomicBool;

impl Gpu {
    /// Keeps what the driver makes of shaders in a file of that folder, and takes up what is there; to be called before
    /// the first pipeline is made. The file is written when the device is let go. One that is broken, of another device
    /// or of another driver is passed over. Drivers that cannot do it keep nothing.
    pub fn keep_pipelines(&self, folder: &Path) {
        let name = wgpu::util::pipeline_cache_key(&self.info);
        let (Some(name), true) = (name, self.features.contains(wgpu::Features::PIPELINE_CACHE)) else { return };
        let path = folder.join(name);
        let data = std::fs::read(&path).ok();
        let data = data.as_deref().and_then(unwrapped);
        let descriptor = wgpu::PipelineCacheDescriptor { label: Some("pipelines"), data, fallback: true };
        // SAFETY: the data came from `PipelineCache::get_data`, as its checksum says; wgpu compares device and driver, and
        // `fallback` has it begin with an empty cache where they differ.
        #[allow(unsafe_code)]
        let made = self.checked(|| unsafe { self.device.create_pipeline_cache(&descriptor) });
        match made {
            Ok(cache) => drop(self.pipeline_file.set(PipelineFile { cache, path, has_grown: AtomicBool::new(false) })),
            Err(error) => log::warn!("cannot keep pipelines: {error}"),
        }
    }
}
