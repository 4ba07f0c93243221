//! What a window tells, as input of a game that is shown in it or in a part of it.

use lightwell::game::{Button, InputEvent, Key, MouseButton};
use std::collections::BTreeSet;
use winit::event::{DeviceEvent, ElementState, MouseScrollDelta, WindowEvent};
use winit::keyboard::{KeyCode, PhysicalKey};

/// Pixels that count as one line of the wheel.
const PIXELS_A_LINE: f64 = 40.0;

/// Where in a window a game is shown \[pixels\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Area {
    /// Its upper left corner.
    pub min: [f32; 2],
    /// Its size.
    pub size: [f32; 2],
}

impl Area {
    /// All of a window of a size.
    pub fn of_window(size: [u32; 2]) -> Self {
        Self { min: [0.0; 2], size: size.map(|edge| edge as f32) }
    }

    /// A place as shares of the area, 0 to 1 inside.
    fn share(&self, [x, y]: [f32; 2]) -> [f32; 2] {
        [(x - self.min[0]) / self.size[0].max(1.0), (y - self.min[1]) / self.size[1].max(1.0)]
    }
}

/// Events since the last step, and what is down.
#[derive(Debug, Default)]
pub struct GatheredInput {
    events: Vec<InputEvent>,
    held: BTreeSet<Button>,
    aspect: f32,
}

impl GatheredInput {
    /// Takes an event of a window that shows the game in an area.
    pub fn window(&mut self, event: &WindowEvent, area: Area) {
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
                let [x, y] = area.share([position.x as f32, position.y as f32]);
                self.events.push(InputEvent::Point(x, y));
            }
            WindowEvent::MouseWheel { delta, .. } => {
                let lines = match delta {
                    MouseScrollDelta::LineDelta(_, lines) => *lines,
                    MouseScrollDelta::PixelDelta(pixels) => (pixels.y / PIXELS_A_LINE) as f32,
                };
                self.events.push(InputEvent::Wheel(lines));
            }
            // What is let go elsewhere is told to nobody.
            WindowEvent::Focused(false) => self.let_go(),
            _ => {}
        }
    }

    /// Lets go of all buttons: nothing more is heard of them.
    pub fn let_go(&mut self) {
        self.events.extend(std::mem::take(&mut self.held).into_iter().map(InputEvent::Release));
    }

    /// Takes an event of a device.
    pub fn device(&mut self, event: &DeviceEvent) {
        if let DeviceEvent::MouseMotion { delta: (x, y) } = event {
            self.events.push(InputEvent::Motion(*x as f32, *y as f32));
        }
    }

    /// Takes events from elsewhere.
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
        let mut gathered = GatheredInput::default();
        gathered.size([200, 100]);
        gathered.size([400, 200]);
        gathered.size([100, 100]);
        assert_eq!(gathered.take(), [InputEvent::Aspect(2.0), InputEvent::Aspect(1.0)]);
    }

    #[test]
    fn places_are_shares_of_the_area() {
        let area = Area { min: [100.0, 50.0], size: [200.0, 100.0] };
        assert_eq!((area.share([150.0, 100.0]), area.share([100.0, 150.0])), ([0.25, 0.5], [0.0, 1.0]));
    }

    #[test]
    fn what_is_held_is_let_go_with_the_focus() {
        let mut gathered = GatheredInput::default();
        let left = WindowEvent::MouseInput {
            device_id: winit::event::DeviceId::dummy(),
            state: ElementState::Pressed,
            button: winit::event::MouseButton::Left,
        };
        gathered.window(&left, Area::of_window([100; 2]));
        gathered.window(&WindowEvent::Focused(false), Area::of_window([100; 2]));
        let button = Button::Mouse(MouseButton::Left);
        assert_eq!(gathered.take(), [InputEvent::Press(button), InputEvent::Release(button)]);
        assert_eq!(gathered.take(), []);
    }
}
