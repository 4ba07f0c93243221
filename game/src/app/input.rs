//! What the window tells, as input of the game.

use lightwell::game::{Button, InputEvent, Key, MouseButton};
use std::collections::BTreeSet;
use winit::event::{DeviceEvent, ElementState, MouseScrollDelta, WindowEvent};
use winit::keyboard::{KeyCode, PhysicalKey};

/// Pixels that count as one line of the wheel.
const PIXELS_A_LINE: f64 = 40.0;

/// Events since the last step, and what is down.
#[derive(Debug, Default)]
pub struct Gathered {
    events: Vec<InputEvent>,
    held: BTreeSet<Button>,
    aspect: f32,
}

impl Gathered {
    /// Takes an event of a window of that size \[pixels\].
    pub fn window(&mut self, event: &WindowEvent, size: [u32; 2]) {
        match event {
            WindowEvent::KeyboardInput { event, is_synthetic: false, .. } if !event.repeat => {
                if let PhysicalKey::Code(code) = event.physical_key
                    && let Some(key) = key(code)
                {
                    self.button(Button::Key(key), event.state);
                }
            }
            WindowEvent::MouseInput { button, state, .. } => {
                let button = match button {
                    winit::event::MouseButton::Left => MouseButton::Left,
                    winit::event::MouseButton::Right => MouseButton::Right,
                    winit::event::MouseButton::Middle => MouseButton::Middle,
                    _ => return,
                };
                self.button(Button::Mouse(button), *state);
            }
            WindowEvent::CursorMoved { position, .. } => {
                let [x, y] = [position.x, position.y].map(|at| at as f32);
                let [width, height] = size.map(|edge| edge.max(1) as f32);
                self.events.push(InputEvent::Point(x / width, y / height));
            }
            WindowEvent::MouseWheel { delta, .. } => {
                let lines = match delta {
                    MouseScrollDelta::LineDelta(_, lines) => *lines,
                    MouseScrollDelta::PixelDelta(pixels) => (pixels.y / PIXELS_A_LINE) as f32,
                };
                self.events.push(InputEvent::Wheel(lines));
            }
            // What is let go elsewhere is told to nobody.
            WindowEvent::Focused(false) => {
                self.events.extend(std::mem::take(&mut self.held).into_iter().map(InputEvent::Release));
            }
            _ => {}
        }
    }

    /// Takes an event of a device.
    pub fn device(&mut self, event: &DeviceEvent) {
        if let DeviceEvent::MouseMotion { delta: (x, y) } = event {
            self.events.push(InputEvent::Motion(*x as f32, *y as f32));
        }
    }

    /// Takes events from elsewhere.
    #[cfg(feature = "gamepad")]
    pub fn add(&mut self, events: Vec<InputEvent>) {
        self.events.extend(events);
    }

    fn button(&mut self, button: Button, state: ElementState) {
        match state {
            ElementState::Pressed => {
                self.held.insert(button);
                self.events.push(InputEvent::Press(button));
            }
            ElementState::Released => {
                self.held.remove(&button);
                self.events.push(InputEvent::Release(button));
            }
        }
    }

    /// The image has that size \[pixels\].
    pub fn size(&mut self, [width, height]: [u32; 2]) {
        let aspect = width.max(1) as f32 / height.max(1) as f32;
        if self.aspect != aspect {
            self.aspect = aspect;
            self.events.push(InputEvent::Aspect(aspect));
        }
    }

    /// The events since the last call.
    pub fn take(&mut self) -> Vec<InputEvent> {
        std::mem::take(&mut self.events)
    }
}

/// The key of a code: winit's names with what says that they are keys taken off.
fn key(code: KeyCode) -> Option<Key> {
    let name = format!("{code:?}");
    let short = ["Key", "Arrow"].iter().find_map(|prefix| name.strip_prefix(prefix)).unwrap_or(&name);
    Key::from_name(short)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_have_the_names_of_the_table() {
        let expected = [
            (KeyCode::KeyW, Key::W),
            (KeyCode::ArrowLeft, Key::Left),
            (KeyCode::Digit7, Key::Digit7),
            (KeyCode::Space, Key::Space),
            (KeyCode::ShiftLeft, Key::ShiftLeft),
            (KeyCode::Numpad0, Key::Numpad0),
            (KeyCode::Escape, Key::Escape),
            (KeyCode::F11, Key::F11),
        ];
        for (code, name) in expected {
            assert_eq!(key(code), Some(name));
        }
        assert_eq!(key(KeyCode::MediaStop), None);
    }

    #[test]
    fn the_shape_of_the_picture_is_told_when_it_changes() {
        let mut gathered = Gathered::default();
        gathered.size([200, 100]);
        gathered.size([400, 200]);
        gathered.size([100, 100]);
        assert_eq!(gathered.take(), [InputEvent::Aspect(2.0), InputEvent::Aspect(1.0)]);
    }

    #[test]
    fn what_is_held_is_let_go_with_the_focus() {
        let mut gathered = Gathered::default();
        let left = WindowEvent::MouseInput {
            device_id: winit::event::DeviceId::dummy(),
            state: ElementState::Pressed,
            button: winit::event::MouseButton::Left,
        };
        gathered.window(&left, [100, 100]);
        gathered.window(&WindowEvent::Focused(false), [100, 100]);
        let button = Button::Mouse(MouseButton::Left);
        assert_eq!(gathered.take(), [InputEvent::Press(button), InputEvent::Release(button)]);
        assert_eq!(gathered.take(), []);
    }
}
