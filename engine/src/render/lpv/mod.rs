//! Cascaded light propagation volumes (Kaplanyan and Dachsbacher 2010; Šefčík 2016, chapters 3.10 and 5).
//!
//! ```text
//! rsm (a light) ─┬─ inject (a cascade) ───┬─ propagate (a cascade) ─ relight
//!                └─ blockers (a cascade) ─┘
//! ```
//! Light is kept as I/h² [W/(m² sr)] in four SH coefficients a colour channel, in 32-bit floats.

mod blockers;
mod inject;
mod propagate;
mod relight;
pub mod sweep;
mod volume;

pub(super) use volume::VolumeUniform;
pub use volume::{MAX_CASCADES, MAX_CELLS, MAX_STEPS, Volume, volumes};

#[cfg(test)]
pub(crate) use self::{blockers::CameraSamplesUniform, propagate::PropagationUniform};
pub(crate) use relight::RelightUniform;

use super::error::RenderError;
use super::frame::Frame;
use super::gbuffer::GBuffer;
use super::light_uniform::LightUniform;
use super::rsm::{self, Rsm};
use crate::gpu::{Binding, ComputeKey};
use crate::graph::{Buffer, Graph, Handle, PassContext, PassError, Texture};
use crate::scene::Aabb;
use crate::world::Transport;
use std::ops::Range;

/// Bytes of a cell of light: three channels of four coefficients.
const LIGHT_BYTES: u64 = 48;

/// Indirect light by the volumes.
pub(crate) struct Indirect {
    /// What the visible surfaces reflect of it, rgba32float.
    pub radiance: Handle<Texture>,
    /// Whether that holds what glossy surfaces reflect.
    pub is_glossy: bool,
    /// Where it can be looked up at any point.
    pub field: Field,
    /// The same of the sky's light alone, if that is wanted.
    pub sky: Option<Field>,
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
    /// All buffers, which a pass that looks light up reads.
    pub(super) fn buffers(&self) -> &[Handle<Buffer>] {
        match self {
            Self::Swept { buffers, .. } => buffers,
            Self::Propagated { lit, .. } => lit,
        }
    }

    /// The define with which a shader looks it up.
    pub(super) fn define(&self) -> &'static str {
        match self {
            Self::Swept { .. } => "SWEPT",
            Self::Propagated { .. } => "PROPAGATED",
        }
    }

    /// What a shader binds that looks it up, by its names.
    pub(super) fn bindings(&self, cx: &PassContext) -> Vec<(&'static str, wgpu::Buffer)> {
        match self {
            Self::Swept { volume, buffers } => {
                let [axes, facing, opacity] = buffers.map(|handle| cx.buffer(handle).clone());
                let volume = cx.gpu.uniform("volume", &volume.uniform());
                vec![("swept", volume), ("axes", axes), ("facing", facing), ("opacity", opacity)]
            }
            Self::Propagated { uniform, lit } => {
                let names = ["light_finest", "light_second", "light_third", "light_coarsest"];
                let mut bindings: Vec<_> = names.into_iter().zip(relight::cascade_buffers(cx, lit)).collect();
                bindings.push(("relight", cx.gpu.uniform("relight", uniform)));
                bindings
            }
        }
    }
}

/// Declares all passes of indirect light. None, with the reason in the report, if the scene needs none.
///
/// # Errors
/// CLPV settings that make no volume.
pub(crate) fn declare<'a>(
    graph: &mut Graph<'a>,
    frame: &Frame<'a>,
    gbuffer: &GBuffer,
) -> Result<Option<Indirect>, RenderError> {
    let Some(clpv) = &frame.scene.clpv else {
        graph.skip("clpv", "the scene has no Clpv component");
        return Ok(None);
    };
    if clpv.settings.transport == Transport::Sweep {
        return sweep::declare(graph, frame, gbuffer, clpv);
    }
    let volumes = volumes(clpv, &frame.bounds, frame.view)?;
    let reach = volumes.iter().fold(Aabb::EMPTY, |reach, volume| reach.union(&volume.bounds()));
    let lights = frame.scene.lights.iter().zip(0..);
    let rsms: Vec<Rsm> = lights.filter_map(|(light, index)| rsm::declare(graph, frame, light, index, &reach)).collect();
    if rsms.is_empty() {
        graph.skip("clpv", "no light feeds indirect light");
        return Ok(None);
    }
    let settings = &clpv.settings;
    let mut lit = Vec::with_capacity(volumes.len());
    for (level, volume) in volumes.iter().enumerate() {
        let injected = inject::declare(graph, frame, &rsms, level, volume);
        let blockers = if settings.occlusion {
            Some(blockers::declare(graph, frame, &rsms, settings.camera_blockers.then_some(gbuffer), level, volume))
        } else {
            graph.skip(format!("blockers, cascade {level}"), "occlusion is switched off");
            None
        };
        lit.push(propagate::declare(graph, settings, injected, blockers, level, volume));
    }
    let uniform = relight::uniform(settings, &volumes);
    let radiance = relight::declare(graph, frame, gbuffer, settings, &volumes, &lit);
    Ok(Some(Indirect { radiance, is_glossy: false, field: Field::Propagated { uniform, lit }, sky: None }))
}

/// Runs an entry point for each texel of some layers of an RSM, into a buffer of fixed-point sums.
fn dispatch_texels(
    cx: &mut PassContext,
    key: &ComputeKey,
    rsm: &Rsm,
    layers: Range<usize>,
    volume: &Volume,
    fixed: &wgpu::Buffer,
    scale: f32,
) -> Result<(), PassError> {
    dispatch_rsm(cx, key, rsm, layers, volume, scale, &[("fixed", Binding::Buffer(fixed))])
}

/// Runs an entry point for each texel of some layers of an RSM, with further bindings.
fn dispatch_rsm(
    cx: &mut PassContext,
    key: &ComputeKey,
    rsm: &Rsm,
    layers: Range<usize>,
    volume: &Volume,
    scale: f32,
    more: &[(&str, Binding)],
) -> Result<(), PassError> {
    let gpu = cx.gpu;
    let volume = gpu.uniform("volume", &volume.uniform());
    let light = LightUniform::buffer(gpu, rsm.light);
    let [base_color, normal, depth] = [rsm.base_color, rsm.normal, rsm.depth].map(|handle| cx.view(handle));
    let groups = rsm.size.div_ceil(8);
    cx.counts().injections += layers.len() as u64 * rsm.layer_texels();
    for layer in layers {
        let layer = gpu.uniform("rsm", &rsm.layer_uniform(layer, scale));
        let mut bindings = vec![
            ("volume", Binding::Buffer(&volume)),
            ("light", Binding::Buffer(&light)),
            ("rsm", Binding::Buffer(&layer)),
            ("base_color", Binding::Texture(&base_color)),
            ("normal", Binding::Texture(&normal)),
            ("depth", Binding::Texture(&depth)),
        ];
        bindings.extend_from_slice(more);
        cx.dispatch(key, &bindings, [groups, groups, 1])?;
    }
    Ok(())
}

/// Workgroups of 64 threads for that many items, spread over two dimensions where one would be over the limit.
pub(super) fn linear_groups(items: u32) -> [u32; 3] {
    let groups = items.div_ceil(64).max(1);
    let x = groups.min(32_768);
    [x, groups.div_ceil(x), 1]
}
