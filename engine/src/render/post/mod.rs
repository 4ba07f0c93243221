//! From light to image: in comes the light of each stage, out go its sum, the radiance that is measured, and what a
//! display shows of it.

mod auto_exposure;
pub(in crate::render) mod bloom;
pub mod compare;
pub mod compose;
pub(in crate::render) mod depth_of_field;
pub(in crate::render) mod film;
pub mod mlaa;
pub(in crate::render) mod temporal_antialiasing;
pub mod tone_map;
