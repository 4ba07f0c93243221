//! Light that the settings of the light volumes leave out.

use super::sweep::gather;
use crate::render::frame::Frame;
use crate::render::indirect::lost_light::entity;
use crate::world::{CellSize, ClpvPlacement};

/// A sentence for each kind of light that the frame leaves out.
pub(super) fn lost_light(frame: &Frame) -> Vec<String> {
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
