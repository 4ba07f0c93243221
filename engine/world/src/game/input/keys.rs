//! Names of what can be pressed and moved.

use serde::{Deserialize, Serialize};

macro_rules! keys {
    ($($name:ident),* $(,)?) => {
        /// A key by its place on a keyboard, named as on an American one.
        #[allow(missing_docs)]
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        pub enum Key { $($name),* }

        impl Key {
            /// The key of a name.
            pub fn from_name(name: &str) -> Option<Self> {
                match name {
                    $(stringify!($name) => Some(Self::$name),)*
                    _ => None,
                }
            }
        }
    };
}

keys! {
    A, B, C, D, E, F, G, H, I, J, K, L, M, N, O, P, Q, R, S, T, U, V, W, X, Y, Z,
    Digit0, Digit1, Digit2, Digit3, Digit4, Digit5, Digit6, Digit7, Digit8, Digit9,
    Numpad0, Numpad1, Numpad2, Numpad3, Numpad4, Numpad5, Numpad6, Numpad7, Numpad8, Numpad9, NumpadEnter,
    NumpadAdd, NumpadSubtract,
    F1, F2, F3, F4, F5, F6, F7, F8, F9, F10, F11, F12,
    Up, Down, Left, Right, Home, End, PageUp, PageDown, Insert, Delete,
    Space, Enter, Escape, Tab, Backspace, CapsLock,
    ShiftLeft, ShiftRight, ControlLeft, ControlRight, AltLeft, AltRight,
    Minus, Equal, Comma, Period, Slash, Semicolon, Quote, Backquote, Backslash, BracketLeft, BracketRight,
}

/// A button of the mouse.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum MouseButton {
    /// The left one.
    Left,
    /// The right one.
    Right,
    /// The wheel.
    Middle,
}

/// A button of a gamepad, by its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum PadButton {
    /// The lower one of four: A or ✕.
    South,
    /// The right one of four: B or ○.
    East,
    /// The left one of four: X or □.
    West,
    /// The upper one of four: Y or △.
    North,
    /// Upper left shoulder.
    LeftShoulder,
    /// Upper right shoulder.
    RightShoulder,
    /// Lower left shoulder.
    LeftTrigger,
    /// Lower right shoulder.
    RightTrigger,
    /// The small one on the left: Select, Back.
    Select,
    /// The small one on the right: Start, Menu.
    Start,
    /// The left stick, pressed.
    LeftStick,
    /// The right stick, pressed.
    RightStick,
    /// Cross, up.
    Up,
    /// Cross, down.
    Down,
    /// Cross, left.
    Left,
    /// Cross, right.
    Right,
}

/// An axis of a gamepad's sticks; right and up are positive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Stick {
    /// Left stick, right.
    LeftX,
    /// Left stick, up.
    LeftY,
    /// Right stick, right.
    RightX,
    /// Right stick, up.
    RightY,
}

/// Anything that can be pressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Button {
    /// A key.
    Key(Key),
    /// A button of the mouse.
    Mouse(MouseButton),
    /// A button of any gamepad.
    Pad(PadButton),
}
