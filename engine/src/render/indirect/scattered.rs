//! What rays find on the surfaces that they meet and in the air, for shaders that import `lib/seen_along.wgsl`: mirrors and
//! glass.

use super::light_volumes::sweep::HazeCells;
use crate::gpu::ShaderDef;
use crate::graph::{Buffer, Handle, PassBindings};
use crate::render::frame::Frame;

/// The light of a method that rays find.
#[derive(Clone, Copy, Default)]
pub(crate) struct Scattered {
    /// Irradiance of the surfels' patches \[W/m²\]; none: what rays meet is lit by the lights alone.
    pub patches: Option<Handle<Buffer>>,
    /// Light in media, if there are any.
    pub haze: Option<HazeCells>,
}

impl Scattered {
    /// Binds it to a pass whose shader looks it up.
    pub(in crate::render) fn bind<'a>(&self, pass: &mut PassBindings<'_, 'a>, frame: &Frame<'a>) {
        if let Some(haze) = &self.haze {
            haze.bind(pass);
        }
        match self.patches {
            Some(patches) => {
                pass.read("patch_light", patches);
                frame.bind_patches(pass);
            }
            None => pass.define("ONE_BOUNCE", ShaderDef::Flag(true)),
        }
        frame.bind_sky(pass);
    }
}
