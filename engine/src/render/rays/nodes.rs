//! The hierarchies of a scene on the device, in one of two layouts: rays wait for memory on graphics cards, and for
//! arithmetic on processors.

use super::RayError;
use super::boxes::{self, BoxLists};
use super::moving_boxes::MovingBoxes;
use super::wide_nodes::{self, WideNodes};
use super::words::{ROW, Words};
use crate::gpu::{Binding, Gpu, RayNodes};
use crate::scene::SceneBvh;

/// Lists of boxes.
pub(super) struct Lists {
    words: Words,
    movers: MovingBoxes,
    /// Boxes of a list of static objects.
    count: u32,
    /// Whether the boxes are stored as they are: see [`boxes`].
    are_exact: bool,
}

/// The hierarchies.
pub(super) enum Nodes {
    /// As lists of boxes.
    Lists(Lists),
    /// As nodes of eight children.
    Wide(WideNodes),
}

impl Nodes {
    pub(super) fn new(gpu: &Gpu) -> Self {
        let movers = MovingBoxes::new(&[], false, [0; 2]);
        Self::Lists(Lists { words: Words::new(gpu, "ray boxes", 1), movers, count: 0, are_exact: false })
    }

    /// Whether the layout is the one for a scene on this device.
    pub(super) fn suit(&self, gpu: &Gpu, bvh: &SceneBvh) -> bool {
        matches!(self, Self::Wide(_)) == (gpu.ray_nodes == RayNodes::Wide && wide_nodes::suit(bvh))
    }

    /// To be bound as `nodes`.
    pub(super) fn binding(&self) -> Binding<'_> {
        match self {
            Self::Lists(lists) => Binding::Texture(lists.words.view()),
            Self::Wide(nodes) => Binding::Buffer(nodes.buffer()),
        }
    }

    /// What `trace` of `lib/walk.wgsl` is to know: the boxes of a list, or one node; 0 if there is nothing to meet.
    pub(super) fn root(&self) -> u32 {
        match self {
            Self::Lists(lists) => lists.count,
            Self::Wide(nodes) => u32::from(nodes.hold_anything()),
        }
    }

    /// Whether the nodes have eight children.
    pub(super) fn are_wide(&self) -> bool {
        matches!(self, Self::Wide(_))
    }

    /// Whether lists store boxes as they are.
    pub(super) fn are_exact(&self) -> bool {
        matches!(self, Self::Lists(lists) if lists.are_exact)
    }

    /// First triangle of a moving object.
    pub(super) fn first_triangle(&self, object: usize) -> u32 {
        match self {
            Self::Lists(lists) => lists.movers.first_triangle(object),
            Self::Wide(nodes) => nodes.first_triangle(object),
        }
    }

    /// Uploads all static objects in the layout that suits the scene, and makes room for moving ones.
    ///
    /// # Errors
    /// If the device cannot bind that much.
    pub(super) fn update_statics(&mut self, gpu: &Gpu, bvh: &SceneBvh) -> Result<(), RayError> {
        if !self.suit(gpu, bvh) {
            *self = if self.are_wide() { Self::new(gpu) } else { Self::Wide(WideNodes::new(gpu)) };
        }
        match self {
            Self::Lists(lists) => lists.update_statics(gpu, bvh),
            Self::Wide(nodes) => nodes.update_statics(gpu, &bvh.statics.bvh, &bvh.counts_of_movers()),
        }
    }

    /// Uploads moving objects that have changed since a version which the device holds; none: all.
    pub(super) fn update_movers(&mut self, gpu: &Gpu, bvh: &SceneBvh, since: Option<u64>) {
        let (statics, movers) = (&bvh.statics, &bvh.movers);
        match self {
            Self::Lists(lists) => {
                let size = statics.bounds().union(&movers.bounds()).size().max_element().max(f32::MIN_POSITIVE);
                lists.movers.update(gpu, &lists.words, movers, size, since);
            }
            Self::Wide(nodes) => nodes.update_movers(gpu, &statics.bvh, movers, since),
        }
    }
}

impl Lists {
    fn update_statics(&mut self, gpu: &Gpu, bvh: &SceneBvh) -> Result<(), RayError> {
        let statics = &bvh.statics.bvh;
        let counts = bvh.counts_of_movers();
        let moving = counts.iter().sum::<usize>();
        let is_passage = statics.nodes.is_empty() && moving > 0;
        let exact = match is_passage {
            true => boxes::are_exact(bvh.trees()),
            false => boxes::are_exact(std::iter::once(statics)),
        };
        let static_texels = boxes::texel_count(if is_passage { 1 } else { statics.nodes.len() }, exact);
        let moving_texels = if moving > 0 { MovingBoxes::texel_count(&counts, exact) } else { 0 };
        let rows = (static_texels + moving_texels).div_ceil(ROW as usize);
        self.words.reserve(gpu, "ray boxes", "hierarchies", rows)?;
        let first = [static_texels / boxes::texels_of_box(exact), statics.order.len()].map(|first| first as u32);
        self.movers = MovingBoxes::new(&counts, exact, first);
        let next = if moving > 0 { first[0] } else { 0 };
        let lists = if is_passage {
            BoxLists::passage(exact, next)
        } else {
            BoxLists::new(statics, exact, next, bvh.statics.is_split)
        };
        self.words.write(gpu, 0, &lists.texels);
        (self.count, self.are_exact) = (lists.box_count, exact);
        Ok(())
    }
}
