//! Gamepads.

use gilrs::{Axis, Button as PadKey, EventType, Gilrs};
use lightwell::game::{Button, InputEvent, PadButton, Stick};
use std::collections::BTreeSet;

/// All gamepads; none where the system lets nobody ask, which is said once.
pub struct Pads {
    pads: Option<Gilrs>,
    held: Held,
}

impl Pads {
    /// Looks for gamepads; those that are plugged in later are found too.
    pub fn open() -> Self {
        let pads = Gilrs::new().inspect_err(|error| log::warn!("no gamepads: {error}")).ok();
        for (_, pad) in pads.iter().flat_map(Gilrs::gamepads) {
            log::info!("gamepad `{}`", pad.name());
        }
        Self { pads, held: Held::default() }
    }

    /// The events since the last call.
    pub fn events(&mut self) -> Vec<InputEvent> {
        let mut events = Vec::new();
        while let Some(event) = self.pads.as_mut().and_then(Gilrs::next_event) {
            events.extend(match event.event {
                EventType::ButtonPressed(key, _) => self.held.press(key),
                EventType::ButtonReleased(key, _) => self.held.release(key),
                EventType::AxisChanged(axis, at, _) => self.held.lean(axis, at),
                EventType::Disconnected => self.held.let_go(),
                _ => Vec::new(),
            });
        }
        events
    }
}

/// Buttons and sticks that are held, which are released when the gamepad is unplugged.
#[derive(Debug, Default)]
struct Held {
    buttons: BTreeSet<Button>,
    sticks: BTreeSet<Stick>,
}

impl Held {
    fn press(&mut self, key: PadKey) -> Vec<InputEvent> {
        self.buttons.extend(button(key));
        button(key).map(InputEvent::Press).into_iter().collect()
    }

    fn release(&mut self, key: PadKey) -> Vec<InputEvent> {
        self.buttons.retain(|held| Some(*held) != button(key));
        button(key).map(InputEvent::Release).into_iter().collect()
    }

    fn lean(&mut self, axis: Axis, at: f32) -> Vec<InputEvent> {
        self.sticks.extend(stick(axis));
        stick(axis).map(|stick| InputEvent::Move(stick, at)).into_iter().collect()
    }

    fn let_go(&mut self) -> Vec<InputEvent> {
        let buttons = std::mem::take(&mut self.buttons).into_iter().map(InputEvent::Release);
        let sticks = std::mem::take(&mut self.sticks).into_iter().map(|stick| InputEvent::Move(stick, 0.0));
        buttons.chain(sticks).collect()
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use lightwell::game::{Actions, Input};
    use std::path::Path;

    #[test]
    fn buttons_and_sticks_become_actions() {
        let table = r#"Actions(
            buttons: {"jump": [Pad(South)], "shoot": [Pad(RightTrigger)]},
            axes: {"right": [Stick(LeftX), Buttons(negative: Pad(Left), positive: Pad(Right))], "up": [Stick(RightY)]},
        )"#;
        let mut input = Input::new(Actions::parse(Path::new("a.actions.ron"), table).unwrap());
        let mut held = Held::default();
        let events = [
            held.press(PadKey::South),
            held.press(PadKey::RightTrigger2),
            held.lean(Axis::LeftStickX, -0.5),
            held.lean(Axis::RightStickY, 1.0),
            held.lean(Axis::LeftZ, 1.0),
            held.press(PadKey::Mode),
        ];
        input.begin_step(&events.concat());
        assert!(input.just_pressed("jump") && input.pressed("shoot"));
        assert_eq!((input.axis("right"), input.axis("up")), (-0.5, 1.0));
        input.begin_step(&[held.release(PadKey::South), held.press(PadKey::DPadRight)].concat());
        assert!(input.just_released("jump") && input.pressed("shoot"));
        assert_eq!(input.axis("right"), 0.5);

        input.begin_step(&held.let_go());
        assert!(input.just_released("shoot"), "pulled out");
        assert_eq!((input.axis("right"), input.axis("up")), (0.0, 0.0));
        assert!(held.let_go().is_empty());
    }

    #[test]
    fn every_button_of_the_table_is_on_some_gamepad() {
        let keys = [
            PadKey::South,
            PadKey::East,
            PadKey::North,
            PadKey::West,
            PadKey::LeftTrigger,
            PadKey::LeftTrigger2,
            PadKey::RightTrigger,
            PadKey::RightTrigger2,
            PadKey::Select,
            PadKey::Start,
            PadKey::LeftThumb,
            PadKey::RightThumb,
            PadKey::DPadUp,
            PadKey::DPadDown,
            PadKey::DPadLeft,
            PadKey::DPadRight,
        ];
        let buttons: BTreeSet<Button> = keys.into_iter().filter_map(button).collect();
        assert_eq!(buttons.len(), keys.len(), "each another one");
        assert!([PadKey::C, PadKey::Z, PadKey::Mode, PadKey::Unknown].into_iter().all(|key| button(key).is_none()));
    }
}
