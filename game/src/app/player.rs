//! A game with what draws it: the same with and without a window.

use super::OwnPass;
use super::hud::Hud;
use crate::cli::LookArgs;
use crate::session::Painter;
use anyhow::{Result, bail};
use egui::{FullOutput, RawInput};
use lightwell::game::{Game, GameError, InputEvent};
use lightwell::gpu::Gpu;
use lightwell::scene::SceneView;
use std::sync::Arc;

/// A game with what draws it.
pub struct Drawn {
    pub game: Game,
    pub painter: Painter,
}

impl Drawn {
    /// A game that was started.
    pub fn new(game: Game, gpu: Arc<Gpu>, look: LookArgs, passes: &[OwnPass]) -> Self {
        let mut drawn = Self { game, painter: Painter::new(gpu, look) };
        passes.iter().for_each(|add| add(&mut drawn.painter));
        drawn.follow();
        drawn
    }

    /// Takes over what changed in the world.
    pub fn follow(&mut self) {
        self.painter.follow(&mut self.game.world);
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

    /// Lets the systems of a frame run; gives what they drew over the picture.
    pub fn frame(&mut self, delta: f32, input: Option<RawInput>) -> (Result<(), GameError>, FullOutput) {
        let drawn = Hud::pass(&mut self.game, input, |game| game.frame(delta));
        self.follow();
        drawn
    }

    /// Draws the picture. What was asked about light in the frame before is answered first.
    ///
    /// # Errors
    /// If there is no camera, a pass fails, or the device is lost.
    pub fn render(&mut self, size: [u32; 2]) -> Result<()> {
        let limit = self.painter.gpu.limits.max_texture_dimension_2d;
        let view =
            SceneView { camera: self.painter.camera()?, size: size.map(|e| e.clamp(1, limit)), jitter: [0.0; 2] };
        self.painter.renderer.set_probes(self.game.probe_points(self.painter.scene.origin));
        let settings = self.painter.display_settings(&self.game.world);
        self.painter.render(&view, &settings)?;
        if let Some(reason) = self.painter.gpu.device_lost() {
            bail!("the graphics device was lost: {reason}");
        }
        Ok(())
    }

    /// Gives the game what the last frame found out about light.
    ///
    /// # Errors
    /// If the device fails.
    pub fn take_light(&mut self) -> Result<()> {
        let light = self.painter.renderer.probe_light(&self.painter.gpu)?;
        self.game.set_probe_light(&light);
        Ok(())
    }
}
