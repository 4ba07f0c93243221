//! Lights with their shadow maps, one after the other, for passes that look up whether light reaches a point of the air. See
//! `lib/haze_lamps.wgsl`.

use super::{DirectLight, comparison_sampler, layered_view};
use crate::gpu::{Binding, ShaderDef};
use crate::graph::{Handle, PassContext, PassError, Texture};
use crate::render::scene_gpu::light_uniform::LightUniform;
use crate::render::shadows::shadow_map::ShadowMap;
use std::sync::Arc;

/// What a dispatch binds of the lights, and the definitions with which its shader knows them.
pub(in crate::render) struct Bound<'b> {
    pub bindings: Vec<(&'static str, Binding<'b>)>,
    pub define: Option<(&'static str, ShaderDef)>,
    /// Whether nothing was summed up before.
    pub is_first: bool,
}

/// The lights that reach the view.
#[derive(Clone)]
pub(in crate::render) struct Lamps<'a>(Arc<[DirectLight<'a>]>);

impl<'a> Lamps<'a> {
    /// Those lights.
    pub fn new(lights: &[DirectLight<'a>]) -> Self {
        Self(lights.into())
    }

    /// Shadow maps, which a pass that looks them up reads.
    pub fn maps(&self) -> impl Iterator<Item = Handle<Texture>> + '_ {
        self.shadows().map(|(_, shadow)| shadow.map)
    }

    /// Changes with the light that they send out.
    pub fn key(&self) -> Vec<(u64, bool)> {
        self.0.iter().map(|lamp| (lamp.light.revision, lamp.shadow.is_some())).collect()
    }

    fn shadows(&self) -> impl Iterator<Item = (&DirectLight<'a>, &ShadowMap)> {
        self.0.iter().filter_map(|lamp| lamp.shadow.as_ref().map(|shadow| (lamp, shadow)))
    }

    /// Calls a dispatch for each light that casts shadows, and one for all others together, if there are any.
    ///
    /// # Errors
    /// That of the dispatch.
    pub fn dispatch(
        &self,
        cx: &mut PassContext,
        mut dispatch: impl FnMut(&mut PassContext, Bound) -> Result<(), PassError>,
    ) -> Result<(), PassError> {
        cx.counts().lights += self.0.len() as u64;
        let sampler = comparison_sampler(cx.gpu);
        let mut is_first = true;
        for (lamp, shadow) in self.shadows() {
            let lamps = cx.gpu.constants_of("lamps", &[LightUniform::new(lamp.light)]);
            let uniform = cx.gpu.uniform("shadow", &shadow.uniform());
            let map = layered_view(cx.gpu, cx.texture(shadow.map));
            let bindings = vec![
                ("lamps", Binding::Buffer(&lamps)),
                ("shadow", Binding::Buffer(&uniform)),
                ("shadow_map", Binding::Texture(&map)),
                ("shadow_sampler", Binding::Sampler(&sampler)),
            ];
            let define = Some(("SHADOWED", ShaderDef::Flag(true)));
            dispatch(cx, Bound { bindings, define, is_first: std::mem::take(&mut is_first) })?;
        }
        let others: Vec<_> =
            self.0.iter().filter(|lamp| lamp.shadow.is_none()).map(|lamp| LightUniform::new(lamp.light)).collect();
        if others.is_empty() {
            return Ok(());
        }
        let lamps = cx.gpu.constants_of("lamps", &others);
        dispatch(cx, Bound { bindings: vec![("lamps", Binding::Buffer(&lamps))], define: None, is_first })
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}
