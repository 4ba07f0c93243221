//! Light that can be computed by hand: form factors, closed rooms, a light in empty space.

mod alpha_mask;
mod ambient_occlusion;
mod area_lights;
mod as_published;
mod blend;
mod clutter;
mod depth_of_field;
mod diffusion_lookup;
mod diffusion_sources;
mod direct_light;
mod double_sided_shells;
mod formulas;
mod gather;
mod glass;
mod half_precision;
mod instant_radiosity;
mod large_worlds;
mod layers;
mod lens;
mod light_culling;
mod light_volumes;
mod lpv_transport;
mod media;
mod orthographic;
mod particles;
mod path_tracer;
mod probes;
mod radiosity;
mod rasterizer_grid;
mod samplers;
mod sky;
mod sky_light;
#[path = "../support/mod.rs"]
mod support;
mod sweep_rooms;
mod sweep_transport;
