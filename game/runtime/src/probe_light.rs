//! Light that a game asks for at its probes, on its way from the frames that are drawn.

use crate::session::RenderState;
use anyhow::Result;
use bevy_ecs::entity::Entity;
use lightwell::game::Game;
use lightwell::render::PendingProbes;
use std::collections::VecDeque;

/// Frames whose light may be on its way to the probes at once; the probes of those beyond are not looked up.
const MOST_PENDING: usize = 4;

/// Light on its way to the probes of a game.
#[derive(Default)]
pub struct ProbeLight {
    /// The probes of the last frame.
    probed: Vec<Entity>,
    pending: VecDeque<(Vec<Entity>, PendingProbes)>,
}

impl ProbeLight {
    /// Has the next frame look up the probes of a game.
    pub fn ask(&mut self, game: &Game, rendering: &mut RenderState) {
        self.probed = game.probe_entities();
        rendering.renderer.set_probes(game.probe_points(rendering.scene.origin));
    }

    /// Gives the game what frames before found, as far as it has arrived, and asks what the last frame found. Waits for
    /// nothing.
    ///
    /// # Errors
    /// If the device fails.
    pub fn take_late(&mut self, game: &mut Game, rendering: &RenderState) -> Result<()> {
        let gpu = &rendering.gpu;
        while let Some((entities, light)) = self.pending.front_mut() {
            let Some(light) = light.try_take(gpu) else { break };
            let entities = std::mem::take(entities);
            self.pending.pop_front();
            game.set_probe_light_of(&entities, &light?);
        }
        if !self.probed.is_empty() && self.pending.len() < MOST_PENDING {
            self.pending.push_back((self.probed.clone(), rendering.renderer.begin_probe_light(gpu)?));
        }
        Ok(())
    }
}
