//! Tests of the world.
#![allow(clippy::unwrap_used)]

mod animation;
mod hierarchy;
mod keys;
mod rig;
