//! The scene's objects as what a raster pass draws.

use super::{DrawFilter, GpuScene, MaterialClass, Motion};
use crate::gpu::RasterKey;
use crate::graph::{DrawBindings, Draws, PassContext, PassError, hash};
use crate::scene::Frustum;
use std::rc::Rc;

/// Which objects in a frustum are drawn.
pub(in crate::render) type FilterOf = for<'f> fn(&'f Frustum) -> DrawFilter<'f>;

/// The pipeline of a class of materials.
pub(in crate::render) type PipelineOf<'a> = Rc<dyn Fn(MaterialClass) -> RasterKey + 'a>;

/// The objects that pass a filter. The shader finds the view's uniform under the name `view` and, where it declares them,
/// `instances` and the material's bindings.
pub(in crate::render) struct SceneDraws<'a> {
    /// The scene.
    pub scene: &'a GpuScene,
    /// What the view sees.
    pub frustum: Frustum,
    /// Which objects of it are drawn.
    pub filter: FilterOf,
    /// Of those, which by whether they move.
    pub motion: Motion,
    /// The pipelines.
    pub pipeline: PipelineOf<'a>,
}

impl SceneDraws<'_> {
    fn filter(&self) -> DrawFilter<'_> {
        (self.filter)(&self.frustum).of(self.motion)
    }
}

impl Draws for SceneDraws<'_> {
    fn key(&self) -> u64 {
        let moving = (self.motion != Motion::Still).then(|| self.scene.moving(&[self.filter()]));
        hash(&(self.scene.still_key(), moving, (self.pipeline)(MaterialClass::SIMPLEST)))
    }

    fn is_empty(&self) -> bool {
        !self.scene.any_visible(&self.filter())
    }

    fn draw(
        &self,
        cx: &mut PassContext,
        pass: &mut wgpu::RenderPass<'_>,
        bound: &DrawBindings,
    ) -> Result<(), PassError> {
        let pipeline = |class| {
            let mut pipeline = (self.pipeline)(class);
            pipeline.defs.extend(bound.defines.iter().cloned());
            pipeline
        };
        self.scene.draw(cx, pass, &bound.group, &self.filter(), pipeline)
    }
}
