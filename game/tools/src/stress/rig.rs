//! Draws setups, each once.

use super::setup::Setup;
use crate::capture;
use anyhow::{Context, Result};
use lightwell::gpu::Gpu;
use lightwell::measure::Image;
use lightwell::render::RenderSettings;
use lightwell::world::Light;
use lightwell_runtime::cli::{Common, LookArgs};
use lightwell_runtime::session::{Session, open_gpu};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Image size [pixels].
const SIZE: [u32; 2] = [64, 64];

/// A device and what was drawn on it.
pub struct Rig {
    gpu: Arc<Gpu>,
    common: Common,
    scene: PathBuf,
    images: HashMap<String, Arc<Image>>,
    /// Images that were drawn.
    pub drawn: usize,
    /// Pixels that were not finite since they were last asked for.
    not_finite: usize,
}

impl Rig {
    /// Opens the device; scenes are written into the folder.
    ///
    /// # Errors
    /// If there is no device or the folder cannot be made.
    pub fn new(folder: &Path, common: &Common) -> Result<Self> {
        std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
        for (name, text) in super::degenerate::PREFABS {
            std::fs::write(folder.join(name), text).with_context(|| format!("cannot write {name}"))?;
        }
        let gpu = Arc::new(open_gpu(common)?);
        let scene = folder.join("running.scene.ron");
        Ok(Self { gpu, common: common.clone(), scene, images: HashMap::new(), drawn: 0, not_finite: 0 })
    }

    /// A session with a scene of this text.
    ///
    /// # Errors
    /// If the scene cannot be loaded.
    pub fn open(&self, text: &str, look: &LookArgs) -> Result<Session> {
        std::fs::write(&self.scene, text).with_context(|| format!("cannot write {}", self.scene.display()))?;
        Session::open(self.gpu.clone(), &self.scene.to_string_lossy(), look, &self.common)
    }

    /// Draws what stands in a session.
    ///
    /// # Errors
    /// If it cannot be drawn.
    pub fn draw(&mut self, session: &mut Session, no_cache: bool) -> Result<Image> {
        let settings = RenderSettings { no_cache, ..session.render_settings(false) };
        let image = capture::take(session, SIZE, 1, &settings)?;
        self.drawn += 1;
        self.not_finite += image.values().filter(|value| !value.is_finite()).count();
        Ok(image)
    }

    /// The image of a setup; it is kept.
    ///
    /// # Errors
    /// If it cannot be drawn.
    pub fn image(&mut self, setup: &Setup) -> Result<Arc<Image>> {
        let text = setup.text();
        let key = format!("{}\n{text}", setup.method.name());
        if let Some(image) = self.images.get(&key) {
            return Ok(image.clone());
        }
        let mut session = self.open(&text, &setup.method.look(setup.grid, setup.seed))?;
        let image = Arc::new(self.draw(&mut session, false)?);
        self.images.insert(key, image.clone());
        Ok(image)
    }

    /// Number of values that were not finite in all images since the last call.
    pub fn take_not_finite(&mut self) -> usize {
        std::mem::take(&mut self.not_finite)
    }

    /// The device.
    pub fn gpu(&self) -> Arc<Gpu> {
        self.gpu.clone()
    }

    /// Forgets kept images.
    pub fn forget(&mut self) {
        self.images.clear();
    }
}

impl Drop for Rig {
    fn drop(&mut self) {
        // Only of use while it runs.
        let _ = std::fs::remove_file(&self.scene);
        for (name, _) in super::degenerate::PREFABS {
            let _ = std::fs::remove_file(self.scene.with_file_name(name));
        }
    }
}

/// Multiplies the intensity of all lights of a running scene; gives what they were.
pub fn dim(session: &mut Session, factor: f32) -> Vec<f32> {
    let world = &mut session.parts().world.ecs;
    let mut lights = world.query::<&mut Light>();
    let before = lights.iter(world).map(|light| light.intensity).collect();
    lights.iter_mut(world).for_each(|mut light| light.intensity *= factor);
    session.set_seconds(0.0);
    before
}

/// Gives all lights of a running scene the intensities that [`dim`] found.
pub fn relight(session: &mut Session, intensities: &[f32]) {
    let world = &mut session.parts().world.ecs;
    let mut lights = world.query::<&mut Light>();
    lights.iter_mut(world).zip(intensities).for_each(|(mut light, intensity)| light.intensity = *intensity);
    session.set_seconds(0.0);
}
