//! Input: keys, mouse and gamepad as actions, and scripts of it.
//!
//! A game asks for actions, `input.just_pressed("jump")`, and a file says which buttons and sticks they mean:
//!
//! ```ron
//! Actions(
//!     buttons: {
//!         "jump": [Key(Space), Pad(South)],
//!         "shoot": [Mouse(Left), Pad(RightTrigger)],
//!     },
//!     axes: {
//!         "right": [Buttons(negative: Key(A), positive: Key(D)), Stick(LeftX)],
//!         "forward": [Buttons(negative: Key(S), positive: Key(W)), Stick(LeftY)],
//!     },
//! )
//! ```

mod actions;
mod keys;
mod script;

pub use actions::{Actions, AxisBinding};
pub use keys::{Button, Key, MouseButton, PadButton, Stick};
pub use script::InputScript;

use super::fault;
use crate::files::suggestion;
use crate::world::{Camera, GlobalTransform, Projection};
use bevy_ecs::prelude::Resource;
use glam::{Vec2, Vec3};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// Something that the player did.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum InputEvent {
    /// A button went down.
    Press(Button),
    /// A button came up.
    Release(Button),
    /// A stick moved to a position, −1 to 1.
    Move(Stick, f32),
    /// The pointer is at a place in the image, both 0 to 1 from the upper left corner.
    Point(f32, f32),
    /// The mouse moved \[pixels\], to the right and down.
    Motion(f32, f32),
    /// The wheel turned \[lines\], up.
    Wheel(f32),
    /// The aspect ratio of the image has changed: its width over its height.
    Aspect(f32),
}

/// Positions of a stick that are taken for its middle.
const DEAD_ZONE: f32 = 0.15;

/// The input of the player in the present step.
#[derive(Resource, Clone, Debug, Default)]
pub struct Input {
    actions: Actions,
    held: BTreeSet<Button>,
    pressed: BTreeSet<Button>,
    released: BTreeSet<Button>,
    sticks: BTreeMap<Stick, f32>,
    pointer: Vec2,
    motion: Vec2,
    wheel: f32,
    aspect: Option<f32>,
}

/// Width over height until the size of the image is known.
const USUAL_ASPECT: f32 = 1.6;

impl Input {
    /// With a table of actions.
    pub fn new(actions: Actions) -> Self {
        Self { actions, ..Self::default() }
    }

    /// Another table of actions.
    pub fn set_actions(&mut self, actions: Actions) {
        self.actions = actions;
    }

    /// Takes the events of a step.
    pub fn begin_step(&mut self, events: &[InputEvent]) {
        self.pressed.clear();
        self.released.clear();
        (self.motion, self.wheel) = (Vec2::ZERO, 0.0);
        for event in events {
            match *event {
                InputEvent::Press(button) if self.held.insert(button) => drop(self.pressed.insert(button)),
                InputEvent::Release(button) if self.held.remove(&button) => drop(self.released.insert(button)),
                InputEvent::Press(_) | InputEvent::Release(_) => {}
                InputEvent::Move(stick, at) => {
                    let at = if at.is_finite() { at.clamp(-1.0, 1.0) } else { 0.0 };
                    self.sticks.insert(stick, at);
                }
                InputEvent::Point(x, y) => self.pointer = Vec2::new(x, y),
                InputEvent::Motion(x, y) => self.motion += Vec2::new(x, y),
                InputEvent::Wheel(lines) => self.wheel += lines,
                InputEvent::Aspect(aspect) => self.aspect = Some(aspect).filter(|aspect| aspect.is_normal()),
            }
        }
    }

    /// Whether a button of the action is down.
    pub fn pressed(&self, action: &str) -> bool {
        self.buttons(action).iter().any(|button| self.held.contains(button))
    }

    /// Whether a button of the action went down in this step.
    pub fn just_pressed(&self, action: &str) -> bool {
        self.buttons(action).iter().any(|button| self.pressed.contains(button))
    }

    /// Whether a button of the action came up in this step.
    pub fn just_released(&self, action: &str) -> bool {
        self.buttons(action).iter().any(|button| self.released.contains(button))
    }

    /// The value of an axis, −1 to 1: the sum of its bindings.
    pub fn axis(&self, axis: &str) -> f32 {
        let Some(bindings) = self.actions.axes.get(axis) else {
            unknown("axis", axis, self.actions.axes.keys());
            return 0.0;
        };
        bindings.iter().map(|binding| self.value(binding)).sum::<f32>().clamp(-1.0, 1.0)
    }

    /// Two axes as a vector that is at most 1 long.
    pub fn vector(&self, x: &str, y: &str) -> Vec2 {
        Vec2::new(self.axis(x), self.axis(y)).clamp_length_max(1.0)
    }

    /// Where the pointer is in the image, both 0 to 1 from the upper left corner.
    pub fn pointer(&self) -> Vec2 {
        self.pointer
    }

    /// The line of sight through the pointer, from where to which direction: for [`SpatialQuery::cast_ray`](super::SpatialQuery::cast_ray), to
    /// find what is pointed at.
    pub fn pointer_ray(&self, camera: &Camera, place: &GlobalTransform) -> (Vec3, Vec3) {
        let [right, up, back] = [0, 1, 2].map(|axis| Vec3::from(place.0.matrix3.col(axis)).normalize_or_zero());
        let half_height = match camera.projection {
            Projection::Perspective => (0.5 * camera.fov.to_radians()).tan(),
            Projection::Orthographic { height } => 0.5 * height,
        };
        let half_width = half_height * self.aspect.unwrap_or(USUAL_ASPECT);
        let (x, y) = (2.0 * self.pointer.x - 1.0, 1.0 - 2.0 * self.pointer.y);
        let aside = right * (x * half_width) + up * (y * half_height);
        match camera.projection {
            Projection::Perspective => (place.position(), (aside - back).normalize_or(Vec3::NEG_Z)),
            Projection::Orthographic { .. } => (place.position() + aside, -back),
        }
    }

    /// How far the mouse moved in this step \[pixels\], to the right and down.
    pub fn motion(&self) -> Vec2 {
        self.motion
    }

    /// How far the wheel turned in this step \[lines\], up.
    pub fn wheel(&self) -> f32 {
        self.wheel
    }

    /// Whether a button is down, whatever it means.
    pub fn holds(&self, button: Button) -> bool {
        self.held.contains(&button)
    }

    fn value(&self, binding: &AxisBinding) -> f32 {
        let down = |button: &Button| f32::from(u8::from(self.held.contains(button)));
        match binding {
            AxisBinding::Buttons { negative, positive } => down(positive) - down(negative),
            AxisBinding::Stick(stick) => {
                let at = self.sticks.get(stick).copied().unwrap_or(0.0);
                if at.abs() < DEAD_ZONE { 0.0 } else { at }
            }
        }
    }

    fn buttons(&self, action: &str) -> &[Button] {
        match self.actions.buttons.get(action) {
            Some(buttons) => buttons,
            None => {
                unknown("button", action, self.actions.buttons.keys());
                &[]
            }
        }
    }
}

/// A question about what the table does not have is a fault of the system that asks.
fn unknown<'a>(kind: &str, name: &str, known: impl Iterator<Item = &'a String>) {
    let help = suggestion(name, known.map(String::as_str));
    let help = help.unwrap_or_else(|| "the game has no table of actions, `.actions(\"….actions.ron\")`".into());
    fault::note(format!("the table of actions has no {kind} `{name}`\n  help: {help}"));
}
