//! Blocks of batches: what lies wholly within a view, or wholly outside, is found without a look at each primitive, and
//! the draws of what lies within it whole are on the device already (hierarchical view volume culling, Clark 1976).

use super::{Batch, DrawFilter, GpuScene, Member};
use crate::gpu::Gpu;
use crate::scene::Aabb;
use std::ops::Range;
use wgpu::util::DrawIndexedIndirectArgs;

/// Most batches of a block: few enough that a view's border cuts few blocks, many enough that they cost nothing.
const MOST: usize = 64;

/// Batches one after the other that bind the same and pass the same filters.
pub(super) struct Block {
    pub batches: Range<usize>,
    /// Their draws among those of all batches.
    pub draws: Range<usize>,
    /// The buffers that their meshes lie in.
    pub page: usize,
    bounds: Aabb,
    /// Whether all of its members cast shadows.
    all_cast: bool,
    /// The least extent as a wall of any of its members.
    least_wall: f32,
    /// Whether a member has no place in space, and is never seen.
    any_empty: bool,
}

/// How much of a block passes a filter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Passes {
    Nothing,
    /// Perhaps a part: each member must be asked.
    Part,
    All,
}

impl Block {
    fn new(batch: usize, page: usize, draw: usize) -> Self {
        Self {
            batches: batch..batch + 1,
            draws: draw..draw + 1,
            page,
            bounds: Aabb::EMPTY,
            all_cast: true,
            least_wall: f32::INFINITY,
            any_empty: false,
        }
    }

    /// Whether another batch may be part of it.
    fn takes(&self, batches: &[Batch], batch: &Batch, page: usize) -> bool {
        let binds = |batch: &Batch| (batch.moving, batch.class, batch.material, batch.nowhere_opaque);
        let first = &batches[self.batches.start];
        self.batches.len() < MOST && self.page == page && binds(first) == binds(batch)
    }

    /// Properties that all of its members share.
    fn sum_up<'m>(&mut self, members: impl Iterator<Item = &'m Member>) {
        (self.bounds, self.all_cast, self.least_wall, self.any_empty) = (Aabb::EMPTY, true, f32::INFINITY, false);
        for member in members {
            self.bounds = self.bounds.union(&member.bounds);
            self.all_cast &= member.casts_shadow;
            self.least_wall = self.least_wall.min(member.wall);
            self.any_empty |= member.bounds.is_empty();
        }
    }

    /// How much of it passes, given that its batches do.
    pub fn passes(&self, filter: &DrawFilter) -> Passes {
        if !filter.frustum.intersects(&self.bounds) {
            return Passes::Nothing;
        }
        let each = !self.any_empty
            && (self.all_cast || !filter.casters_only)
            && !(self.least_wall < filter.least_wall)
            && filter.frustum.holds(&self.bounds);
        if each { Passes::All } else { Passes::Part }
    }
}

/// All blocks of a scene and the draws of whole batches, on the host and on the device.
#[derive(Default)]
pub(super) struct Blocks {
    pub blocks: Vec<Block>,
    pub draws: Vec<DrawIndexedIndirectArgs>,
    /// Triangles of all draws before each, and of all.
    triangles: Vec<u64>,
    pub buffer: Option<wgpu::Buffer>,
}

impl Blocks {
    /// The blocks of a scene's batches.
    pub fn new(gpu: &Gpu, batches: &[Batch], members: &[Member]) -> Self {
        let mut all = Self { triangles: vec![0], ..Self::default() };
        for (index, batch) in batches.iter().enumerate() {
            let Some(place) = batch.place else { continue };
            let draw = place.draw(batch.instances.clone());
            match all.blocks.last_mut().filter(|last| last.takes(batches, batch, place.page)) {
                Some(last) => {
                    last.batches.end = index + 1;
                    last.draws.end += 1;
                }
                None => all.blocks.push(Block::new(index, place.page, all.draws.len())),
            }
            all.triangles.push(all.triangles[all.draws.len()] + triangles(&draw));
            all.draws.push(draw);
        }
        all.sum_up(batches, members, |_| true);
        if gpu.draws_indirectly && !all.draws.is_empty() {
            all.buffer = Some(gpu.storage("draws of all batches", &all.draws, wgpu::BufferUsages::INDIRECT));
        }
        all
    }

    /// Updates blocks with members that changed.
    pub fn sum_up(&mut self, batches: &[Batch], members: &[Member], which: impl Fn(&Batch) -> bool) {
        for block in self.blocks.iter_mut().filter(|block| which(&batches[block.batches.start])) {
            block.sum_up(batches[block.batches.clone()].iter().flat_map(|batch| batch.of(members)));
        }
    }

    /// Triangles of some of the draws.
    pub fn triangles(&self, draws: &Range<usize>) -> u64 {
        self.triangles[draws.end] - self.triangles[draws.start]
    }
}

/// Triangles of a draw.
pub(super) fn triangles(draw: &DrawIndexedIndirectArgs) -> u64 {
    u64::from(draw.instance_count) * u64::from(draw.index_count / 3)
}

impl GpuScene {
    /// Blocks of which the filter lets something pass, and how much at most.
    pub(super) fn passing<'s>(&'s self, filter: &'s DrawFilter) -> impl Iterator<Item = (&'s Block, Passes)> {
        let blocks = self.blocks.blocks.iter().filter(|block| self.batches[block.batches.start].passes(filter));
        blocks.map(|block| (block, block.passes(filter))).filter(|(_, passes)| *passes != Passes::Nothing)
    }

    /// Whether anything of a block passes the filter.
    pub(super) fn any_passes(&self, (block, passes): (&Block, Passes), filter: &DrawFilter) -> bool {
        let members = || self.batches[block.batches.clone()].iter().flat_map(|batch| batch.of(&self.members));
        passes == Passes::All || members().any(|member| member.visible(filter))
    }
}
