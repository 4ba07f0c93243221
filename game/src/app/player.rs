//! A game with what draws it: the same with and without a window.

use super::CustomPassAdder;
use super::hud::Hud;
use anyhow::{Result, bail};
use egui::{FullOutput, RawInput};
use lightwell::game::{Game, GameError, InputEvent};
use lightwell::gpu::Gpu;
use lightwell::graph::FrameReport;
use lightwell::render::{RenderSettings, UpdateRate};
use lightwell::scene::SceneView;
use lightwell_runtime::cli::LookArgs;
use lightwell_runtime::probe_light::ProbeLight;
use lightwell_runtime::session::RenderState;
use std::sync::Arc;

/// A game with what draws it.
pub struct Drawn {
    pub game: Game,
    pub rendering: RenderState,
    light: ProbeLight,
}

impl Drawn {
    /// A game that was started.
    pub fn new(game: Game, gpu: Arc<Gpu>, look: LookArgs, passes: &[CustomPassAdder]) -> Self {
        let mut drawn = Self { game, rendering: RenderState::new(gpu, look), light: ProbeLight::default() };
        passes.iter().for_each(|add| add(&mut drawn.rendering));
        drawn.follow();
        drawn
    }

    /// Takes over what changed in the world.
    pub fn follow(&mut self) {
        self.rendering.follow(&mut self.game.world);
    }

    /// One step.
    ///
    /// # Errors
    /// If a system fails.
    pub fn step(&mut self, events: &[InputEvent]) -> Result<(), GameError> {
        let result = self.game.step(events);
        // After every step: what was removed in one is told by the world for two of them.
        self.follow();
        result
    }

    /// Runs the systems of a frame, and returns what they drew over the image.
    pub fn frame(&mut self, delta: f32, input: Option<RawInput>) -> (Result<(), GameError>, FullOutput) {
        let rendering = &mut self.rendering;
        Hud::pass(&mut self.game, input, |game| {
            let result = game.frame(delta);
            rendering.follow(&mut game.world);
            if let Ok(camera) = rendering.camera() {
                Hud::show_drawn_texts(game, camera);
            }
            result
        })
    }

    /// Draws the image. Light probes of the frame before get their light first.
    ///
    /// # Errors
    /// If there is no camera, a pass fails, or the device is lost.
    pub fn render(&mut self, size: [u32; 2], update: UpdateRate) -> Result<FrameReport> {
        let limit = self.rendering.gpu.limits.max_texture_dimension_2d;
        let view =
            SceneView { camera: self.rendering.camera()?, size: size.map(|e| e.clamp(1, limit)), jitter: [0.0; 2] };
        self.light.ask(&self.game, &mut self.rendering);
        let shown = self.rendering.display_settings(&self.game.world);
        let settings = RenderSettings { update: update.max(shown.update), ..shown };
        let report = self.rendering.render(&view, &settings)?;
        if let Some(reason) = self.rendering.gpu.device_lost() {
            bail!("the graphics device was lost: {reason}");
        }
        Ok(report)
    }

    /// Gives the game what frames before found out about light, as far as it has arrived, and asks what the last frame
    /// found. Waits for nothing.
    ///
    /// # Errors
    /// If the device fails.
    pub fn take_late_light(&mut self) -> Result<()> {
        self.light.take_late(&mut self.game, &self.rendering)
    }

    /// Gives the game what the last frame found out about light, and waits for that.
    ///
    /// # Errors
    /// If the device fails.
    pub fn take_light(&mut self) -> Result<()> {
        let light = self.rendering.renderer.probe_light(&self.rendering.gpu)?;
        self.game.set_probe_light(&light);
        Ok(())
    }
}
