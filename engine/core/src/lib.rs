//! Rooms of Lightwell that all others build on: boxes, rays, transforms and identities ([`core`]), image metrics
//! ([`measure`]), times of frames ([`profile`]) and files of packed games ([`packed`]).
//!
//! Games and tools use them through the crate `lightwell`, which hands these rooms on under the same names.

pub mod core;
pub mod measure;
pub mod packed;
pub mod profile;
