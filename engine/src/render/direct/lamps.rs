//! Lights with their shadow maps, one after the other, for passes that look up whether light reaches a point of the air. See
//! `lib/haze_lamps.wgsl`.

use super::comparison;
use crate::graph::{ComputeBuilder, Counts, Graph, Step};
use crate::render::frame::Frame;
use crate::render::scene_gpu::light_uniform::LightUniform;
use crate::render::shadows::light_views;
use crate::render::shadows::shadow_map::{self, ShadowMap};
use crate::scene::SceneLight;
use glam::Vec3;
use std::sync::Arc;

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

    fn shadows(&self) -> impl Iterator<Item = (&'a SceneLight, &ShadowMap)> {
        self.0.iter().filter_map(|(light, shadow)| shadow.as_ref().map(|shadow| (*light, shadow)))
    }

    /// Declares a step of so many threads for each light that casts shadows, and one for all others together, if there are
    /// any. `has_sum` says whether light was summed up before.
    pub fn declare_steps(&self, pass: &mut ComputeBuilder<'_, 'a>, has_sum: bool, threads: u32) {
        pass.count(Counts { lights: self.0.len() as u64, ..Counts::default() });
        let mut has_sum = has_sum;
        for (light, shadow) in self.shadows() {
            let mut step = Self::step(pass, std::mem::replace(&mut has_sum, true), &[LightUniform::new(light)]);
            step.flag("SHADOWED", true);
            step.uniform("shadow", &shadow.uniform());
            step.read_layers("shadow_map", shadow.map);
            step.sampler("shadow_sampler", comparison());
            step.over_items(threads);
        }
        let others = self.0.iter().filter(|(_, shadow)| shadow.is_none());
        let others: Vec<_> = others.map(|(light, _)| LightUniform::new(light)).collect();
        if !others.is_empty() {
            Self::step(pass, has_sum, &others).over_items(threads);
        }
    }

    fn step<'p, 'g>(pass: &'p mut ComputeBuilder<'g, 'a>, has_sum: bool, lamps: &[LightUniform]) -> Step<'p, 'g, 'a> {
        let mut step = pass.step("main");
        step.flag("LIT", true);
        step.flag("MORE", has_sum);
        step.constants("lamps", lamps);
        step
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}
