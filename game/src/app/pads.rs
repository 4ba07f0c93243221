//! Gamepads.

use gilrs::{Axis, Button as PadKey, EventType, Gilrs};
use lightwell::game::{Button, InputEvent, PadButton, Stick};

/// All gamepads; none where the system lets nobody ask, which is said once.
pub struct Pads(Option<Gilrs>);

impl Pads {
    /// Looks for gamepads; those that are plugged in later are found too.
    pub fn open() -> Self {
        match Gilrs::new() {
            Ok(pads) => Self(Some(pads)),
            Err(error) => {
                log::warn!("no gamepads: {error}");
                Self(None)
            }
        }
    }

    /// What happened since the last time.
    pub fn events(&mut self) -> Vec<InputEvent> {
        let mut events = Vec::new();
        while let Some(event) = self.0.as_mut().and_then(Gilrs::next_event) {
            events.extend(match event.event {
                EventType::ButtonPressed(key, _) => button(key).map(InputEvent::Press),
                EventType::ButtonReleased(key, _) => button(key).map(InputEvent::Release),
                EventType::AxisChanged(axis, at, _) => stick(axis).map(|stick| InputEvent::Move(stick, at)),
                _ => None,
            });
        }
        events
    }
}

fn button(key: PadKey) -> Option<Button> {
    Some(Button::Pad(match key {
        PadKey::South => PadButton::South,
        PadKey::East => PadButton::East,
        PadKey::West => PadButton::West,
        PadKey::North => PadButton::North,
        PadKey::LeftTrigger => PadButton::LeftShoulder,
        PadKey::RightTrigger => PadButton::RightShoulder,
        PadKey::LeftTrigger2 => PadButton::LeftTrigger,
        PadKey::RightTrigger2 => PadButton::RightTrigger,
        PadKey::Select => PadButton::Select,
        PadKey::Start => PadButton::Start,
        PadKey::LeftThumb => PadButton::LeftStick,
        PadKey::RightThumb => PadButton::RightStick,
        PadKey::DPadUp => PadButton::Up,
        PadKey::DPadDown => PadButton::Down,
        PadKey::DPadLeft => PadButton::Left,
        PadKey::DPadRight => PadButton::Right,
        _ => return None,
    }))
}

fn stick(axis: Axis) -> Option<Stick> {
    Some(match axis {
        Axis::LeftStickX => Stick::LeftX,
        Axis::LeftStickY => Stick::LeftY,
        Axis::RightStickX => Stick::RightX,
        Axis::RightStickY => Stick::RightY,
        _ => return None,
    })
}
