//! What a frame needs before its passes are declared.

use super::debug::DebugView;
use super::error::RenderError;
use super::lpv::sweep::{self, gather};
use super::settings::{GiMethod, Layer, RenderSettings};
use super::{sky_light, slc};
use crate::scene::{Aabb, Scene, SceneClpv, SceneView};
use crate::world::Transport;

/// Whether indirect light is gathered by rays, where that can be done.
pub(super) fn gathers(scene: &Scene, settings: &RenderSettings) -> bool {
    let is_wanted = |clpv: &SceneClpv| gather::is_wanted(&clpv.settings);
    shows_indirect(settings) && settings.gi == GiMethod::Clpv && scene.clpv.as_ref().is_some_and(is_wanted)
}

/// Whether indirect light casts shadow rays, or the ray hierarchy is shown.
pub(super) fn casts_rays(scene: &Scene, settings: &RenderSettings) -> bool {
    if settings.display && settings.debug.shows(DebugView::Bvh) {
        return true;
    }
    shows_indirect(settings) && settings.gi == GiMethod::Slc && slc::casts_rays(&slc::settings(scene))
}

/// Whether the layer that is shown holds indirect light.
pub(super) fn shows_indirect(settings: &RenderSettings) -> bool {
    matches!(settings.only, Layer::Total | Layer::Indirect)
}

/// Edge of the finest cells that light is swept through, if it is \[m\].
pub(super) fn finest_cell(
    scene: &Scene,
    view: &SceneView,
    settings: &RenderSettings,
    bounds: &Aabb,
    has_rays: bool,
) -> Result<Option<f32>, RenderError> {
    if sky_light::is_needed(scene, settings) {
        return Ok(Some(sweep::sky::volume(bounds).cell));
    }
    let swept = scene.clpv.as_ref().filter(|clpv| clpv.settings.transport == Transport::Sweep);
    let (Some(clpv), GiMethod::Clpv, true) = (swept, settings.gi, shows_indirect(settings)) else { return Ok(None) };
    let quality = gather::quality_of_volumes(&clpv.settings, has_rays && gather::is_wanted(&clpv.settings));
    Ok(sweep::volumes(clpv, quality, bounds, view)?.first().map(|volume| volume.cell))
}

/// Whether a frame's light is averaged with that of the frames before: where it would be another one in each.
pub(super) fn averages(scene: &Scene, settings: &RenderSettings) -> bool {
    let varies = match settings.gi {
        GiMethod::Clpv => {
            gathers(scene, settings) || scene.clpv.as_ref().is_some_and(|clpv| sweep::varies(&clpv.settings))
        }
        GiMethod::Vpl | GiMethod::Slc => true,
        GiMethod::None | GiMethod::Reference(_) => false,
    };
    settings.average && varies
}
