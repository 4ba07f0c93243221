//! Path tracing of a session's scene.

use super::Session;
use anyhow::{Result, bail};
use lightwell::gpu::Gpu;
use lightwell::render::GiMethod;
use lightwell::render::reference::{Estimate, PathTracer, TraceSettings, content_key};
use lightwell::scene::SceneView;
use std::path::Path;

impl Session {
    /// Path-traces a view of the scene as it stands, with so many samples a pixel. If the same view was traced before,
    /// its samples count. `progress` is told of the samples that are done.
    ///
    /// # Errors
    /// If the scene cannot be traced or the device fails.
    pub fn trace(
        &mut self,
        view: &SceneView,
        settings: &TraceSettings,
        samples: u32,
        progress: &mut dyn FnMut(u32),
    ) -> Result<Estimate> {
        let mut tracer = self.begin_trace(view, settings)?.0;
        tracer.advance_to(samples, progress)?;
        tracer.estimate()
    }

    /// Takes up a view for the path tracer.
    ///
    /// # Errors
    /// If the scene does not fit the device.
    pub fn begin_trace(&mut self, view: &SceneView, settings: &TraceSettings) -> Result<(Tracing<'_>, u128)> {
        let scene = &self.rendering.scene;
        let key = content_key(scene, view, settings);
        let tracer = self.rendering.renderer.tracer_mut(&self.gpu);
        tracer.begin(&self.gpu, scene, view, settings)?;
        Ok((Tracing { gpu: &self.gpu, tracer }, key))
    }

    /// Whether more samples will make the path-traced image better.
    pub fn is_tracing(&self) -> bool {
        self.tracing().is_some_and(|(samples, target)| samples < target)
    }

    /// Whether frames go on tracing, as the picture or beside it.
    fn traces(&self) -> bool {
        self.rendering.look.only.is_light()
            && (self.rendering.look.gi == Some(GiMethod::REFERENCE) || self.beside.is_some())
    }

    /// Whether the reference is traced beside a drawn picture.
    pub fn compares(&self) -> bool {
        self.beside.is_some() && self.rendering.look.gi != Some(GiMethod::REFERENCE)
    }

    /// A key of all that a traced image of this view depends on, the same in every process.
    pub fn content_key(&self, view: &SceneView, settings: &TraceSettings) -> u128 {
        content_key(&self.rendering.scene, view, settings)
    }

    /// Samples a pixel of the path-traced image that is on its way, so far and when it is finished.
    pub fn tracing(&self) -> Option<(u32, u32)> {
        let tracer = self.rendering.renderer.tracer().filter(|_| self.traces())?;
        Some((tracer.samples(), self.rendering.look.trace.spp))
    }
}

/// An image that is being traced.
pub struct Tracing<'a> {
    gpu: &'a Gpu,
    /// The tracer.
    pub tracer: &'a mut PathTracer,
}

impl Tracing<'_> {
    /// Goes on until there are so many samples a pixel; tells of those that are done.
    ///
    /// # Errors
    /// If the device fails.
    pub fn advance_to(&mut self, samples: u32, progress: &mut dyn FnMut(u32)) -> Result<()> {
        // Pieces small enough for a bar to move; the result does not depend on them.
        const PIECE: u32 = 16;
        while self.tracer.samples() < samples {
            self.tracer.advance(self.gpu, (samples - self.tracer.samples()).min(PIECE))?;
            if let Some(lost) = self.gpu.device_lost() {
                bail!("the graphics device was lost: {lost}");
            }
            progress(self.tracer.samples());
        }
        Ok(())
    }

    /// Takes up what [`Tracing::save`] wrote, if there is such a file.
    ///
    /// # Errors
    /// If the file is of another image or cannot be read.
    pub fn resume(&mut self, path: &Path, key: u128) -> Result<u32> {
        Ok(self.tracer.resume(self.gpu, path, key)?)
    }

    /// Keeps what is traced so far.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn save(&self, path: &Path, key: u128) -> Result<()> {
        Ok(self.tracer.save(self.gpu, path, key)?)
    }

    /// What was traced so far.
    ///
    /// # Errors
    /// If nothing was traced or the device fails.
    pub fn estimate(&self) -> Result<Estimate> {
        Ok(self.tracer.estimate(self.gpu)?)
    }
}
