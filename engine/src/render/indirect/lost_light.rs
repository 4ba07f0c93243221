//! Light that a scene asks for and its method leaves out, said with the name of the entity: for the frame's warnings.

use super::light_volumes::sweep::gather;
use crate::render::frame::Frame;
use crate::render::settings::GiMethod;
use crate::scene::{Primitive, Scene};
use crate::world::{CellSize, ClpvPlacement, Transport, VirtualPlacement, VirtualShading};
use glam::Vec3;

/// The light that a frame leaves out under a method.
pub(in crate::render) fn of(frame: &Frame, method: GiMethod) -> Vec<String> {
    let mut lost = match method {
        GiMethod::CLPV => of_light_volumes(frame),
        GiMethod::VPL => of_virtual_lights(frame.scene),
        GiMethod::SLC => of_light_culling(frame.scene),
        _ => Vec::new(),
    };
    lost.extend(of_media(frame.scene, method));
    lost
}

/// Media are part of the sweep and the gather alone.
fn of_media(scene: &Scene, method: GiMethod) -> Option<String> {
    let medium = scene.media.first()?;
    let is_swept = scene.clpv.as_ref().is_none_or(|clpv| clpv.settings.transport == Transport::Sweep);
    if method == GiMethod::NONE || (method == GiMethod::CLPV && is_swept) {
        return None;
    }
    Some(format!(
        "`{}`: the fog scatters light of the lights alone, and light between surfaces passes it as clear air; `clpv` \
         with `transport: Sweep` takes it into account",
        medium.name
    ))
}

/// The entity that holds a method's settings, as a message names it.
fn entity(name: &str, component: &str) -> String {
    if name.is_empty() { format!("the scene's `{component}` component") } else { format!("`{name}`") }
}

fn of_light_volumes(frame: &Frame) -> Vec<String> {
    let Some(clpv) = &frame.scene.clpv else { return Vec::new() };
    let (settings, who) = (&clpv.settings, entity(&frame.scene.settings_names.clpv, "clpv"));
    if !gather::is_wanted(settings) {
        return Vec::new();
    }
    if let Some(why) = frame.refused_rays {
        return vec![format!("{who}: light is looked up in the volumes and not gathered by rays: {why}")];
    }
    // Rays look light up where it covers most: in the coarsest volume.
    let covers_all = settings.cell_size == CellSize::Auto && settings.placement == ClpvPlacement::Fixed;
    let (coarsest, finer) = (if covers_all { "the one over the scene" } else { "the coarsest" }, settings.cascades - 1);
    match finer {
        0 => Vec::new(),
        _ => vec![format!(
            "{who}: `cascades` is {}, but rays look light up in {coarsest} alone: {finer} finer are swept in vain; use \
             `cascades: 1`, or `gather_rays: Count(0)` to look light up without rays",
            settings.cascades
        )],
    }
}

fn of_virtual_lights(scene: &Scene) -> Vec<String> {
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

/// Light culling has the light of reflective shadow maps and of particles alone.
fn of_light_culling(scene: &Scene) -> Vec<String> {
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
