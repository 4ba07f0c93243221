//! Lights with their shadow maps, one after the other, for passes that look up whether light reaches a point of the air. See
//! `lib/haze_lamps.wgsl`.

use super::{comparison_sampler, layered_view};
use crate::gpu::{Binding, ShaderDef};
use crate::graph::{Graph, Handle, PassContext, PassError, Texture};
use crate::render::frame::Frame;
use crate::render::scene_gpu::light_uniform::LightUniform;
use crate::render::shadows::light_views;
use crate::render::shadows::shadow_map::{self, ShadowMap};
use crate::scene::SceneLight;
use glam::Vec3;
use std::sync::Arc;

/// What a dispatch binds of the lights, and the definitions with which its shader knows them.
pub(in crate::render) struct Bound<'b> {
    pub bindings: Vec<(&'static str, Binding<'b>)>,
    pub define: Option<(&'static str, ShaderDef)>,
    /// Whether nothing was summed up before.
    pub is_first: bool,
}

/// A light, and its shadow map if it casts shadows.
type Lamp<'a> = (&'a SceneLight, Option<ShadowMap>);

/// The lights whose light media scatter.
#[derive(Clone)]
pub(in crate::render) struct Lamps<'a>(Arc<[Lamp<'a>]>);

impl<'a> Lamps<'a> {
    /// Those of the frame whose shadow maps were declared before, and those that need none. None where there are no media to
    /// scatter their light, or the frame shows no light.
    pub fn of(graph: &Graph, frame: &Frame<'a>) -> Option<Self> {
        let is_needed = frame.settings.only.is_light() && !frame.scene.media.is_empty();
        let lamp = |light: &'a SceneLight| {
            let shadow = shadow_map::declared(graph, frame, light);
            // What is out of the view has no map, and none of its light is seen.
            let is_lit = shadow.is_some() || !light.casts_shadow || light_views(light, &frame.bounds).is_empty();
            (is_lit && light.intensity != Vec3::ZERO).then_some((light, shadow))
        };
        is_needed.then(|| Self(frame.scene.lights.iter().filter_map(lamp).collect()))
    }

    /// Shadow maps, which a pass that looks them up reads.
    pub fn maps(&self) -> impl Iterator<Item = Handle<Texture>> + '_ {
        self.shadows().map(|(_, shadow)| shadow.map)
    }

    /// Changes with the light that they send out.
    pub fn key(&self) -> Vec<(u64, bool)> {
        self.0.iter().map(|(light, shadow)| (light.revision, shadow.is_some())).collect()
    }

    fn shadows(&self) -> impl Iterator<Item = (&'a SceneLight, &ShadowMap)> {
        self.0.iter().filter_map(|(light, shadow)| shadow.as_ref().map(|shadow| (*light, shadow)))
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
        for (light, shadow) in self.shadows() {
            let lamps = cx.gpu.constants_of("lamps", &[LightUniform::new(light)]);
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
        let others = self.0.iter().filter(|(_, shadow)| shadow.is_none());
        let others: Vec<_> = others.map(|(light, _)| LightUniform::new(light)).collect();
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
