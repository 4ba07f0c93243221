//! Keys and mouse of interactive play.

use glam::Vec3;
use std::collections::HashSet;
use winit::event::{ElementState, KeyEvent, MouseButton, MouseScrollDelta, WindowEvent};
use winit::keyboard::{Key, KeyCode, NamedKey, PhysicalKey};

/// What a key asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// Pause or go on.
    Pause,
    /// One tick.
    Step,
    /// Faster (1) or slower (−1).
    Speed(i32),
    /// Back to the scene's camera.
    SceneCamera,
    /// Help on or off.
    Help,
    /// Save a picture.
    Screenshot,
    /// End.
    Quit,
}

/// Keys held and the mouse.
#[derive(Debug, Default)]
pub struct Input {
    held: HashSet<KeyCode>,
    buttons: HashSet<MouseButton>,
    pointer: Option<[f32; 2]>,
    look: [f32; 2],
    orbit: [f32; 2],
    wheel: f32,
}

impl Input {
    /// Takes an event; gives what it asks for. The mouse is the overlay's where `over_ui`.
    pub fn take(&mut self, event: &WindowEvent, over_ui: bool) -> Option<Action> {
        match event {
            WindowEvent::KeyboardInput { event, .. } => return self.key(event),
            WindowEvent::Focused(false) => {
                self.held.clear();
                self.buttons.clear();
            }
            WindowEvent::MouseInput { state: ElementState::Pressed, button, .. } if !over_ui => {
                self.buttons.insert(*button);
            }
            WindowEvent::MouseInput { state: ElementState::Released, button, .. } => {
                self.buttons.remove(button);
            }
            WindowEvent::CursorMoved { position, .. } => self.moved([position.x as f32, position.y as f32]),
            WindowEvent::CursorLeft { .. } => self.pointer = None,
            WindowEvent::MouseWheel { delta, .. } if !over_ui => {
                self.wheel += match delta {
                    MouseScrollDelta::LineDelta(_, lines) => *lines,
                    MouseScrollDelta::PixelDelta(pixels) => pixels.y as f32 / 40.0,
                };
            }
            _ => {}
        }
        None
    }

    fn key(&mut self, event: &KeyEvent) -> Option<Action> {
        if let PhysicalKey::Code(code) = event.physical_key {
            match event.state {
                ElementState::Pressed => self.held.insert(code),
                ElementState::Released => self.held.remove(&code),
            };
        }
        if event.state == ElementState::Released {
            return None;
        }
        // Steps may repeat while the key is held; the rest switch once.
        match &event.logical_key {
            Key::Character(text) if text == "." => Some(Action::Step),
            _ if event.repeat => None,
            Key::Named(NamedKey::Space) => Some(Action::Pause),
            Key::Named(NamedKey::Escape) => Some(Action::Quit),
            Key::Named(NamedKey::F1) => Some(Action::Help),
            Key::Named(NamedKey::F12) => Some(Action::Screenshot),
            Key::Character(text) => match text.as_str() {
                "+" | "=" => Some(Action::Speed(1)),
                "-" | "_" => Some(Action::Speed(-1)),
                "c" | "C" => Some(Action::SceneCamera),
                _ => None,
            },
            _ => None,
        }
    }

    fn moved(&mut self, to: [f32; 2]) {
        if let Some(from) = self.pointer.replace(to) {
            let by = [to[0] - from[0], to[1] - from[1]];
            let sum = |total: &mut [f32; 2]| *total = [total[0] + by[0], total[1] + by[1]];
            if self.buttons.contains(&MouseButton::Left) {
                sum(&mut self.look);
            } else if self.buttons.contains(&MouseButton::Right) || self.buttons.contains(&MouseButton::Middle) {
                sum(&mut self.orbit);
            }
        }
    }

    /// Direction of flight along the camera's axes, each −1, 0 or 1.
    pub fn flight(&self) -> Vec3 {
        let axis = |plus, minus| {
            f32::from(u8::from(self.held.contains(&plus))) - f32::from(u8::from(self.held.contains(&minus)))
        };
        Vec3::new(
            axis(KeyCode::KeyD, KeyCode::KeyA),
            axis(KeyCode::KeyE, KeyCode::KeyQ),
            axis(KeyCode::KeyS, KeyCode::KeyW),
        )
    }

    /// The drag that looks around since the last call [pixels].
    pub fn take_look(&mut self) -> [f32; 2] {
        std::mem::take(&mut self.look)
    }

    /// The drag that orbits since the last call [pixels].
    pub fn take_orbit(&mut self) -> [f32; 2] {
        std::mem::take(&mut self.orbit)
    }

    /// The turn of the wheel since the last call [notches].
    pub fn take_wheel(&mut self) -> f32 {
        std::mem::take(&mut self.wheel)
    }
}
