//! From what passes a filter to draw calls.

use super::block::{Block, Passes, triangles};
use super::{Batch, DrawFilter, GpuScene};
use crate::gpu::Gpu;
use crate::graph::Counts;
use std::ops::Range;
use wgpu::util::DrawIndexedIndirectArgs;

/// So many draws that bind the same are handed over in one call where the device takes them from a buffer.
const MANY: usize = 8;

/// The draws of a pass, in their order.
pub(super) struct DrawList<'s> {
    scene: &'s GpuScene,
    pub segments: Vec<Segment<'s>>,
    /// Draws of what passes only in part.
    partial: Vec<DrawIndexedIndirectArgs>,
    /// Those on the device, if they are taken from there.
    buffer: Option<wgpu::Buffer>,
}

/// Draws one after the other that bind the same.
pub(super) struct Segment<'s> {
    /// The first of them: its class and material are those of all.
    pub batch: &'s Batch,
    /// The buffers that their meshes lie in.
    pub page: usize,
    runs: Vec<Run>,
}

/// Draws that lie next to each other.
enum Run {
    /// Among those of whole batches, which are kept.
    Whole(Range<usize>),
    /// Among those of this list.
    Partial(Range<usize>),
}

impl Segment<'_> {
    fn binds_as(&self, batch: &Batch, page: usize) -> bool {
        (self.page, self.batch.class, self.batch.material) == (page, batch.class, batch.material)
    }

    fn push(&mut self, run: Run) {
        match (self.runs.last_mut(), run) {
            (Some(Run::Whole(last)), Run::Whole(next)) | (Some(Run::Partial(last)), Run::Partial(next))
                if last.end == next.start =>
            {
                last.end = next.end;
            }
            (_, run) => self.runs.push(run),
        }
    }
}

impl GpuScene {
    /// The draws of all that passes the filter.
    pub(super) fn draw_list(&self, gpu: &Gpu, filter: &DrawFilter) -> DrawList<'_> {
        let mut list = DrawList { scene: self, segments: Vec::new(), partial: Vec::new(), buffer: None };
        for (block, passes) in self.passing(filter) {
            match passes {
                Passes::All => list.push(block, Run::Whole(block.draws.clone())),
                _ => list.push_part(block, filter),
            }
        }
        list.upload(gpu);
        list
    }
}

impl DrawList<'_> {
    /// The draws of a block's members that pass.
    fn push_part(&mut self, block: &Block, filter: &DrawFilter) {
        let scene = self.scene;
        let first = self.partial.len();
        for batch in &scene.batches[block.batches.clone()] {
            let Some(place) = batch.place else { continue };
            self.partial.extend(batch.visible_runs(&scene.members, filter).map(|run| place.draw(run)));
        }
        if self.partial.len() > first {
            self.push(block, Run::Partial(first..self.partial.len()));
        }
    }

    fn push(&mut self, block: &Block, run: Run) {
        let batch = &self.scene.batches[block.batches.start];
        match self.segments.last_mut().filter(|last| last.binds_as(batch, block.page)) {
            Some(last) => last.push(run),
            None => self.segments.push(Segment { batch, page: block.page, runs: vec![run] }),
        }
    }

    fn upload(&mut self, gpu: &Gpu) {
        let many = |run: &Run| matches!(run, Run::Partial(draws) if draws.len() >= MANY);
        if gpu.draws_indirectly && self.segments.iter().flat_map(|segment| &segment.runs).any(many) {
            self.buffer = Some(gpu.storage("draws", &self.partial, wgpu::BufferUsages::INDIRECT));
        }
    }

    /// Records the draws of a segment, for which all is bound.
    pub fn record(&self, pass: &mut wgpu::RenderPass<'_>, segment: &Segment, counts: &mut Counts) {
        let kept = &self.scene.blocks;
        for run in &segment.runs {
            let (all, buffer, draws) = match run {
                Run::Whole(draws) => (&kept.draws, &kept.buffer, draws),
                Run::Partial(draws) => (&self.partial, &self.buffer, draws),
            };
            counts.draws += draws.len() as u64;
            counts.triangles += match run {
                Run::Whole(draws) => kept.triangles(draws),
                Run::Partial(draws) => self.partial[draws.clone()].iter().map(triangles).sum(),
            };
            match buffer.as_ref().filter(|_| draws.len() >= MANY) {
                Some(buffer) => {
                    let offset = draws.start * size_of::<DrawIndexedIndirectArgs>();
                    pass.multi_draw_indexed_indirect(buffer, offset as u64, draws.len() as u32);
                }
                None => all[draws.clone()].iter().for_each(|draw| record(pass, draw)),
            }
        }
    }
}

/// Records a draw by itself.
pub(super) fn record(pass: &mut wgpu::RenderPass<'_>, draw: &DrawIndexedIndirectArgs) {
    let indices = draw.first_index..draw.first_index + draw.index_count;
    pass.draw_indexed(indices, draw.base_vertex, draw.first_instance..draw.first_instance + draw.instance_count);
}
