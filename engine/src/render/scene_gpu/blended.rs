//! Blended surfaces, from the farthest to the nearest.

use super::{Batch, Bound, DrawFilter, GpuScene, MaterialClass, Member, submit};
use crate::gpu::{Binding, Pipeline, RasterKey};
use crate::graph::{PassContext, PassError};
use glam::Vec3;
use std::ops::Range;
use std::sync::Arc;

/// Which side of a surface is drawn. Of a double-sided one first the back, which lies farther where the surface is
/// closed, then the front.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// Seen from behind.
    Back,
    /// Seen from the front.
    Front,
}

impl Side {
    /// The face that the rasterizer culls.
    pub fn cull_mode(self) -> wgpu::Face {
        match self {
            Self::Back => wgpu::Face::Front,
            Self::Front => wgpu::Face::Back,
        }
    }
}

struct Instance<'s> {
    distance: f32,
    batch: &'s Batch,
    index: u32,
    member: &'s Member,
}

impl GpuScene {
    /// Whether any blended primitive passes the filter.
    pub fn any_blended(&self, filter: &DrawFilter) -> bool {
        let is_blended = |batches: &Range<usize>| self.batches[batches.start].class.blended;
        self.passing(filter).filter(|(block, _)| is_blended(&block.batches)).any(|block| self.any_passes(block, filter))
    }

    /// Draws all blended primitives that pass the filter, sorted by the distance of their boxes' centres along the
    /// `forward` direction of the `eye`; primitives at the same distance by their identity. Each is drawn once a group
    /// of `groups`, which are bound as group 2. `key` gives the pipeline of a class and a side; `prepare` binds what
    /// else a new pipeline wants.
    ///
    /// # Errors
    /// A shader that does not compile, or that declares a binding that is not there.
    #[expect(clippy::too_many_arguments, reason = "a pass, its view, an order and what to bind")]
    pub fn draw_blended(
        &self,
        cx: &mut PassContext,
        pass: &mut wgpu::RenderPass<'_>,
        group: &[(&str, Binding<'_>)],
        filter: &DrawFilter,
        (eye, forward): (Vec3, Vec3),
        key: impl Fn(MaterialClass, Side) -> RasterKey,
        mut prepare: impl FnMut(&Pipeline, &mut wgpu::RenderPass<'_>) -> Result<Vec<wgpu::BindGroup>, PassError>,
    ) -> Result<(), PassError> {
        let gpu = cx.gpu;
        let mut current: Option<(MaterialClass, Side, Arc<Pipeline>, Vec<wgpu::BindGroup>)> = None;
        let mut bound = Bound::default();
        for Instance { batch, index, .. } in self.sorted_blended(filter, eye, forward) {
            let Some(place) = batch.place else { continue };
            let sides: &[Side] = if batch.class.double_sided { &[Side::Back, Side::Front] } else { &[Side::Front] };
            for &side in sides {
                if current.as_ref().is_none_or(|(class, s, ..)| (*class, *s) != (batch.class, side)) {
                    let pipeline = self.set_pipeline(gpu, pass, group, &key(batch.class, side))?;
                    let groups = prepare(&pipeline, pass)?;
                    current = Some((batch.class, side, pipeline, groups));
                    bound.material = None;
                }
                let Some((.., pipeline, groups)) = &current else { continue };
                self.set_batch(gpu, pass, pipeline, batch, place.page, &mut bound)?;
                let draw = place.draw(index..index + 1);
                for group in groups {
                    pass.set_bind_group(2, group, &[]);
                    submit::record(pass, &draw);
                    cx.counts().draws += 1;
                    cx.counts().triangles += u64::from(draw.index_count / 3);
                }
            }
        }
        Ok(())
    }

    fn sorted_blended(&self, filter: &DrawFilter, eye: Vec3, forward: Vec3) -> Vec<Instance<'_>> {
        let blended = self.batches.iter().filter(|batch| batch.class.blended);
        let instances = blended.flat_map(|batch| {
            let members = batch.of(&self.members).iter().zip(batch.instances.clone());
            members.map(move |(member, index)| {
                let distance = (member.bounds.center() - eye).dot(forward);
                Instance { distance, batch, index, member }
            })
        });
        let mut visible: Vec<Instance> = instances.filter(|instance| instance.member.visible(filter)).collect();
        visible.sort_by(|a, b| b.distance.total_cmp(&a.distance).then(a.member.id.cmp(&b.member.id)));
        visible
    }
}
