//! What stands in a window: its surface, egui on it, and what egui makes painted on the device.

mod damage;
mod input;
mod paint;
mod screen;
mod ui;

pub use input::{Area, GatheredInput};
pub use paint::{Painted, UiPainter};
pub use screen::Screen;
pub use ui::UiSurface;

/// Whether a window can be hoped for. Other systems than Linux and its kin always have a display.
pub fn has_display() -> bool {
    let set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    cfg!(any(windows, target_os = "macos")) || set("DISPLAY") || set("WAYLAND_DISPLAY") || set("WAYLAND_SOCKET")
}
