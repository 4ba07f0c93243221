//! Which surfaces of the pixels a G-buffer holds.

use crate::gpu::ShaderDef;
use crate::graph::PassBindings;

/// Which surfaces of the pixels a G-buffer holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Surfaces {
    /// The nearest ones.
    Nearest,
    /// Lobes of them that are drawn apart, see `geometry::second_lobe`.
    SecondLobes,
}

impl Surfaces {
    /// Lets a pass know that it reads such a G-buffer.
    pub(in crate::render) fn define_for(self, pass: &mut PassBindings) {
        if self == Self::SecondLobes {
            pass.define("STRETCHED", ShaderDef::Flag(true));
        }
    }

    /// Name of a pass or an image that is of these surfaces.
    pub(in crate::render) fn name(self, name: &str) -> String {
        match self {
            Self::Nearest => name.to_owned(),
            Self::SecondLobes => format!("second lobe, {name}"),
        }
    }
}
