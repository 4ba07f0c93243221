//! What rays find on the surfaces that they meet and in the air, for shaders that import `lib/seen_along.wgsl`: mirrors and
//! glass.

use super::light_volumes::sweep::HazeCells;
use crate::gpu::{Binding, ComputeKey, ShaderDef};
use crate::graph::{Buffer, Handle, PassContext};
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
    /// All buffers, which a pass that looks light up reads.
    pub(in crate::render) fn handles(&self) -> impl Iterator<Item = Handle<Buffer>> {
        self.patches.into_iter().chain(self.haze.map(|haze| haze.light))
    }

    /// The shader with what there is of light.
    pub(in crate::render) fn defined(&self, frame: &Frame, mut key: ComputeKey) -> ComputeKey {
        key = HazeCells::defined(self.haze.as_ref(), key);
        if self.patches.is_none() {
            key = key.def("ONE_BOUNCE", ShaderDef::Flag(true));
        }
        match frame.scene.sky_map {
            Some(_) => key,
            None => key.def("EVEN_SKY", ShaderDef::Flag(true)),
        }
    }

    /// The buffers of this frame, by their names.
    pub(in crate::render) fn buffers(&self, cx: &PassContext) -> Vec<(&'static str, wgpu::Buffer)> {
        let patches = self.patches.map(|light| ("patch_light", cx.buffer(light).clone()));
        let haze = self.haze.map(|haze| haze.bindings(cx));
        patches.into_iter().chain(haze.into_iter().flatten()).collect()
    }

    /// What such a shader binds beside its own: those buffers, where patches lie, and the sky.
    pub(in crate::render) fn bindings<'b>(
        &self,
        frame: &'b Frame,
        buffers: &'b [(&'static str, wgpu::Buffer)],
    ) -> Vec<(&'static str, Binding<'b>)> {
        let mut bindings: Vec<_> = buffers.iter().map(|(name, buffer)| (*name, Binding::Buffer(buffer))).collect();
        if self.patches.is_some() {
            bindings.extend(frame.surfels.patches().bindings());
        }
        if frame.scene.sky_map.is_some() {
            bindings.push(("sky", Binding::Texture(frame.gpu_scene.sky())));
        }
        bindings
    }
}
