//! Cascaded light propagation volumes, as the scene's `Clpv` component sets them: in come what lights see (reflective
//! shadow maps) and the scene's surfaces, out goes what the visible surfaces reflect, and light to look up at any point.
//! Two ways of transport fill the volumes: the [`sweep`] along many directions with a final gather, and the thesis's
//! `diffusion` from cell to cell.

mod diffusion;
mod method;
mod presets;
pub(in crate::render) mod radiosity;
mod rsm_draw;
pub mod sweep;
mod texels;
mod volume;
mod warnings;

pub(crate) use diffusion::relight::RelightUniform;
#[cfg(test)]
pub(crate) use diffusion::{
    CameraSamplesUniform, EmissionUniform, OcclusionUniform, PropagationUniform, RelitRegionUniform,
};
pub(in crate::render) use method::LightVolumesMethod;
#[cfg(test)]
pub(crate) use radiosity::{FirstBounceUniform, LinksUniform};
#[cfg(test)]
pub(crate) use rsm_draw::DrawUniform;
pub(in crate::render) use volume::VolumeUniform;
pub use volume::{MAX_CASCADES, MAX_CELLS, MAX_STEPS, Volume, volumes};

use crate::graph::{Buffer, Handle, PassBindings, Texture};
use crate::render::indirect::Scattered;
use diffusion::relight;

/// Most bounces that a `Count` may ask for.
pub const MAX_BOUNCES: u32 = 32;

/// Indirect light by the volumes.
pub(crate) struct Indirect {
    /// Radiance that the visible surfaces reflect of it, rgba32float.
    pub radiance: Handle<Texture>,
    /// Radiance that mirrors reflect, with the distance of what they show, where rays of their own bring it.
    pub mirrored: Option<Handle<Texture>>,
    /// Whether that holds what glossy surfaces reflect.
    pub is_glossy: bool,
    /// Where it can be looked up at any point.
    pub field: Field,
    /// The same of the sky's light alone, if that is wanted.
    pub sky: Option<Field>,
    /// What rays find on surfaces that they meet, and in the air.
    pub scattered: Scattered,
    /// How the light of patches changed since the frame before, where that is followed.
    pub change: Option<Handle<Buffer>>,
}

/// Volumes of indirect light, as `lib/sweep_lookup.wgsl` and `lib/relight.wgsl` read them.
#[derive(Clone)]
pub(crate) enum Field {
    /// Irradiance by cell and normal; of several cascades the coarsest, which covers most.
    Swept {
        /// Where the volume lies.
        volume: Volume,
        /// Irradiance by axis, by the cell's surface, and the opacity.
        buffers: [Handle<Buffer>; 3],
    },
    /// Spherical harmonics by cell, finest cascade first.
    Propagated {
        /// `Relight` of `lib/relight.wgsl`.
        uniform: RelightUniform,
        /// The cascades.
        lit: Vec<Handle<Buffer>>,
    },
}

impl Field {
    /// The define with which a shader looks it up.
    pub(in crate::render) fn define(&self) -> &'static str {
        match self {
            Self::Swept { .. } => "SWEPT",
            Self::Propagated { .. } => "PROPAGATED",
        }
    }

    /// Binds it to a pass, if its shader knows swept light.
    pub(in crate::render) fn bind_swept(&self, pass: &mut PassBindings) {
        if let Self::Swept { .. } = self {
            self.bind(pass, |_| true);
        }
    }

    /// Binds to a pass that looks it up what the shader asks for.
    pub(in crate::render) fn bind(&self, pass: &mut PassBindings, asks_for: impl Fn(&str) -> bool) {
        match self {
            Self::Swept { volume, buffers: [axes, facing, opacity] } => {
                pass.uniform("swept", &volume.uniform());
                let buffers = [("axes", *axes), ("facing", *facing), ("opacity", *opacity)];
                buffers
                    .into_iter()
                    .filter(|(name, _)| asks_for(name))
                    .for_each(|(name, buffer)| pass.read(name, buffer));
            }
            Self::Propagated { uniform, lit } => {
                pass.uniform("relight", uniform);
                relight::bind_cascades(pass, lit);
            }
        }
    }
}
