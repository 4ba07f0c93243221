//! Blended surfaces and glass: in come lights, light to look up at any point and the opaque surfaces behind them, out goes a layer
//! that composition lays over the image.

pub(in crate::render) mod blend;
pub(in crate::render) mod glass;
mod glass_depth;
pub(in crate::render) mod particles;
