//! The sky: in come its radiance by direction and the scene, out goes its light on surfaces for methods that bring none
//! of it, and its image in glossy surfaces. What lies behind everything is drawn when the light is put together.

pub(in crate::render) mod environment;
pub(in crate::render) mod gpu_sky;
pub(in crate::render) mod sky_light;
