//! Light that the settings of instant radiosity leave out.

use crate::render::indirect::lost_light::entity;
use crate::scene::Scene;
use crate::world::{VirtualPlacement, VirtualShading};
use glam::Vec3;

/// A sentence for each kind of light that the scene has and virtual lights leave out.
pub(super) fn lost_light(scene: &Scene) -> Vec<String> {
    let Some(settings) = &scene.vpl else { return Vec::new() };
    let who = entity(&scene.settings_names.vpl, "vpl");
    let emits = scene.primitives.iter().find(|primitive| primitive.material.emissive != Vec3::ZERO);
    let sky = scene.sky != Vec3::ZERO;
    let mut lost = Vec::new();
    if settings.shading == VirtualShading::AsPublished {
        if sky {
            lost.push(format!("{who}: the sky lights nothing, since `shading: AsPublished` has lights alone"));
        }
        if let Some(primitive) = emits {
            lost.push(format!(
                "{who}: surfaces that emit, as `{}`, light nothing, since `shading: AsPublished` has lights alone",
                primitive.material.name
            ));
        }
    } else if settings.placement == VirtualPlacement::Rsm
        && let Some(primitive) = emits
    {
        lost.push(format!(
            "{who}: surfaces that emit, as `{}`, light nothing, since `placement: Rsm` has what lights see alone; use \
             `placement: Particles`",
            primitive.material.name
        ));
    }
    lost
}
