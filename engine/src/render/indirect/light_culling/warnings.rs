//! Light that stochastic light culling leaves out: it has that of reflective shadow maps and of particles alone.

use crate::render::indirect::lost_light::entity;
use crate::scene::{Primitive, Scene};
use glam::Vec3;

/// A sentence if the scene has surfaces that emit.
pub(super) fn lost_light(scene: &Scene) -> Vec<String> {
    let emits = |primitive: &&Primitive| primitive.material.emissive != Vec3::ZERO && !primitive.is_particles();
    let Some(primitive) = scene.primitives.iter().find(emits) else {
        return Vec::new();
    };
    vec![format!(
        "{}: surfaces that emit, as `{}`, light nothing, since stochastic light culling has the lights of reflective shadow \
         maps and of particles alone; `clpv` and `vpl` take them",
        entity(&scene.settings_names.slc, "slc"),
        primitive.material.name
    )]
}
