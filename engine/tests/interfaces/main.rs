//! The order of modules, the graphics device, and the interfaces that games use.

mod architecture;
mod cases;
mod custom_components;
mod custom_method;
mod custom_pass;
mod game;
mod gpu;
mod kill;
mod space;
#[path = "../support/mod.rs"]
mod support;
