//! Lights of this frame and of the frame before: whether one of them changed by much.

use crate::scene::{LightShape, SceneId, SceneLight};
use glam::Vec3;

/// Share of its intensity that a light may change by within a frame.
const MOST_CHANGE: f32 = 0.05;
/// Share of the scene's extent that it may move by.
const MOST_MOVE: f32 = 0.05;
/// How far it may turn \[rad\].
const MOST_TURN: f32 = 0.1;

/// What of a light changes what it lights.
#[derive(Clone, Debug, PartialEq)]
struct State {
    id: SceneId,
    shape: LightShape,
    intensity: Vec3,
    position: Vec3,
    axes: [Vec3; 2],
    range: Option<f32>,
    is_used: bool,
}

impl State {
    fn of(light: &SceneLight) -> Self {
        Self {
            id: light.id,
            shape: light.shape,
            intensity: light.intensity,
            position: light.position,
            axes: [light.direction, light.axis],
            range: light.range,
            is_used: light.indirect && light.intensity != Vec3::ZERO,
        }
    }

    fn is_near(&self, other: &Self, extent: f32) -> bool {
        let change = (self.intensity - other.intensity).abs().max_element();
        let is_alike = change <= MOST_CHANGE * self.intensity.max_element().min(other.intensity.max_element());
        let has_turned = self.axes.iter().zip(&other.axes).any(|(a, b)| a.distance(*b) > MOST_TURN);
        (self.id, self.shape, self.range, self.is_used) == (other.id, other.shape, other.range, other.is_used)
            && is_alike
            && !has_turned
            && (self.shape.is_distant() || self.position.distance(other.position) <= MOST_MOVE * extent)
    }
}

/// Lights of two frames.
#[derive(Debug, Default)]
pub(super) struct LightSteps {
    frames: [Vec<State>; 2],
}

impl LightSteps {
    /// Takes note of a frame.
    pub fn update(&mut self, lights: &[SceneLight]) {
        self.frames.swap(0, 1);
        self.frames[0].clear();
        self.frames[0].extend(lights.iter().map(State::of));
    }

    /// Whether a light came, went, or changed by more than a few per cent, in a scene of that extent \[m\].
    pub fn have_jumped(&self, extent: f32) -> bool {
        let [now, before] = &self.frames;
        now.len() != before.len() || now.iter().zip(before).any(|(now, before)| !now.is_near(before, extent))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn light() -> SceneLight {
        SceneLight {
            id: SceneId(1),
            name: String::new(),
            shape: LightShape::Point,
            intensity: Vec3::splat(10.0),
            position: Vec3::Y,
            direction: Vec3::NEG_Y,
            axis: Vec3::X,
            range: None,
            casts_shadow: true,
            indirect: true,
            shadow_size: 64,
            rsm_size: 64,
            revision: 0,
        }
    }

    fn jumps(change: impl FnOnce(&mut SceneLight)) -> bool {
        let mut steps = LightSteps::default();
        let mut after = light();
        change(&mut after);
        steps.update(&[light()]);
        steps.update(&[after]);
        steps.have_jumped(10.0)
    }

    #[test]
    fn small_steps_are_no_jumps() {
        assert!(!jumps(|_| {}));
        assert!(!jumps(|light| light.intensity *= 1.04));
        assert!(!jumps(|light| light.position.x += 0.3));
        assert!(!jumps(|light| light.direction = Vec3::new(0.05, -1.0, 0.0).normalize()));
        assert!(jumps(|light| light.intensity = Vec3::ZERO), "it was switched off");
        assert!(jumps(|light| light.intensity = Vec3::new(10.0, 5.0, 10.0)), "another colour");
        assert!(jumps(|light| light.intensity *= f32::NAN), "no number");
        assert!(jumps(|light| light.position.x += 1.0));
        assert!(jumps(|light| light.direction = Vec3::X));
        assert!(jumps(|light| light.id = SceneId(2)), "another light");
        let mut steps = LightSteps::default();
        steps.update(&[light()]);
        assert!(steps.have_jumped(10.0), "it came");
    }
}
