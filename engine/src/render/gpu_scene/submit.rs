//! From what passes a filter to draw calls.

use super::{Batch, DrawFilter, GpuScene};
use crate::gpu::Gpu;
use crate::graph::Counts;
use std::ops::Range;
use wgpu::util::DrawIndexedIndirectArgs;

/// So many draws that bind the same are handed over in one call where the device takes them from a buffer.
const MANY: usize = 8;

/// The draws of a pass, in their order.
pub(super) struct DrawList<'s> {
    pub segments: Vec<Segment<'s>>,
    draws: Vec<DrawIndexedIndirectArgs>,
    /// The draws on the device, if they are taken from there.
    buffer: Option<wgpu::Buffer>,
}

/// Draws one after the other that bind the same.
pub(super) struct Segment<'s> {
    /// The first of them: its class and material are those of all.
    pub batch: &'s Batch,
    /// The buffers that their meshes lie in.
    pub page: usize,
    draws: Range<usize>,
}

impl Segment<'_> {
    fn binds_as(&self, batch: &Batch, page: usize) -> bool {
        (self.page, self.batch.class, self.batch.material) == (page, batch.class, batch.material)
    }
}

impl GpuScene {
    /// The draws of all that passes the filter.
    pub(super) fn draw_list(&self, gpu: &Gpu, filter: &DrawFilter) -> DrawList<'_> {
        let mut list = DrawList { segments: Vec::<Segment>::new(), draws: Vec::new(), buffer: None };
        for batch in self.passing(filter) {
            let Some(place) = batch.place else { continue };
            let first = list.draws.len();
            list.draws.extend(batch.visible_runs(&self.members, filter).map(|run| place.draw(run)));
            let draws = first..list.draws.len();
            match list.segments.last_mut().filter(|last| last.binds_as(batch, place.page)) {
                _ if draws.is_empty() => {}
                Some(last) => last.draws.end = draws.end,
                None => list.segments.push(Segment { batch, page: place.page, draws }),
            }
        }
        list.upload(gpu);
        list
    }
}

impl DrawList<'_> {
    fn upload(&mut self, gpu: &Gpu) {
        if gpu.draws_indirectly && self.segments.iter().any(|segment| segment.draws.len() >= MANY) {
            self.buffer = Some(gpu.storage("draws", &self.draws, wgpu::BufferUsages::INDIRECT));
        }
    }

    /// Records the draws of a segment, for which all is bound.
    pub fn record(&self, pass: &mut wgpu::RenderPass<'_>, segment: &Segment, counts: &mut Counts) {
        let draws = &self.draws[segment.draws.clone()];
        counts.draws += draws.len() as u64;
        counts.triangles +=
            draws.iter().map(|draw| u64::from(draw.instance_count) * u64::from(draw.index_count / 3)).sum::<u64>();
        match self.buffer.as_ref().filter(|_| draws.len() >= MANY) {
            Some(buffer) => {
                let offset = segment.draws.start * size_of::<DrawIndexedIndirectArgs>();
                pass.multi_draw_indexed_indirect(buffer, offset as u64, draws.len() as u32);
            }
            None => draws.iter().for_each(|draw| record(pass, draw)),
        }
    }
}

/// Records a draw by itself.
pub(super) fn record(pass: &mut wgpu::RenderPass<'_>, draw: &DrawIndexedIndirectArgs) {
    let indices = draw.first_index..draw.first_index + draw.index_count;
    pass.draw_indexed(indices, draw.base_vertex, draw.first_instance..draw.first_instance + draw.instance_count);
}
